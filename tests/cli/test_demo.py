"""The demo makes what it says, from real input, and its last line tells the truth about it."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from touchwarp.cli.demo import Made, closing_line
from touchwarp.cli.demo_files import write_input
from touchwarp.cli.main import main
from touchwarp.cli.points import read_points
from touchwarp.goals import goals, validate
from touchwarp.scene import load_scene
from touchwarp.scene.vessels import mug
from touchwarp.warp.file import load_table
from touchwarp.warp.solve_bases import RANGE_TOLERANCE

FILES = {
    *("mug.stl", "mug.toml", "mug.warp", "mug.html", "mug.json", "mug.png"),
    *("turned.toml", "turned.warp", "turned.html", "turned.json"),
    "hand.csv",
}


def test_the_input_is_a_mug_on_a_table_and_a_hand_with_a_lost_sample(tmp_path: Path) -> None:
    write_input(tmp_path)
    for name in ("mug.toml", "turned.toml"):
        scene = load_scene(tmp_path / name)
        validate(scene, goals(scene))
        assert scene.slide_plane is not None
        assert scene.objective.tolerance_mm == 0.1
    surface = scene.props[0].surface
    np.testing.assert_allclose(surface.bounds, mug().bounds, atol=1e-7)
    assert len(surface.faces) == len(mug().faces)
    hand = read_points((tmp_path / "hand.csv").read_text(), 3, "hand.csv").points
    assert np.isnan(hand).any(axis=1).sum() == 1
    np.testing.assert_allclose(hand[-1], [-0.04, 0, 0.05], atol=1e-9)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The demo's folder, made coarsely."""
    folder = tmp_path_factory.mktemp("demo")
    assert main(["demo", "-o", str(folder), "--tolerance-mm", "2"]) == 0
    return folder


def test_every_file_is_made(made: Path) -> None:
    assert {path.name for path in made.iterdir()} == FILES
    assert (made / "mug.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("name", ["mug", "turned"])
def test_the_hand_meets_the_cup(name: str, made: Path) -> None:
    scene, warp = load_scene(made / f"{name}.toml"), load_table(made / f"{name}.warp")
    (goal,) = goals(scene).values()
    assert goal.matrix is not None
    touched = np.array([-0.04, 0.0, 0.05])
    wanted = goal.matrix[:3, :3] @ touched + goal.matrix[:3, 3]
    np.testing.assert_allclose(warp(touched), wanted, atol=2e-3)
    assert np.linalg.norm(wanted - touched) > 0.015
    # what comes from bases keeps the tolerance of their whole range
    tolerance_mm = 2.0 if name == "mug" else 2.0 * RANGE_TOLERANCE
    assert json.loads((made / f"{name}.json").read_text())["facts"]["tolerance_mm"] == tolerance_mm


def test_the_next_command_runs(made: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sample", str(made / "mug.warp"), str(made / "hand.csv")]) == 0
    shown = capsys.readouterr().out.splitlines()
    assert shown[0] == "time_s,x,y,z"
    assert sum("nan" in line for line in shown) == 1


def test_the_last_line_tells_time_exactness_warnings_and_what_next(made: Path) -> None:
    import touchwarp as tw

    scene, warp = load_scene(made / "mug.toml"), tw.load_warp(made / "mug.warp")
    assert isinstance(warp, tw.TableWarp)
    report = tw.check(scene, warp, samples=20_000)
    line = closing_line(made, Made(warp, report, 1.25))
    assert "in 1.2 s from mesh to saved table" in line
    assert f"{report.of('contact.p99').value_text} where the mug is touched" in line
    for check in report.with_status("warn"):
        assert check.value_text in line
    assert re.search(r"then try: touchwarp sample \S+mug\.warp \S+hand\.csv$", line)


def test_a_place_that_cannot_be_written_is_found_first(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    assert main(["demo", "-o", str(tmp_path / "file")]) == 2
    assert "cannot be made" in capsys.readouterr().err
