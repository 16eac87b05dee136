"""`touchwarp sample`: where given points are displayed."""

from __future__ import annotations

import sys
from pathlib import Path

import click


@click.command(
    "sample",
    epilog="\b\nExamples:\n"
    "  touchwarp sample mug.warp hand.csv -o shown.csv\n"
    "  echo 0.05,0,0.04 | touchwarp sample mug.warp -\n"
    "  touchwarp sample mug.warp shown.csv --inverse",
)
@click.argument("warp", type=click.Path(path_type=Path))
@click.argument("points", type=click.Path(path_type=Path, allow_dash=True))
@click.option("-o", "--output", type=click.Path(path_type=Path), help="CSV file instead of stdout.")
@click.option(
    "--inverse",
    is_flag=True,
    help="Take POINTS as displayed ones and tell where the real hand must be (nan: nowhere).",
)
def sample_command(warp: Path, points: Path, output: Path | None, inverse: bool) -> None:
    """Tell where each point of the table POINTS is displayed by WARP.

    POINTS is a CSV file of x,y,z in metres in the scene's frame, without a header or with one that
    names these columns; '-' is stdin. Other columns are carried along. A row of nan comes out as a
    row of nan.
    """
    from touchwarp.cli.points import read_points
    from touchwarp.outputs import claim, replacing
    from touchwarp.warp.file import load_table

    if output is not None:
        claim(output, warp, points)
    table_warp = load_table(warp)
    table = read_points(_text_of(points), table_warp.dimension, str(points))
    if inverse:
        shown = table_warp.inverse(table.points).points
    else:
        shown = table_warp(table.points)
    if output is None:
        table.write(shown, sys.stdout)
        return
    with replacing(output) as temporary, temporary.open("w", encoding="utf-8") as file:
        table.write(shown, file)


def _text_of(path: Path) -> str:
    from touchwarp.errors import TouchwarpError

    if str(path) == "-":
        return sys.stdin.read()
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise TouchwarpError(
            f"{path} cannot be read: {error.strerror}; a CSV file of x,y,z in metres is needed, or "
            "'-' for stdin."
        ) from error
    except UnicodeDecodeError as error:
        raise TouchwarpError(
            f"{path} is not a text file in UTF-8; a CSV file of x,y,z in metres is needed."
        ) from error
