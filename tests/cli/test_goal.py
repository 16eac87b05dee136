"""`touchwarp goal` writes the map from a prop to its virtual object."""

from __future__ import annotations

import json
import re
from functools import partial
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from touchwarp.cli.goal import goal_facts
from touchwarp.cli.main import main
from touchwarp.goals import Goal, goals, subdivision
from touchwarp.scene import load_scene, parse_scene
from touchwarp.scene.shapes import box

SCENE = """
[[prop]]
name = "ball"
shape = { kind = "sphere", radius = 0.04, facet_mm = 0.5 }

[prop.goal]
kind = "direction"
virtual_shape = { kind = "box", size = [0.06, 0.06, 0.06] }
tolerance_mm = 0.5
"""
SECOND = """
[[prop]]
name = "brick"
shape = { kind = "box", size = [0.02, 0.02, 0.02] }
pose = { position = [0.2, 0, 0] }
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "ball.toml"
    path.write_text(SCENE)
    return path


def test_arrays(scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = tmp_path / "ball.npz"
    assert main(["goal", str(scene), "-o", str(output)]) == 0
    told = capsys.readouterr().out
    assert "ball.npz: direction of 'ball', " in told
    goal = goals(load_scene(scene))["ball"]
    with np.load(output) as held:
        np.testing.assert_array_equal(held["virtual_points"], goal.virtual_points)
    length = np.linalg.norm(goal.displacement, axis=1) * 1e3
    assert f"displaces by {length.mean():.3g} mm on average, {length.max():.3g} mm at most" in told


def test_what_it_says_about_a_texture_makes_a_scene(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["goal", str(scene), "-o", str(tmp_path / "ball.png"), "--size", "256"]) == 0
    told = capsys.readouterr().out
    assert "ball.png and " in told
    off = re.search(r"from the goal's points by (.*) mm at most, and by .* mm on its faces", told)
    assert off is not None
    assert "Its greatest number stands for 0.0" in told
    snippet = told[told.index("  [prop.goal]") :]
    text = SCENE[: SCENE.index("[prop.goal]")] + snippet
    came = goals(parse_scene(text, tmp_path))["ball"]
    assert came.kind == "texture"
    written = goals(load_scene(scene))["ball"]
    distance, row = cKDTree(came.prop_points).query(written.prop_points)
    assert distance.max() < 1e-7
    apart = np.linalg.norm(came.virtual_points[row] - written.virtual_points, axis=1)
    assert 1e3 * apart.max() == pytest.approx(float(off[1]), rel=0.2)


def test_a_texture_that_is_too_small_is_told(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["goal", str(scene), "-o", str(tmp_path / "ball.exr"), "--size", "16"]) == 0
    assert "points crowd one texel; a larger --size lessens it." in capsys.readouterr().out


def test_one_of_several_props_as_json(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene.write_text(SCENE + SECOND)
    output = tmp_path / "ball.glb"
    command = ["goal", str(scene), "-o", str(output)]
    assert main(command) == 2
    assert (
        "the scene has 2 props: 'ball', 'brick'; say which with --prop" in capsys.readouterr().err
    )
    assert not output.exists()
    assert main([*command, "--prop", "bal"]) == 2
    assert "no prop is named 'bal'. Did you mean 'ball'?" in capsys.readouterr().err
    assert main([*command, "--prop", "ball", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["prop"], facts["kind"], facts["files"]) == ("ball", "direction", [str(output)])
    assert facts["report"]["image_distance_max"] < 5e-4
    assert output.exists()


@pytest.mark.parametrize(
    ("output", "message"),
    [
        ("ball.stl", "the goal's file ball.stl has the ending '.stl'; .npz (arrays), .glb"),
        ("ball.toml", "the goal's file ball.toml has the ending '.toml'"),
        ("missing/ball.glb", "does not exist; make that folder or choose another place"),
    ],
)
def test_bad_outputs_are_told_first(
    output: str, message: str, scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["goal", str(scene), "-o", str(tmp_path / output)]) == 2
    assert message in capsys.readouterr().err.replace("\n", " ")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["ball.toml"]


def test_a_goal_that_cannot_be_made_leaves_nothing(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene.write_text(SCENE + "centre = [1, 0, 0]\n")
    assert main(["goal", str(scene), "-o", str(tmp_path / "ball.exr")]) == 2
    assert (
        "prop 'ball': the prop is not star-shaped from (1000, 0, 0) mm" in capsys.readouterr().err
    )
    assert sorted(p.name for p in tmp_path.iterdir()) == ["ball.toml"]


def test_too_few_faces_are_told(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    few = partial(subdivision.subdivide, most_faces=5000)
    monkeypatch.setattr(import_module("touchwarp.goals.direction"), "subdivide", few)
    scene.write_text(SCENE.replace("tolerance_mm = 0.5", "tolerance_mm = 0.001"))
    assert main(["goal", str(scene), "-o", str(tmp_path / "ball.npz")]) == 0
    told = capsys.readouterr().out
    assert "Note: that many faces are not enough for the goal's tolerance_mm; their image" in told


def test_the_weight_of_areas_is_told(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    cube = box((0.1, 0.1, 0.1))
    report = {"area_std": 0.146, "area_weight": 4.0, "area_weight_reason": "a reason"}
    goal = Goal(cube.vertices, cube.vertices, cube.faces, "match", report)
    monkeypatch.setattr(import_module("touchwarp.goals"), "goals", lambda *_: {"ball": goal})
    assert main(["goal", str(scene), "-o", str(tmp_path / "ball.npz")]) == 0
    assert "Areas spread by 0.15 at area_weight 4 (a reason)." in capsys.readouterr().out


def test_any_report_becomes_json() -> None:
    cube = box((0.1, 0.1, 0.1))
    report = {
        "a": np.float64(1.5),
        "b": np.inf,
        "c": np.arange(2),
        "d": (np.bool_(True), np.nan),
        "e": "torus",
    }
    facts = goal_facts(Goal(cube.vertices, cube.vertices, cube.faces, report=report))
    assert json.loads(json.dumps(facts["report"], allow_nan=False)) == {
        "a": 1.5,
        "b": None,
        "c": [0, 1],
        "d": [True, None],
        "e": "torus",
    }
