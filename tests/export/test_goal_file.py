"""A goal's file is what its name's ending says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from touchwarp.errors import GoalError
from touchwarp.export import GOAL_SUFFIXES, write_goal
from touchwarp.export.goal_file import goal_files
from touchwarp.goals import Goal
from touchwarp.scene.shapes import box, polygon

CUBE = box((0.1, 0.1, 0.1))
GOAL = Goal(CUBE.vertices, CUBE.vertices * 2, CUBE.faces)


@pytest.mark.parametrize("suffix", GOAL_SUFFIXES)
def test_it_writes_the_files_that_it_names(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"cube{suffix}"
    write_goal(path, GOAL, "cube", size=64 if suffix in (".exr", ".png") else None)
    assert set(goal_files(path)) == set(tmp_path.iterdir())


def test_arrays_make_the_goal_again(tmp_path: Path) -> None:
    for surface in (CUBE, polygon([(0, 0), (1, 0), (1, 1)])):
        goal = Goal(surface.vertices, surface.vertices + 0.1, surface.faces)
        write_goal(tmp_path / "goal.npz", goal)
        with np.load(tmp_path / "goal.npz") as held:
            came = Goal(**held)
        for name in ("prop_points", "virtual_points", "faces"):
            np.testing.assert_array_equal(getattr(came, name), getattr(goal, name))


def test_other_endings_are_refused(tmp_path: Path) -> None:
    with pytest.raises(GoalError, match=r"cube.obj has the ending '.obj'; .npz \(arrays\), .glb"):
        write_goal(tmp_path / "cube.obj", GOAL)
