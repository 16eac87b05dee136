"""The weight of areas is raised where they spread too much, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest

from touchwarp.goals.goal import Goal
from touchwarp.goals.maps import evening
from touchwarp.goals.maps.make import area_preserving_goal, match_goal
from touchwarp.scene import AreaPreservingGoal, MatchGoal, Prop
from touchwarp.scene.shapes import ellipsoid, sphere

from .conftest import ring_surface

BALL = Prop("ball", sphere(0.03, 0.5))
EGG = ellipsoid([0.025, 0.03, 0.045], 0.5)
NEEDLE = ellipsoid([0.02, 0.02, 0.12], 0.5)
RING = Prop("ring", ring_surface())
THIN = ring_surface(0.03, 0.004)


def matched(**weights: float) -> Goal:
    return match_goal(BALL, MatchGoal(NEEDLE, starts=1, tolerance_mm=0.3, **weights))


def test_areas_that_spread_too_much_are_evened_out() -> None:
    goal = matched()
    told = goal.report
    assert told["area_std"] <= 0.15
    assert told["area_weight"] > 0.5
    assert told["area_weight_reason"] == "at 0.5 areas spread by 0.58"
    assert told["flips"] == told["opposing"] == 0
    assert told["coverage"] >= 0.999
    kept = area_preserving_goal(BALL, AreaPreservingGoal(NEEDLE, starts=1, tolerance_mm=0.3))
    assert told["displacement_mean"] <= kept.report["displacement_mean"]


@pytest.mark.parametrize("given", ["area_weight", "curvature_weight"])
def test_weights_that_are_given_are_kept(given: str) -> None:
    told = matched(**{given: 0.5}).report
    assert told["area_std"] > 0.15  # the twin: it is the raising that evens areas out
    assert told["area_weight"] == 0.5
    assert told["area_weight_reason"] == "weights are given"


def test_areas_that_spread_little_change_nothing() -> None:
    spec = {"starts": 1, "tolerance_mm": 0.3}
    free, given = (
        match_goal(BALL, MatchGoal(EGG, **spec, **weight)) for weight in ({}, {"area_weight": 0.5})
    )
    assert free.report["area_std"] <= 0.15
    assert free.report["area_weight"] == 0.5
    assert np.array_equal(free.virtual_points, given.virtual_points)


def test_the_weight_has_a_cap(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evening, "MOST", 0.6)
    told = matched().report
    assert 0.15 < told["area_std"] < 0.58
    assert told["area_weight"] == 0.6
    assert told["area_weight_reason"].endswith("; it goes no farther than 0.6")


def test_a_spread_within_faces_moves_no_point() -> None:
    # a thin tube of few faces: what is left of its spread no domain shows
    told = match_goal(RING, MatchGoal(THIN, starts=1, tolerance_mm=0.3)).report
    assert told["area_std"] > 0.15 > told["domain_area_std"]
    assert told["area_weight"] == 0.5
    assert told["area_weight_reason"].endswith(" is hardly better")
