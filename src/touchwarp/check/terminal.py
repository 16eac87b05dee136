"""The certificate in the terminal."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from touchwarp.check.summary import GROUPS, headline, sentences

if TYPE_CHECKING:
    from touchwarp.check.report import Check, Report

MARKS = {
    "pass": ("✓", "green"),
    "warn": ("!", "yellow"),
    "fail": ("✗", "bold red"),
    "unknown": ("?", "blue"),
    "told": ("·", "dim"),
}


def mark_of(check: Check) -> str:
    """The key of `MARKS` for a check: told ones have no verdict."""
    return "told" if check.group == "told" and check.status == "pass" else check.status


def lines(report: Report, width: int) -> Iterator[Text | Table | Padding]:
    """The report's parts for a rich console of this width."""
    symbol, style = MARKS[report.status]
    yield Text.assemble((f"{symbol} ", style), (headline(report), "bold"))
    for sentence in sentences(report):
        yield Padding(Text(sentence), (0, 0, 0, 2))
    for group, (title, what) in GROUPS.items():
        checks = [c for c in report.checks if c.group == group]
        if not checks:
            continue
        yield Text.assemble("\n", (title, "bold"), (f"  {what}", "dim"))
        yield _table(checks, width)


def _table(checks: list[Check], width: int) -> Table:
    several = len({c.subject for c in checks if c.subject}) > 1
    table = Table.grid(padding=(0, 2))
    table.add_column(width=1, no_wrap=True)
    table.add_column(ratio=None, min_width=24)
    table.add_column(justify="right", no_wrap=True)
    table.add_column(no_wrap=True, style="dim")
    if width >= 96:
        table.add_column(no_wrap=True, style="dim")
    for check in checks:
        symbol, style = MARKS[mark_of(check)]
        title = f"{check.title} ({check.subject})" if several and check.subject else check.title
        row: list[Text | str] = [
            Text(symbol, style),
            Text(title),
            Text(check.value_text, style if check.status in ("warn", "fail") else ""),
            check.limit_text,
        ]
        if width >= 96:
            row.append(check.where_text)
        table.add_row(*row)
    return table
