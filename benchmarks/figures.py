"""What every benchmark prints: figures beside what is claimed of them, as a table or JSON."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Figure:
    """A measured number and the claim on it.

    Attributes:
        claim: what is measured.
        value: the number.
        unit: of the number.
        at_most, at_least: what is claimed; neither where the figure is only told.
    """

    claim: str
    value: float
    unit: str
    at_most: float | None = None
    at_least: float | None = None

    @property
    def holds(self) -> bool | None:
        """Whether the claim holds; None where nothing is claimed."""
        if self.at_most is None and self.at_least is None:
            return None
        return (self.at_most is None or self.value <= self.at_most) and (
            self.at_least is None or self.value >= self.at_least
        )

    @property
    def limit(self) -> str:
        """The claim in signs, such as "≤ 0.05"."""
        parts = [(self.at_least, "≥"), (self.at_most, "≤")]
        return " ".join(f"{sign} {value:g}" for value, sign in parts if value is not None)


def print_table(title: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Columns as wide as their contents; numbers stand to the right."""
    widths = [max(len(row[k]) for row in (head, *rows)) for k in range(len(head))]
    print(f"\n{title}")
    for row in (head, ["-" * width for width in widths], *rows):
        cells = []
        for text, width in zip(row, widths, strict=True):
            numeric = text[:1].isdigit() or (text[:1] in "-–" and text[1:2].isdigit())
            cells.append(text.rjust(width) if numeric else text.ljust(width))
        print("  ".join(cells).rstrip())


def print_figures(title: str, figures: Sequence[Figure]) -> None:
    """One line a figure: value, claim, whether it holds."""
    words = {True: "holds", False: "MISSED", None: ""}
    rows = [[f.claim, f"{f.value:.4g} {f.unit}", f.limit, words[f.holds]] for f in figures]
    head = ["figure", "measured", "claimed", ""]
    print_table(f"{title} (load average {os.getloadavg()[0]:.1f})", head, rows)


def save_json(path: Path, figures: Sequence[Figure], **more: Any) -> None:
    """The figures, the machine and whatever else, as one JSON file."""
    machine = {"cores": os.cpu_count(), "processor": platform.processor() or platform.machine()}
    rows = [asdict(figure) | {"holds": figure.holds} for figure in figures]
    text = json.dumps({"figures": rows, "machine": machine, **more}, indent=1)
    partial = path.with_name(path.name + ".part")
    partial.write_text(text + "\n")
    partial.replace(path)
