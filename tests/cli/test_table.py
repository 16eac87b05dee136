"""`touchwarp table` writes the regular table that the warp resamples to."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from touchwarp.cli.main import main
from touchwarp.warp.table import TableWarp


def test_the_file_holds_the_warp_at_its_nodes(
    ball_warp: Path, ball_table: TableWarp, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output = tmp_path / "ball.npz"
    assert main(["table", str(ball_warp), "--shape", "9", "8", "7", "-o", str(output)]) == 0
    assert "ball.npz: 9 × 8 × 7 nodes, 50 × 57.1 × 66.7 mm apart" in capsys.readouterr().out
    with np.load(output) as held:
        displacement = held["displacement"]
        node = held["origin"] + held["spacing"] * [4, 3, 2]
    assert displacement.shape == (9, 8, 7, 3)
    assert displacement.dtype == np.float32
    np.testing.assert_allclose(displacement[4, 3, 2], ball_table.displacement(node), atol=1e-8)
    assert np.abs(displacement).max() > 1e-3


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        (["4000", "4000", "4000"], "4000 × 4000 × 4000 nodes needs 2.3e+03 GB, and the limit is 4"),
        (["5", "5", "1"], "The shape is 5 5 1; .*in 3-D, which needs three numbers of 2 or more"),
        (["5", "5", "0"], "0 is not in the range"),
    ],
)
def test_other_shapes_are_refused(
    shape: list[str],
    message: str,
    ball_warp: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    output = tmp_path / "ball.npz"
    assert main(["table", str(ball_warp), "--shape", *shape, "-o", str(output)]) == 2
    told = capsys.readouterr().err
    assert re.search(message.replace("+", r"\+"), told.replace("\n", " "))
    assert not output.exists()


def test_another_ending_is_refused(
    ball_warp: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output = tmp_path / "ball.txt"
    assert main(["table", str(ball_warp), "--shape", "9", "8", "7", "-o", str(output)]) == 2
    assert "the output is ball.txt; a NumPy file (.npz) is needed" in capsys.readouterr().err
    assert not output.exists()
