"""Tables of points as CSV: x, y, z in metres, with or without a header, NaN for lost ones."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import TouchwarpError

AXES = ("x", "y", "z")


@dataclass(frozen=True, eq=False)
class PointTable:
    """A CSV file of points, ready to be written again with other coordinates.

    Attributes:
        points: (n, d) m; NaN where a field is empty or "nan".
        header: the first row, or None where the file has only numbers.
        rows: the fields of each point's row.
        columns: where x, y (and z) stand in a row.
    """

    points: NDArray[np.float64]
    header: list[str] | None
    rows: list[list[str]]
    columns: list[int]

    def write(self, points: NDArray[np.float64], file: TextIO) -> None:
        """The same table with `points`, (n, d) m, in place of its own; other columns are kept."""
        writer = csv.writer(file, lineterminator="\n")
        if self.header is not None:
            writer.writerow(self.header)
        for row, point in zip(self.rows, points.tolist(), strict=True):
            fields = list(row)
            for column, coordinate in zip(self.columns, point, strict=True):
                fields[column] = f"{coordinate:.9g}"
            writer.writerow(fields)


def read_points(text: str, dimension: int, name: str) -> PointTable:
    """Read the points of a CSV text.

    Without a header each row has `dimension` numbers. With one, the columns named x, y (and z) are
    the points, and any others are carried along.

    Args:
        text: the file's contents.
        dimension: 3, or 2 for a plane scene.
        name: the file's name, for messages.

    Raises:
        TouchwarpError: the text is no such table; the message names the line.
    """
    axes = AXES[:dimension]
    wanted = ",".join(axes)
    lines = [
        (number, [field.strip() for field in row])
        for number, row in enumerate(csv.reader(io.StringIO(text.removeprefix("\ufeff"))), 1)
        if any(field.strip() for field in row) or len(row) > 1
    ]
    if not lines:
        raise TouchwarpError(f"{name} is empty; rows of {wanted} in metres are needed.")
    header = None
    columns = list(range(dimension))
    if any(_number(field) is None for field in lines[0][1]):
        header = lines.pop(0)[1]
        columns = _columns(header, axes, name)
    width = len(header) if header is not None else dimension
    points = np.empty((len(lines), dimension))
    for i, (number, row) in enumerate(lines):
        if len(row) != width:
            raise TouchwarpError(
                f"{name}, line {number} has {len(row)} fields; {width} are needed"
                f" ({','.join(header) if header else wanted}), separated by commas."
            )
        for axis, column in enumerate(columns):
            value = _number(row[column])
            if value is None:
                raise TouchwarpError(
                    f"{name}, line {number}: {axes[axis]} is '{row[column]}'; a number in metres, "
                    "or nan for a lost point, is needed."
                )
            points[i, axis] = value
    return PointTable(points, header, [row for _, row in lines], columns)


def _columns(header: list[str], axes: tuple[str, ...], name: str) -> list[int]:
    names = [field.lower() for field in header]
    for axis in axes:
        if names.count(axis) != 1:
            raise TouchwarpError(
                f"{name} begins with the header {','.join(header)!r}, which has "
                f"{names.count(axis) or 'no'} column{'s' if names.count(axis) > 1 else ''} "
                f"named {axis}; one each of {', '.join(axes)} is needed, "
                "or no header and only numbers."
            )
    return [names.index(axis) for axis in axes]


def _number(field: str) -> float | None:
    if not field:
        return float("nan")
    try:
        return float(field)
    except ValueError:
        return None
