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
