"""Just outside the edge radius the table keeps its tolerance, though contact is served within."""

import numpy as np
import pytest

import touchwarp as tw
from touchwarp.scene import Outer, shapes
from touchwarp.solve.tube import Tube

SIDE, RADIUS_MM, TOLERANCE_MM = 0.1, 4.0, 0.5
GOAL = tw.TransformGoal(scale=(1.15, 0.9, 1.1), rotation_deg=(0, 0, 8), translation=(0.014, 0, 0))


def warp_of_box(tolerance_mm, edge_radius_mm):
    box = tw.Prop("box", shapes.box((SIDE, SIDE, SIDE)), GOAL)
    objective = tw.Objective(tolerance_mm=tolerance_mm, edge_radius_mm=edge_radius_mm)
    return tw.solve(tw.Scene([box], Outer(box_scale=4.0), objective))


def beside_edges():
    """(n, 3) m: points of Ω, one to two radii from the box's nearest edge."""
    rng = np.random.default_rng(0)
    reach = SIDE / 2 + 2e-3 * RADIUS_MM
    points = rng.uniform(-reach, reach, (1_000_000, 3))
    beyond = np.abs(points) - SIDE / 2
    points, beyond = points[beyond.max(axis=1) > 0], beyond[beyond.max(axis=1) > 0]
    along = np.maximum(beyond, 0.0) ** 2  # past the ends of an edge along this axis
    across = beyond**2
    squares = across.sum(axis=1, keepdims=True) - across + along
    distance = 1e3 * np.sqrt(squares.min(axis=1))
    return points[(distance >= RADIUS_MM) & (distance <= 2 * RADIUS_MM)]


@pytest.fixture(scope="module")
def finer():
    """The same warp with half the tolerance, and half the edge radius."""
    return warp_of_box(TOLERANCE_MM / 2, RADIUS_MM / 2)


def greatest_gap_mm(warp, finer):
    points = beside_edges()
    return 1e3 * np.linalg.norm(warp(points) - finer(points), axis=1).max()


def test_the_table_keeps_its_tolerance_just_outside_the_edge_radius(finer):
    warp = warp_of_box(TOLERANCE_MM, RADIUS_MM)
    assert warp.solution.estimated_error_max_mm <= TOLERANCE_MM
    assert greatest_gap_mm(warp, finer) <= TOLERANCE_MM


def test_it_does_not_where_nodes_are_moved_up_to_the_radius_itself(finer, monkeypatch):
    contains = Tube.contains
    monkeypatch.setattr(Tube, "contains", lambda tube, points, margin=0.0: contains(tube, points))
    assert greatest_gap_mm(warp_of_box(TOLERANCE_MM, RADIUS_MM), finer) > 2 * TOLERANCE_MM
