"""What stands on a plane shows on that plane, where a match is given its base."""

from __future__ import annotations

import numpy as np
import pytest

from touchwarp.errors import GoalError
from touchwarp.goals.goal import Goal
from touchwarp.goals.maps import parameterise
from touchwarp.goals.maps.make import match_goal
from touchwarp.scene import MatchGoal, Prop, Surface
from touchwarp.scene.shapes import box, cylinder

BOX = box((0.1, 0.1, 0.06))
CAN = cylinder(0.03, 0.08)
DOWN = (0.0, 0.0, -1.0)


def standing_at(surface: Surface, height: float) -> Surface:
    lift = height - surface.vertices[:, 2].min()
    return Surface(surface.vertices + np.array([0.0, 0.0, lift]), surface.faces)


def greatest_lift(goal: Goal) -> float:
    """m: how far images of points on the plane z = 0 are from it."""
    on = np.abs(goal.prop_points[:, 2]) <= 1e-9
    assert on.sum() > 20
    return float(np.abs(goal.virtual_points[on, 2]).max())


def matched(base: tuple[float, ...] | None) -> Goal:
    virtual = standing_at(CAN, 0.0)
    spec = MatchGoal(virtual, base=base, starts=1, tolerance_mm=0.3)
    return match_goal(Prop("prop", standing_at(BOX, 0.0)), spec)


def test_the_base_stays_on_its_plane(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parameterise, "EDGES_PER_SIZE", 40)  # its border is curved
    goal = matched(DOWN)
    assert greatest_lift(goal) <= 1e-4
    assert goal.report["flips"] == 0
    assert greatest_lift(matched(None)) > 1e-4  # the twin: unasked, it does not stay


def test_bases_in_two_planes_are_refused() -> None:
    spec = MatchGoal(standing_at(CAN, 0.01), base=DOWN)
    with pytest.raises(GoalError, match=r"bases .* lie 10 mm apart"):
        match_goal(Prop("prop", standing_at(BOX, 0.0)), spec)


def test_a_side_without_a_flat_face_is_refused() -> None:
    spec = MatchGoal(standing_at(CAN, 0.0), base=(1.0, 1.0, 0.0))
    with pytest.raises(GoalError, match=r"the prop has no flat face towards goal\.base"):
        match_goal(Prop("prop", standing_at(BOX, 0.0)), spec)
