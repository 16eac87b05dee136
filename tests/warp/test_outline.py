"""Outlines have few faces, and still the shape of the prop and of the virtual object."""

from __future__ import annotations

import numpy as np
import pytest

from touchwarp.goals import Goal, goals
from touchwarp.scene import DirectionGoal, Prop, Scene, Surface
from touchwarp.scene.pose import rotation_matrix
from touchwarp.scene.shapes import box, sphere
from touchwarp.warp.outline import MOST_FACES, outline_of, thinned

R = rotation_matrix((0, 0, 170))


@pytest.fixture(scope="module")
def goal() -> Goal:
    """A ball felt as a cube that is turned and stands elsewhere."""
    spec = DirectionGoal(box((0.1, 0.1, 0.1)), centre=(0, 0, 0), tolerance_mm=0.1)
    made = goals(Scene([Prop("ball", sphere(0.06, facet_mm=0.1), spec)]))["ball"]
    return Goal(made.prop_points, made.virtual_points @ R.T + 0.3, made.faces)


def blunted(virtual: Surface) -> float:
    """m: how far the middles of faces lie within the cube, at most."""
    middles = (virtual.vertices[virtual.faces].mean(axis=1) - 0.3) @ R
    return float(0.05 - np.abs(middles).max(axis=1).min())


def test_a_cube_keeps_its_edges_and_its_prop_is_a_ball(goal: Goal) -> None:
    assert len(goal.faces) > 5 * MOST_FACES
    outline = outline_of(goal)
    assert len(outline.prop.faces) <= MOST_FACES
    np.testing.assert_array_equal(outline.prop.faces, outline.virtual.faces)
    assert blunted(outline.virtual) < 5e-4
    middles = outline.prop.vertices[outline.prop.faces].mean(axis=1)
    assert np.linalg.norm(middles, axis=1).min() > 0.058


def test_the_edge_claim_rejects_thinning_by_the_prop_alone(goal: Goal) -> None:
    ball = Surface(goal.prop_points, goal.faces)
    flat = thinned(ball)
    shown = flat.vertices * (0.05 / np.abs(flat.vertices).max(axis=1))[:, None]
    assert blunted(Surface(shown @ R.T + 0.3, flat.faces)) > 1e-3


def test_rows_belong_together(goal: Goal) -> None:
    outline = outline_of(goal)
    shown = outline.prop.vertices * (0.05 / np.abs(outline.prop.vertices).max(axis=1))[:, None]
    np.testing.assert_allclose(outline.virtual.vertices, shown @ R.T + 0.3, atol=1e-12)


def test_an_outline_with_few_faces_is_left_alone() -> None:
    cube = box((0.1, 0.1, 0.1))
    outline = outline_of(Goal(cube.vertices, 2 * cube.vertices, cube.faces))
    np.testing.assert_array_equal(outline.virtual.vertices, 2 * cube.vertices)
