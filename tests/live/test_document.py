"""A scene file is changed where it was changed, and nowhere else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from touchwarp.errors import GoalError, OutputError, SceneError
from touchwarp.goals import goals
from touchwarp.live.document import SceneDocument
from touchwarp.live.messages import Placement, Pose

MOVED = Placement(scale=(1.2, 1.0, 0.5), rotation_deg=(0, 0, 30), translation=(0.02, 0, 0.001))


def test_only_what_changed_changes(ball_path: Path) -> None:
    before = ball_path.read_text().splitlines()
    document = SceneDocument.open(ball_path).changed(goals={"ball": MOVED}, mismatch_weight=2.0)
    document.save()
    after = ball_path.read_text().splitlines()
    gone = [line for line in before if line not in after]
    assert gone == ["translation = [0.01, 0, 0]    # one centimetre to the right"]
    new = [line for line in after if line not in before]
    assert new == [
        "mismatch_weight = 2.0",
        "translation = [0.02, 0.0, 0.001]    # one centimetre to the right",
        "scale = [1.2, 1.0, 0.5]",
        "rotation_deg = [0.0, 0.0, 30.0]",
    ]


def test_the_saved_scene_has_the_goal_that_was_shown(ball_path: Path) -> None:
    SceneDocument.open(ball_path).changed(goals={"ball": MOVED}).save()
    (goal,) = goals(SceneDocument.open(ball_path).scene).values()
    turn = np.array([[np.sqrt(3) / 2, -0.5, 0], [0.5, np.sqrt(3) / 2, 0], [0, 0, 1]])
    pivot = np.array([0, 0, -0.05])  # the ball's base
    expected = pivot + [0.02, 0, 0.001] + turn @ np.diag([1.2, 1.0, 0.5]) @ (-pivot)
    assert goal.matrix is not None
    np.testing.assert_allclose(goal.matrix[:3, 3], expected, atol=1e-9)


def test_a_change_to_the_same_changes_nothing(ball_path: Path) -> None:
    document = SceneDocument.open(ball_path)
    same = Placement(scale=(1, 1, 1), rotation_deg=(0, 0, 0), translation=(0.01, 0, 0))
    assert not document.changed(goals={"ball": same}, mismatch_weight=0.0).unsaved


def test_a_measured_pose_is_written(ball_path: Path) -> None:
    pose = Pose(position=(0.01, 0.0, 0.02), rotation_deg=(0, 0, 45))
    document = SceneDocument.open(ball_path).changed(poses={"ball": pose})
    np.testing.assert_allclose(
        document.scene.props[0].surface.bounds.mean(axis=0), [0.01, 0, 0.02], atol=1e-9
    )


def test_a_scene_without_an_objective_gets_one(ball_path: Path) -> None:
    text = ball_path.read_text().replace("[objective]\ntolerance_mm = 1.0\n", "")
    ball_path.write_text(text)
    document = SceneDocument.open(ball_path).changed(mismatch_weight=3.0)
    assert document.scene.objective.mismatch_weight == 3.0


def test_unknown_props_are_told(ball_path: Path) -> None:
    with pytest.raises(SceneError, match="no prop is named 'bowl'; the scene has 'ball'"):
        SceneDocument.open(ball_path).changed(goals={"bowl": MOVED})


def test_a_goal_by_matrix_is_not_dragged(ball_path: Path) -> None:
    rows = "matrix = [[1,0,0,0.01],[0,1,0,0],[0,0,1,0],[0,0,0,1]]"
    ball_path.write_text(
        ball_path.read_text().replace("translation = [0.01, 0, 0]", rows),
    )
    with pytest.raises(SceneError, match="is not written as scale, rotation_deg and translation"):
        SceneDocument.open(ball_path).changed(goals={"ball": MOVED})


def test_a_flattening_is_refused_and_nothing_changed(ball_path: Path) -> None:
    flat = Placement(scale=(1, 1, 0), rotation_deg=(0, 0, 0), translation=(0, 0, 0))
    with pytest.raises(GoalError, match="flattens the prop"):
        SceneDocument.open(ball_path).changed(goals={"ball": flat})


def test_a_file_changed_meanwhile_is_not_overwritten(ball_path: Path) -> None:
    document = SceneDocument.open(ball_path).changed(mismatch_weight=1.0)
    ball_path.write_text(ball_path.read_text() + "# by another program\n")
    with pytest.raises(SceneError, match="was changed on disk since it was opened"):
        document.save()
    assert "another program" in ball_path.read_text()


def test_a_file_that_went_away_is_told(ball_path: Path) -> None:
    document = SceneDocument.open(ball_path).changed(mismatch_weight=1.0)
    ball_path.unlink()
    with pytest.raises(OutputError, match="cannot be read any more"):
        document.save()


def test_a_warp_s_scene_has_no_file_to_save_to(ball_path: Path) -> None:
    document = SceneDocument.inside(ball_path.read_text(), ball_path.with_suffix(".warp"))
    with pytest.raises(SceneError, match="no scene file to save to"):
        document.save()
