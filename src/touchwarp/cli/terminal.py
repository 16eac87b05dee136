"""What the command shows while it works: progress, timings, tables. Results go to stdout, the
rest to stderr."""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from rich.console import Console

Progress = Callable[[str, float], None]
"""Called with the step's name and the part of it that is done, 0 to 1."""


def configure(verbose: bool) -> None:
    """Send the library's log to stderr: warnings always, each step with its time if verbose."""
    logger = logging.getLogger("touchwarp")
    logger.handlers.clear()
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(
        logging.Formatter("%(relativeCreated)7.0f ms  %(message)s" if verbose else "%(message)s")
    )
    logger.addHandler(handler)
    logger.setLevel(logging.DEBUG if verbose else logging.WARNING)


def say_error(message: str) -> None:
    """One message on stderr, in the form that click gives its own."""
    click.echo(f"Error: {message}", err=True)


def stdout_console() -> Console:
    """A rich console on stdout; without a terminal, plain text 100 columns wide."""
    from rich.console import Console

    return Console(highlight=False, width=None if sys.stdout.isatty() else 100)


def show_facts(title: str, rows: Iterable[tuple[str, str]]) -> None:
    """A titled list of names and values on stdout."""
    from rich.table import Table
    from rich.text import Text

    table = Table.grid(padding=(0, 2))
    table.add_column(style="dim", no_wrap=True)
    table.add_column()
    for name, value in rows:
        table.add_row(name, Text(value))
    console = stdout_console()
    console.print(Text(title, style="bold"))
    console.print(table)


@contextmanager
def progress_bar(first_step: str) -> Iterator[Progress]:
    """A bar on stderr while work goes on; silent where stderr is no terminal."""
    log = logging.getLogger("touchwarp")
    if not sys.stderr.isatty():
        seen: set[str] = set()

        def note(step: str, done: float) -> None:
            if step not in seen:
                seen.add(step)
                log.info(step)

        yield note
        return

    from rich.console import Console
    from rich.progress import BarColumn, SpinnerColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    columns = (SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Bar(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(first_step, total=1.0)

        def advance(step: str, done: float) -> None:
            bar.update(task, description=step, completed=done)

        yield advance


def in_words(seconds: float) -> str:
    """A duration as a person would say it: "0.84 s", "12 s", "2 min 5 s"."""
    if seconds < 10:
        return f"{seconds:.2g} s" if seconds >= 1 else f"{seconds * 1000:.0f} ms"
    if seconds < 120:
        return f"{seconds:.0f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s"


def in_bytes(count: int) -> str:
    """A file's size in kB or MB (powers of ten)."""
    return f"{count / 1e6:.1f} MB" if count >= 1e6 else f"{count / 1e3:.1f} kB"
