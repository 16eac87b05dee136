"""The whole way from scene to table, against concentric spheres in closed form."""

import numpy as np
import pytest

import touchwarp as tw
from tests.exact.spheres import SphereWarp
from touchwarp.scene import Outer, shapes

A, R = 0.05, 0.2
SHIFT = np.array([0.02, 0.01, -0.015])


def scene(weight, radius=A):
    move = tw.TransformGoal(pivot="centre", translation=tuple(SHIFT))
    return tw.Scene(
        [tw.Prop("ball", shapes.sphere(radius, facet_mm=0.005), move)],
        Outer(surface=shapes.sphere(R, facet_mm=0.02)),
        tw.Objective(mismatch_weight=weight, tolerance_mm=0.5),
    )


def greatest_error(warp, weight):
    """mm, over points of Ω spread in all directions, many near the prop."""
    exact = SphereWarp(A, R, shift=SHIFT, screening=weight / 0.1**2)
    rng = np.random.default_rng(0)
    direction = rng.normal(size=(100_000, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    radius = A + 1e-5 + (R - 1e-4 - A) * rng.random((len(direction), 1)) ** 2
    points = radius * direction
    gap = warp.displacement(points) - exact.displacement(points)
    return 1e3 * np.linalg.norm(gap, axis=1).max()


@pytest.mark.parametrize("weight", [0.0, 1.0])
def test_table_is_within_the_tolerance_everywhere(weight):
    warp = tw.solve(scene(weight))
    assert greatest_error(warp, weight) <= 0.5
    assert warp.solution.estimated_error_max_mm <= 0.5


def test_tolerance_claim_rejects_a_prop_a_millimetre_too_large():
    assert greatest_error(tw.solve(scene(0.0, radius=A + 0.003)), 0.0) > 0.5


def test_displacement_never_exceeds_its_greatest_boundary_value():
    warp = tw.solve(scene(0.0))
    rng = np.random.default_rng(1)
    points = rng.uniform(-R, R, (200_000, 3))
    u = warp.displacement(points[np.linalg.norm(points, axis=1) > A])
    assert np.linalg.norm(u, axis=1).max() <= np.linalg.norm(SHIFT) + 1e-4


def test_a_turned_scene_has_the_turned_warp():
    turn = np.eye(4)
    turn[:3, :3] = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    box = shapes.box((0.06, 0.04, 0.08))
    goal = tw.TransformGoal(pivot="centre", translation=(0.02, 0.0, 0.01))
    turned_goal = tw.TransformGoal(pivot="centre", translation=(0.0, 0.02, 0.01))
    objective = tw.Objective(tolerance_mm=0.5)
    one = tw.solve(tw.Scene([tw.Prop("box", box, goal)], objective=objective))
    other = tw.solve(
        tw.Scene([tw.Prop("box", box.transformed(turn), turned_goal)], objective=objective)
    )
    rng = np.random.default_rng(2)
    points = rng.uniform(-0.1, 0.1, (20_000, 3))
    points = points[(np.abs(points) > [0.035, 0.025, 0.045]).any(axis=1)]
    carried = one.at(turn).displacement(points @ turn[:3, :3].T)
    gap = np.linalg.norm(carried - other.displacement(points @ turn[:3, :3].T), axis=1)
    assert 1e3 * gap.max() <= 1.0
    still = np.linalg.norm(one.displacement(points) - carried, axis=1)
    assert 1e3 * still.max() > 1.0
