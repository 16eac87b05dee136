"""Only what contradicts a fixed surface gives way to it."""

import numpy as np
import pytest

import touchwarp as tw
from touchwarp.goals import goals
from touchwarp.scene import Outer
from touchwarp.scene.vessels import mug
from touchwarp.solve import blend
from touchwarp.solve.problem import make_problem

BOX = np.array([[-0.3, -0.3, -0.3], [0.3, 0.3, 0.3]])


def contradiction_mm(goal: tw.TransformGoal) -> float:
    """Of a mug with a rounded foot, on a table to slide on."""
    table = tw.Fixed("table", plane=([0, 0, 0], [0, 0, 1]), contact="slide")
    scene = tw.Scene([tw.Prop("mug", mug(), goal)], Outer(box=BOX), tw.Objective(), [table])
    own = goals(scene)
    problem = make_problem(scene, own)
    return 1e3 * problem.blend.contradiction(problem.goal_data(own), problem.normal_lanes)


def test_a_goal_that_keeps_the_foot_in_place_contradicts_nothing() -> None:
    """What a rounding is lifted by, near the table but not on it, is no contradiction."""
    assert contradiction_mm(tw.TransformGoal(pivot="base", scale=(1.0, 1.0, 3.0))) < 0.02


def test_the_claim_rejects_all_that_is_near_the_table(monkeypatch: pytest.MonkeyPatch) -> None:
    """The twin: 0.1 mm above the table three times the height is a lift of 0.2 mm."""
    monkeypatch.setattr(blend, "STEEP", 1e3)
    assert contradiction_mm(tw.TransformGoal(pivot="base", scale=(1.0, 1.0, 3.0))) > 0.1


def test_a_foot_that_would_leave_the_table_contradicts_it() -> None:
    goal = tw.TransformGoal(pivot="base", translation=(0.0, 0.0, 0.004))
    assert contradiction_mm(goal) == pytest.approx(4.0, abs=1e-9)


def greatest_step_mm() -> float:
    """Between boundary values 1 µm apart, along a tilted mug's foot and 1 mm above it."""
    table = tw.Fixed("table", plane=([0, 0, 0], [0, 0, 1]), contact="slide")
    tilted = tw.TransformGoal(pivot="base", rotation_deg=(8.0, 5.0, 0.0))
    scene = tw.Scene([tw.Prop("mug", mug(), tilted)], Outer(box=BOX), tw.Objective(), [table])
    own = goals(scene)
    problem = make_problem(scene, own)
    data = problem.goal_data(own)
    worst = 0.0
    for start in np.random.default_rng(0).uniform([-0.03, -0.03, 0], [0.03, 0.03, 1e-3], (10, 3)):
        points = start + np.linspace(0.0, 5e-3, 5001)[:, None] * np.array([0.6, 0.8, 0.0])
        values = np.zeros((len(points), 4))
        terms = problem.blend.terms(problem.frame.to_grid(points), np.zeros(len(points), np.int16))
        problem.blend.apply(values, terms, data, problem.normal_lanes)
        worst = max(worst, 1e3 * np.abs(np.diff(values[:, 2])).max())
    return worst


def test_what_gives_way_does_so_without_steps() -> None:
    """A tilt of 8° rises by 0.14 µm in one, and by several times that between samples."""
    assert greatest_step_mm() < 0.002


def test_that_claim_rejects_the_nearest_sample_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """The twin: of two the farther has no weight."""
    monkeypatch.setattr(blend, "NEAREST", 2)
    assert greatest_step_mm() > 0.02


def test_a_contact_of_one_sample_gives_way_to_that(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(blend, "NEAREST", 1)
    assert np.isfinite(greatest_step_mm())
