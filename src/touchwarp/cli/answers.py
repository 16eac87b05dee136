"""What `touchwarp new` asks: from options, from the terminal, or as proposed."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from touchwarp.errors import SceneError, TouchwarpError


@dataclass(frozen=True)
class Answers:
    """Where answers come from.

    Attributes:
        yes: take every proposal, ask nothing.
    """

    yes: bool

    def ask(self, question: str, proposed: str, option: str, check: Callable[[str], object]) -> str:
        """One answer, asked for until `check` raises nothing.

        Where there is no terminal to ask, the message names `option`.
        """

        def checked(answer: str) -> str:
            try:
                check(answer)
            except TouchwarpError as error:
                raise click.UsageError(str(error)) from error
            return answer

        def prompt() -> str:
            return str(click.prompt(question, default=proposed, value_proc=checked))

        return str(self._answer(question, proposed, option, prompt))

    def confirm(self, question: str, option: str) -> bool:
        """Yes or no; yes is proposed."""
        return bool(self._answer(question, "yes", option, lambda: click.confirm(question, True)))

    def _answer(self, question: str, proposed: str, option: str, prompt: Callable[[], Any]) -> Any:
        if self.yes:
            click.echo(f"{question}: {proposed} (proposed)")
            return proposed
        try:
            return prompt()
        except click.Abort:
            if sys.stdin.isatty():
                raise
            click.echo()  # ends the line of the question
            raise SceneError(
                f"a question needs an answer, and there is no terminal to ask: '{question}'. Give "
                f"{option}, or --yes to take what is proposed ({proposed})."
            ) from None


@dataclass(frozen=True)
class Settled:
    """How a mesh file is to be read.

    Attributes:
        path: the file.
        unit: a unit's name, or the unit in m.
        up: its up axis.
        notes: what was proposed, and what looks odd.
    """

    path: Path
    unit: str | float
    up: str
    notes: list[str]


def settle_reading(
    path: Path, unit: str | None, up: str | None, answers: Answers, prefix: str
) -> Settled:
    """The unit and up axis of a mesh file: as given, as its format says, or as answered.

    Args:
        path: the mesh.
        unit, up: from options, or None.
        answers: where the rest comes from.
        prefix: of the options' names: "" or "virtual-".

    Raises:
        SceneError: the file is no mesh, a unit or an axis is unknown, or nobody is there to ask.
    """
    from touchwarp.scan.reading import propose_reading
    from touchwarp.scene.units import METRES, metres_per_unit, up_rotation

    read = propose_reading(path)
    notes = []
    chosen = unit if unit is not None else read.unit
    if unit is None and not read.unit_known:
        longest_mm = max(read.size_mm) / METRES[read.unit]
        sizes = ", ".join(
            f"{_length(longest_mm * METRES[u])} if it is in {u}" for u in ("mm", "cm", "m", "in")
        )
        chosen = answers.ask(
            f"{path.name} is {sizes}. Its unit", read.unit, f"--{prefix}unit", _unit
        )
        notes.append(f"the file tells no unit; {chosen} was chosen by its size")
    settled = _unit(chosen)
    longest = max(read.size_mm) * metres_per_unit(settled) / METRES[read.unit]
    if read.unit_known and unit is None and not read.plausible:
        notes.append(
            f"{longest:.4g} mm long, as the file says: odd for a thing held in the hand; if the "
            f"file is wrong, say --{prefix}unit or --scale"
        )
        click.echo(f"Note: {path.name} is {notes[-1]}.")
    axis = up if up is not None else read.up
    if up is None and not read.up_known and read.up != "z":
        axis = answers.ask(
            f"{path.name} seems to stand on its {_foot(read.up)} side. Its up axis",
            read.up,
            f"--{prefix}up",
            up_rotation,
        )
        notes.append(f"the file tells no up axis; {axis} was chosen by its flat foot")
    up_rotation(axis)
    return Settled(path, settled, axis, notes)


def _unit(answer: str) -> str | float:
    """A unit's name, or its length in m; raises SceneError where it is neither."""
    from touchwarp.scene.units import metres_per_unit

    unit: str | float = answer
    with contextlib.suppress(ValueError):
        unit = float(answer)
    metres_per_unit(unit)
    return unit


def _length(mm: float) -> str:
    """A length as a person would say it: "0.26 mm", "260 mm", "26 m"."""
    return f"{mm:.3g} mm" if mm < 1000 else f"{mm / 1000:,.3g} m"


def _foot(up: str) -> str:
    return up[1:] if up.startswith("-") else f"-{up}"
