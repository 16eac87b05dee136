"""The examples run, and what they say comes true."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import touchwarp as tw
from touchwarp.scene import load_scene
from touchwarp.warp import rounds

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
SCENES = sorted(EXAMPLES.glob("*.toml"))
SCRIPTS = sorted(EXAMPLES.glob("*.py"))


def failures(path: Path) -> list[str]:
    """The checks that the warp of a scene fails."""
    scene = load_scene(path)
    report = tw.check(scene, tw.solve(scene))
    return [check.name for check in report.checks if check.status == "fail"]


@pytest.fixture
def results(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> dict[str, Any]:
    """What the script of the test's name leaves behind."""
    monkeypatch.chdir(tmp_path)
    name = request.function.__name__.removeprefix("test_")
    return runpy.run_path(str(EXAMPLES / f"{name}.py"))


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_scenes_are_solved_as_they_are_and_pass_their_own_check(path: Path) -> None:
    assert failures(path) == []


def test_a_scene_whose_grid_is_never_refined_again_does_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(rounds, "MOST_ROUNDS", 1)
    assert "estimate.max" in failures(EXAMPLES / "knob_and_crate.toml")


def test_first_warp(results: dict[str, Any], tmp_path: Path) -> None:
    np.testing.assert_allclose(results["shown"] - results["touched"], [0.02, 0, 0], atol=5e-4)
    assert results["far"].tolist() == [0, 0, 0]
    assert (tmp_path / "ball.warp").exists()
    points = np.random.default_rng(0).uniform(-0.3, 0.3, (100, 3))
    np.testing.assert_array_equal(results["loaded"](points), results["warp"](points))


def test_live_hands(results: dict[str, Any]) -> None:
    hands, shown, back = results["hands"], results["shown"], results["back"]
    assert shown.shape == (2, 26, 3)
    assert np.argwhere(np.isnan(shown).any(axis=-1)).tolist() == [[1, 7]]
    assert 1e-3 < np.nanmax(np.abs(shown - hands)) < 0.02
    assert back.found.sum() == 51
    again = results["warp"](back.points)
    np.testing.assert_allclose(again[back.found], shown[back.found], atol=1e-7)


def test_instant_goals(results: dict[str, Any]) -> None:
    points = np.random.default_rng(0).uniform(-0.2, 0.2, (2000, 3))
    beyond = np.abs(points) - results["prop"].surface.bounds[1]
    points = points[np.linalg.norm(np.maximum(beyond, 0.0), axis=1) > 0.002]
    combined, solved = results["frames"][30], results["solved"]
    assert np.abs(combined(points) - solved(points)).max() < 1e-3  # both tolerances
    assert np.abs(results["frames"][0](points) - solved(points)).max() > 5e-3


def test_carried_prop(results: dict[str, Any]) -> None:
    pose = results["pose"]
    shown = pose[:3, :3] @ results["still"](results["touched"]) + pose[:3, 3]
    np.testing.assert_allclose(results["carried"](results["touched_now"]), shown, atol=1e-12)
    assert np.abs(shown - results["touched_now"]).max() > 5e-3


def test_other_weights(results: dict[str, Any]) -> None:
    np.testing.assert_allclose(list(results["near"].values()), 15.0, atol=0.5)
    far = list(results["far"].values())
    assert far == sorted(far, reverse=True)
    assert far[0] > 1.5 * far[-1]


def test_own_goal(results: dict[str, Any]) -> None:
    np.testing.assert_allclose(results["shown"], results["wanted"], atol=5e-4)
    assert np.linalg.norm(results["wanted"] - results["touched"]) > 3e-3


def test_every_example_is_told_of_and_every_script_has_a_test() -> None:
    told = (EXAMPLES / "README.md").read_text()
    assert [path.name for path in (*SCENES, *SCRIPTS) if f"[{path.name}]" not in told] == []
    assert [path.stem for path in SCRIPTS if f"test_{path.stem}" not in globals()] == []
