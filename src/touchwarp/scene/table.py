"""A strict reader of the scene file's tables: every key known, every value of its type."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from touchwarp.errors import SceneError, TouchwarpError
from touchwarp.scene.nearest import suggest

_MISSING: Any = object()


class Table:
    """One table of a scene file, with its place in the file for messages.

    Args:
        entries: what the file holds.
        where: the table's key path, such as "prop[mug].goal"; "" at the top.
        known: the keys that the table may hold; any other is an error.
    """

    def __init__(self, entries: Any, where: str, known: Iterable[str]) -> None:
        if not isinstance(entries, dict):
            raise SceneError(f"{where} is {spell(entries)}; a table is needed.")
        self.entries: dict[str, Any] = entries
        self.where = where
        known = tuple(known)
        for key in entries:
            if key not in known:
                raise SceneError(f"unknown key '{self.path(key)}'. {suggest(key, known)}")

    def __contains__(self, key: str) -> bool:
        return key in self.entries

    def path(self, key: str) -> str:
        """The key's full path in the file."""
        return f"{self.where}.{key}" if self.where else key

    def raw(self, key: str, default: Any = _MISSING) -> Any:
        """The value as it stands in the file."""
        if key in self.entries:
            return self.entries[key]
        if default is _MISSING:
            raise SceneError(f"{self.path(key)} is missing; it is needed here.")
        return default

    def number(self, key: str, default: Any = _MISSING) -> Any:
        """A finite number."""
        value = self.raw(key, default)
        if key not in self.entries:
            return value
        return _number(value, self.path(key))

    def text(self, key: str, default: Any = _MISSING) -> Any:
        """A text."""
        value = self.raw(key, default)
        if key in self.entries and not isinstance(value, str):
            raise SceneError(f"{self.path(key)} is {spell(value)}; a text is needed.")
        return value

    def flag(self, key: str) -> bool:
        """true or false."""
        value = self.raw(key)
        if not isinstance(value, bool):
            raise SceneError(f"{self.path(key)} is {spell(value)}; true or false is needed.")
        return value

    def choice(self, key: str, options: Iterable[str], default: Any = _MISSING) -> Any:
        """One of several words."""
        value = self.text(key, default)
        options = tuple(options)
        if key in self.entries and value not in options:
            raise SceneError(f"{self.path(key)} is '{value}'. {suggest(value, options)}")
        return value

    def vector(self, key: str, length: int, default: Any = _MISSING) -> Any:
        """A tuple of `length` finite numbers."""
        value = self.raw(key, default)
        if key not in self.entries:
            return value
        return _vector(value, length, self.path(key))

    def rotation(self, key: str, dimension: int, default: Any = _MISSING) -> Any:
        """Degrees: three angles in space, one in the plane."""
        return self.number(key, default) if dimension == 2 else self.vector(key, 3, default)

    def rows(self, key: str, width: int, count: int | None = None) -> list[tuple[float, ...]]:
        """A list of rows of `width` finite numbers each, `count` of them if that is given."""
        value = self.raw(key)
        if not isinstance(value, list) or (count is not None and len(value) != count):
            shape = f"{count} rows" if count is not None else "a list of rows"
            raise SceneError(
                f"{self.path(key)} is {spell(value)}; {shape} of {width} numbers is needed."
            )
        return [_vector(row, width, f"{self.path(key)}[{i}]") for i, row in enumerate(value)]

    def table(self, key: str, known: Iterable[str]) -> Table:
        """A table within this one; empty where the file has none."""
        return Table(self.entries.get(key, {}), self.path(key), known)

    def tables(self, key: str) -> list[tuple[str, Any]]:
        """An array of tables: (key path, entries) of each, named where the entry has a name."""
        value = self.entries.get(key, [])
        if not isinstance(value, list):
            raise SceneError(
                f"{self.path(key)} is {spell(value)}; an array of tables is needed: "
                f"write [[{self.path(key)}]] with two brackets."
            )
        named = []
        for i, entries in enumerate(value):
            name = entries.get("name") if isinstance(entries, dict) else None
            label = name if isinstance(name, str) else f"#{i + 1}"
            named.append((f"{self.path(key)}[{label}]", entries))
        return named


@contextmanager
def within(place: object) -> Iterator[None]:
    """Put a place, such as a file's name, before the message of any error raised inside."""
    try:
        yield
    except TouchwarpError as error:
        error.args = (f"{place}: {error}",)
        raise


def spell(value: Any) -> str:
    """A value with its type, in a scene writer's words."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f"the text '{value}'"
    if isinstance(value, (int, float)):
        return f"the number {value}"
    if isinstance(value, list):
        return f"a list of {len(value)}"
    if isinstance(value, dict):
        return "a table"
    return f"{value} ({type(value).__name__})"


def _number(value: Any, path: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise SceneError(f"{path} is {spell(value)}; a number is needed.")
    if not math.isfinite(value):
        raise SceneError(f"{path} is {value}; a finite number is needed.")
    return float(value)


def _vector(value: Any, length: int, path: str) -> tuple[float, ...]:
    if not isinstance(value, list) or len(value) != length:
        raise SceneError(f"{path} is {spell(value)}; a list of {length} numbers is needed.")
    return tuple(_number(entry, f"{path}[{i}]") for i, entry in enumerate(value))
