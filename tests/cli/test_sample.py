"""`touchwarp sample` tells what the warp tells, and refuses before it writes."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest

from tests.exact.spheres import SphereWarp
from touchwarp.cli.main import main
from touchwarp.warp.table import TableWarp


def test_points_are_displayed_where_the_warp_displays_them(
    ball_warp: Path, ball_table: TableWarp, tmp_path: Path
) -> None:
    points = np.random.default_rng(0).uniform(-0.2, 0.2, (50, 3))
    np.savetxt(tmp_path / "in.csv", points, delimiter=",", fmt="%.12g")
    assert main(["sample", str(ball_warp), str(tmp_path / "in.csv"), "-o", _out(tmp_path)]) == 0
    shown = np.loadtxt(_out(tmp_path), delimiter=",")
    np.testing.assert_allclose(shown, ball_table(points), atol=1e-9)
    assert np.abs(shown - points).max() > 1e-3


def test_stdin_stdout_header_and_lost_joints(
    ball_warp: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO("joint,x,y,z\ntip,0.5,0,0\nlost,nan,nan,nan\n"))
    assert main(["sample", str(ball_warp), "-"]) == 0
    assert capsys.readouterr().out == "joint,x,y,z\ntip,0.5,0,0\nlost,nan,nan,nan\n"


def test_inverse_finds_the_real_hand(
    ball_warp: Path, ball_exact: SphereWarp, tmp_path: Path
) -> None:
    real = np.random.default_rng(1).uniform(0.06, 0.1, (20, 3))
    np.savetxt(tmp_path / "shown.csv", ball_exact(real), delimiter=",")
    arguments = ["sample", str(ball_warp), str(tmp_path / "shown.csv"), "--inverse"]
    assert main([*arguments, "-o", _out(tmp_path)]) == 0
    np.testing.assert_allclose(np.loadtxt(_out(tmp_path), delimiter=","), real, atol=3e-4)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (b"1,2\n", "line 1 has 2 fields; 3 are needed"),
        (b"\xff\xfe\x00", "is not a text file in UTF-8; a CSV file of x,y,z in metres is needed"),
        (None, "cannot be read: No such file or directory"),
    ],
)
def test_bad_points_are_refused_and_nothing_is_written(
    points: bytes | None,
    message: str,
    ball_warp: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    if points is not None:
        (tmp_path / "in.csv").write_bytes(points)
    before = sorted(tmp_path.iterdir())
    assert main(["sample", str(ball_warp), str(tmp_path / "in.csv"), "-o", _out(tmp_path)]) == 2
    told = capsys.readouterr().err
    assert message in told
    assert "Traceback" not in told
    assert sorted(tmp_path.iterdir()) == before


def test_the_output_is_tried_before_the_warp_is_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output = tmp_path / "nowhere" / "out.csv"
    assert main(["sample", "no.warp", "no.csv", "-o", str(output)]) == 2
    assert "nowhere does not exist; make that folder" in capsys.readouterr().err


def _out(tmp_path: Path) -> str:
    return str(tmp_path / "out.csv")
