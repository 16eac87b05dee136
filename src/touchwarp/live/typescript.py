"""The messages as TypeScript types; `python -m touchwarp.live.typescript` writes them."""

from __future__ import annotations

import types
import typing
from pathlib import Path
from typing import Annotated, Any, Literal, Union

from touchwarp.live import messages
from touchwarp.live.messages import Message

TARGET = Path("web", "page", "src", "live", "messages.ts")

HEADER = """\
// Made by `python -m touchwarp.live.typescript` from src/touchwarp/live/messages.py: change that.
"""

# Aliases of the Python side that keep their name here; each may use those before it.
_ALIASES = ("Vector", "Row", "Matrix", "Status", "Task")
_NAMED: dict[Any, str] = {}
_PLAIN: dict[Any, str] = {
    str: "string",
    float: "number",
    int: "number",
    bool: "boolean",
    types.NoneType: "null",
}


def typescript() -> str:
    """The whole file."""
    models = [
        value
        for value in vars(messages).values()
        if isinstance(value, type) and issubclass(value, Message) and value is not Message
    ]
    _NAMED.clear()
    aliases = []
    for name in _ALIASES:
        alias = getattr(messages, name)
        aliases.append(f"export type {name} = {type_text(alias)};")
        _NAMED[alias] = name
    parts = [HEADER, "\n".join([*aliases, ""]), *(_interface(model) for model in models)]
    for name in ("FromServer", "FromPage"):
        parts.append(f"export type {name} = {type_text(getattr(messages, name))};\n")
    return "\n".join(parts)


def type_text(annotation: Any) -> str:
    """The TypeScript of one annotation.

    Raises:
        TypeError: the annotation is of a kind that messages have not used so far.
    """
    if annotation in _NAMED:
        return _NAMED[annotation]
    if annotation in _PLAIN:
        return _PLAIN[annotation]
    if isinstance(annotation, type) and issubclass(annotation, Message):
        return annotation.__name__
    origin, arguments = typing.get_origin(annotation), typing.get_args(annotation)
    if origin is Annotated:
        return type_text(arguments[0])
    if origin is Literal:
        return " | ".join(_literal(value) for value in arguments)
    if origin in (Union, types.UnionType):
        return " | ".join(type_text(a) for a in arguments)
    if origin is tuple and arguments[-1] is Ellipsis:
        return f"readonly {_grouped(type_text(arguments[0]))}[]"
    if origin is tuple:
        return f"readonly [{', '.join(type_text(a) for a in arguments)}]"
    if origin is dict:
        return f"Readonly<Record<string, {type_text(arguments[1])}>>"
    raise TypeError(f"{annotation!r} has no TypeScript yet; add it to touchwarp.live.typescript.")


def _interface(model: type[Message]) -> str:
    summary = (model.__doc__ or "").strip().splitlines()[0]
    hints = typing.get_type_hints(model, include_extras=True)
    lines = [f"/** {summary} */", f"export interface {model.__name__} {{"]
    for name, field in model.model_fields.items():
        # What has a default may be left out, but for the tag that tells the messages apart.
        optional = "" if field.is_required() or name == "kind" else "?"
        lines.append(f"  readonly {name}{optional}: {type_text(hints[name])};")
    return "\n".join([*lines, "}", ""])


def _literal(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else f'"{value}"'


def _grouped(text: str) -> str:
    return f"({text})" if " " in text else text


if __name__ == "__main__":
    TARGET.write_text(typescript(), encoding="utf-8")
