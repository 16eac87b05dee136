"""Lines cross surfaces where arithmetic says, through edges and vertices too."""

from __future__ import annotations

import numpy as np
import pytest

from touchwarp.goals.line_crossings import ParallelLines, RadialLines, across
from touchwarp.goals.star_centre import even_directions
from touchwarp.scene import Surface
from touchwarp.scene.pose import rotation_matrix
from touchwarp.scene.shapes import box, make_shape, sphere

HALF = np.array([0.05, 0.04, 0.03])
BOX = box(2 * HALF)
R = rotation_matrix((20.0, 40.0, 70.0))


def box_exit(directions: np.ndarray) -> np.ndarray:
    """How far a ray from a box's centre runs within it: the nearest of its slabs' ends."""
    with np.errstate(divide="ignore"):
        return np.min(HALF / np.abs(directions), axis=1)


def test_rays_leave_a_box_where_slabs_say() -> None:
    through_features = [(1, 0, 0), (0, 0, -1), HALF, HALF * [1, 1, 0], HALF * [1, -1, 1]]
    directions = np.concatenate([even_directions(5000), np.array(through_features, dtype=float)])
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    turned = Surface(BOX.vertices @ R.T + 0.2, BOX.faces)
    for surface, rays, centre in (
        (BOX, directions, np.zeros(3)),
        (turned, directions @ R.T, np.full(3, 0.2)),
    ):
        found = RadialLines(surface, centre).crossings(rays)
        assert (found.count == 1).all()
        np.testing.assert_allclose(found.places[:, 0], box_exit(directions), rtol=1e-7)


def test_the_box_claim_rejects_a_centre_a_little_off() -> None:
    found = RadialLines(BOX, np.array([1e-4, 0, 0])).crossings(even_directions(5000))
    assert np.abs(found.places[:, 0] - box_exit(even_directions(5000))).max() > 5e-5


@pytest.mark.parametrize("turn", [np.eye(3), R])
def test_lines_enter_and_leave_a_box(turn: np.ndarray) -> None:
    surface = Surface(BOX.vertices @ turn.T, BOX.faces)
    rng = np.random.default_rng(0)
    points = rng.uniform(-1.5, 1.5, (5000, 3)) * HALF
    points[:50, :2] = 0.0  # through the diagonal of both faces
    inside = (np.abs(points[:, :2]) < HALF[:2]).all(axis=1)
    found = ParallelLines(surface, turn[:, 2]).crossings(points @ turn.T)
    np.testing.assert_array_equal(found.count, 2 * inside)
    np.testing.assert_allclose(found.places[inside, :2], [[-0.03, 0.03]] * inside.sum(), rtol=1e-9)


def test_a_thin_wall_is_crossed_as_often_as_it_has_sides() -> None:
    mug = make_shape("mug", {})
    high_in_the_wall = np.array([[0.0, -0.1, 0.0475]])  # along y: two walls of two sides
    found = ParallelLines(mug, np.array([0.0, 1.0, 0.0])).crossings(high_in_the_wall)
    assert found.count.tolist() == [4]
    expected = [-0.04, -0.036, 0.036, 0.04]
    np.testing.assert_allclose(found.places[0, :4], expected, atol=3e-5)
    assert found.last[0] == pytest.approx(found.places[0, 3])


def test_the_last_crossing_is_known_even_of_more_than_are_listed() -> None:
    heights = np.arange(20) * 0.01
    sheet = np.array([[-1, -1, 0], [3, -1, 0], [-1, 3, 0]])
    stack = np.concatenate([sheet + np.array([0, 0, h]) for h in heights])
    surface = Surface(stack, np.arange(60).reshape(20, 3))
    found = ParallelLines(surface, np.array([0, 0, 1.0])).crossings(np.zeros((1, 3)))
    assert found.count.tolist() == [8]
    assert found.last[0] == pytest.approx(0.19)


def test_many_rays_hit_a_sphere_once() -> None:
    ball = sphere(0.05)
    centre = np.array([0.01, -0.02, 0.015])
    found = RadialLines(ball, centre).crossings(even_directions(20_000))
    assert (found.count == 1).all()
    shown = centre + found.places[:, :1] * even_directions(20_000)
    radius = np.linalg.norm(shown, axis=1)
    assert radius.max() <= 0.05 + 1e-12
    assert radius.min() >= 0.05 - 2e-5  # the facets' depth


def test_the_frame_across_a_direction_is_right_handed() -> None:
    for normal in (*np.eye(3), R[:, 1]):
        first, second = across(normal)
        np.testing.assert_allclose(np.cross(first, second), normal, atol=1e-15)
