"""A sliding table is what a mirror image of every prop under it would give."""

import numpy as np

import touchwarp as tw
from touchwarp.scene import Outer, shapes

TOLERANCE_MM = 0.5
BOX = np.array([[-0.25, -0.25, -0.25], [0.25, 0.25, 0.25]])
UP = np.array([[1.0, 0, 0, 0.01], [0, 1, 0, 0], [0, 0, 1, 0.07], [0, 0, 0, 1]])
DOWN = np.array([[1.0, 0, 0, 0.01], [0, 1, 0, 0], [0, 0, 1, -0.07], [0, 0, 0, 1]])


def ball(T):
    return shapes.sphere(0.04, facet_mm=0.02).transformed(T)


def goal(z):
    return tw.TransformGoal(pivot="centre", translation=(0.01, 0.0, z))


def table(contact):
    return tw.Fixed("table", plane=([0, 0, 0], [0, 0, 1]), contact=contact)


def solve(props, fixed=()):
    objective = tw.Objective(tolerance_mm=TOLERANCE_MM)
    return tw.solve(tw.Scene(props, Outer(box=BOX), objective, fixed))


def gap(contact):
    half = solve([tw.Prop("ball", ball(UP), goal(-0.01))], [table(contact)])
    both = solve([tw.Prop("ball", ball(UP), goal(-0.01)), tw.Prop("image", ball(DOWN), goal(0.01))])
    rng = np.random.default_rng(0)
    points = rng.uniform([-0.2, -0.2, 0.0], [0.2, 0.2, 0.2], (50_000, 3))
    points = points[np.linalg.norm(points - UP[:3, 3], axis=1) > 0.0405]
    return 1e3 * np.linalg.norm(
        half.displacement(points) - both.displacement(points), axis=1
    ).max(), half


def test_sliding_table_equals_a_mirrored_prop():
    difference, warp = gap("slide")
    assert difference <= 2 * TOLERANCE_MM
    rng = np.random.default_rng(1)
    on_table = rng.uniform([-0.2, -0.2, 0.0], [0.2, 0.2, 0.0], (10_000, 3))
    assert np.abs(warp.displacement(on_table)[:, 2]).max() < 1e-9
    assert np.abs(warp.displacement(on_table)[:, 0]).max() > 1e-3


def test_mirror_claim_rejects_a_holding_table():
    difference, warp = gap("hold")
    assert difference > 2 * TOLERANCE_MM
    rng = np.random.default_rng(1)
    on_table = rng.uniform([-0.2, -0.2, 0.0], [0.2, 0.2, 0.0], (10_000, 3))
    assert 1e3 * np.linalg.norm(warp.displacement(on_table), axis=1).max() < TOLERANCE_MM


def test_a_prop_on_the_table_leaves_the_tangential_goal_to_its_foot():
    lift = tw.TransformGoal(pivot="base", translation=(0.01, 0.0, 0.02))
    box = shapes.box((0.06, 0.06, 0.08))
    raised = np.eye(4)
    raised[2, 3] = 0.04
    warp = solve([tw.Prop("box", box.transformed(raised), lift)], [table("slide")])
    assert warp.solution.contradiction_mm == 20.0 or abs(warp.solution.contradiction_mm - 20) < 1e-6
    foot = warp.displacement(np.array([[0.03, 0.0, 0.0]]))[0]
    top = warp.displacement(np.array([[0.0, 0.0, 0.08]]))[0]
    np.testing.assert_allclose(foot, [0.01, 0.0, 0.0], atol=3e-4)
    np.testing.assert_allclose(top, [0.01, 0.0, 0.02], atol=3e-4)
