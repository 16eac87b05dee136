"""Point tables: what is read, what is refused, what is carried along."""

from __future__ import annotations

import io

import numpy as np
import pytest

from touchwarp.cli.points import PointTable, read_points
from touchwarp.errors import TouchwarpError


def written(table: PointTable, points: np.ndarray) -> str:
    file = io.StringIO()
    table.write(points, file)
    return file.getvalue()


@pytest.mark.parametrize(
    "text",
    [
        "0.1,0.2,0.3\n1,2,3\n",
        "x,y,z\n0.1,0.2,0.3\n1,2,3\n",
        "\ufeffX, Y ,Z\r\n0.1, 0.2, 0.3\r\n\r\n1,2,3",
        "z,x,y\n0.3,0.1,0.2\n3,1,2\n",
    ],
)
def test_points_are_read_with_or_without_a_header(text: str) -> None:
    table = read_points(text, 3, "hand.csv")
    np.testing.assert_array_equal(table.points, [[0.1, 0.2, 0.3], [1, 2, 3]])


def test_lost_points_are_nan() -> None:
    table = read_points("nan,NaN,nan\n1,2,3\n,,\n", 3, "hand.csv")
    assert np.isnan(table.points).all(axis=1).tolist() == [True, False, True]
    assert written(table, table.points) == "nan,nan,nan\n1,2,3\nnan,nan,nan\n"


def test_other_columns_and_the_order_are_kept() -> None:
    table = read_points('time,z,joint,x,y\n0.5,3,"a,b",1,2\n', 3, "hand.csv")
    np.testing.assert_array_equal(table.points, [[1, 2, 3]])
    assert written(table, table.points + 0.5) == 'time,z,joint,x,y\n0.5,3.5,"a,b",1.5,2.5\n'


def test_plane_points_have_two_columns() -> None:
    np.testing.assert_array_equal(read_points("1,2\n", 2, "hand.csv").points, [[1, 2]])


def test_a_header_alone_is_a_table_of_no_points() -> None:
    assert read_points("x,y,z\n", 3, "hand.csv").points.shape == (0, 3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"hand\.csv is empty; rows of x,y,z in metres are needed"),
        ("1,2,3\n4,5\n", r"hand\.csv, line 2 has 2 fields; 3 are needed \(x,y,z\)"),
        ("1;2;3\n", r"begins with the header '1;2;3', which has no column named x"),
        ("1,2,3\n\n4,five,6\n", r"line 3: y is 'five'; a number in metres, or nan"),
        ("a,b,c\n1,2,3\n", r"which has no column named x; one each of x, y, z is needed"),
        ("x,y,z,x\n1,2,3,4\n", r"which has 2 columns named x"),
        ("time,x,y,z\n1,2,3\n", r"line 2 has 3 fields; 4 are needed \(time,x,y,z\)"),
    ],
)
def test_other_tables_are_refused_with_their_line(text: str, message: str) -> None:
    with pytest.raises(TouchwarpError, match=message):
        read_points(text, 3, "hand.csv")
