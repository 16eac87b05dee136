"""Goals refuse arrays that are no map of a surface."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from touchwarp.errors import GoalError
from touchwarp.goals import Goal
from touchwarp.scene.surface import Surface

POINTS = np.eye(3)
FACES = np.array([[0, 1, 2]])


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ((np.eye(4), np.eye(4), FACES), r"prop points have shape \(4, 4\)"),
        ((POINTS, POINTS[:2], FACES), r"has \(3, 3\) prop points but \(2, 3\) virtual points"),
        ((POINTS, POINTS, FACES[:, :2]), r"faces have shape \(1, 2\); \(m, 3\), m ≥ 1, is needed"),
        ((POINTS, POINTS, FACES[:0]), r"faces have shape \(0, 3\)"),
        ((POINTS, np.full((3, 3), np.inf), FACES), "A goal has NaN or infinite points"),
        ((POINTS, POINTS, FACES + 1), "faces refer to points 1 to 3, but there are 3 points"),
    ],
)
def test_arrays_that_are_no_goal(arrays: tuple[Any, ...], message: str) -> None:
    with pytest.raises(GoalError, match=message):
        Goal(*arrays)


def test_the_displacement_is_g_minus_x() -> None:
    assert (Goal(POINTS, POINTS + 0.5, FACES).displacement == 0.5).all()


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (
            {"virtual_surface": Surface(np.eye(2), np.array([[0, 1]]))},
            "virtual surface is 2-D, but its points are 3-D",
        ),
        ({"landmarks": np.zeros((4, 3))}, r"landmarks have shape \(4, 3\); finite \(k, 2, 3\)"),
        ({"landmarks": np.full((1, 2, 3), np.nan)}, r"landmarks have shape \(1, 2, 3\); finite"),
    ],
)
def test_what_belongs_to_no_goal(more: dict[str, Any], message: str) -> None:
    with pytest.raises(GoalError, match=message):
        Goal(POINTS, POINTS, FACES, **more)
