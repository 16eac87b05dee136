"""Nearest points and first hits agree with closed forms, on triangles of any size."""

from __future__ import annotations

import numpy as np
import pytest

from touchwarp.goals.surface_tree import SurfaceTree
from touchwarp.scene.shapes import box, sphere

RNG = np.random.default_rng(0)


@pytest.mark.parametrize("radius", [5.0, 0.05, 5e-4])
def test_rays_meet_a_ball_where_they_should(radius: float) -> None:
    """The triangles are down to 10⁻¹⁰ m², which libigl alone takes as edge-on."""
    surface = sphere(radius, 0.2 * radius)
    tree = SurfaceTree(surface.vertices, surface.faces)
    starts = RNG.normal(size=(500, 3))
    starts *= 3 * radius / np.linalg.norm(starts, axis=1, keepdims=True)
    length, face = tree.first_hit(starts, -starts)
    assert length == pytest.approx(np.full(500, 2 / 3), rel=1e-3)
    middles = surface.vertices[surface.faces[face]].mean(axis=1)
    assert np.linalg.norm(middles - starts / 3, axis=1).max() < 0.05 * radius
    length, face = tree.first_hit(starts, starts)
    assert np.isinf(length).all()
    assert (face == -1).all()


def test_rays_along_an_axis_from_a_side_of_a_box() -> None:
    surface = box([0.1, 0.1, 0.1])
    tree = SurfaceTree(surface.vertices, surface.faces)
    starts = np.stack(
        [RNG.uniform(-0.04, 0.04, 300), RNG.uniform(-0.04, 0.04, 300), np.full(300, 0.06)], 1
    )
    length, _ = tree.first_hit(starts, np.tile([0.0, 0.0, -1.0], (300, 1)))
    assert length == pytest.approx(np.full(300, 0.01))


def test_nearest_points_and_their_weights() -> None:
    surface = box([0.1, 0.1, 0.1])
    tree = SurfaceTree(surface.vertices, surface.faces)
    points = np.array([[0.03, 0.01, 0.09], [0.07, 0.0, 0.0]])
    near = tree.nearest(points)
    assert near.distance == pytest.approx([0.04, 0.02])
    assert near.points == pytest.approx(np.array([[0.03, 0.01, 0.05], [0.05, 0, 0]]))
    corners = surface.vertices[surface.faces[near.elements]]
    assert np.einsum("nk,nkj->nj", tree.weights(near), corners) == pytest.approx(near.points)


def test_places_of_the_surface_come_back_to_the_bit() -> None:
    surface = sphere(0.05, 1.0)
    near = SurfaceTree(surface.vertices, surface.faces).nearest(surface.vertices)
    assert np.array_equal(near.points, surface.vertices)
    assert not near.distance.any()


def test_segments_and_no_points() -> None:
    tree = SurfaceTree(np.eye(3), np.array([[0, 1], [1, 2]]))
    assert tree.nearest(np.zeros((1, 3))).distance == pytest.approx([np.sqrt(0.5)])
    assert tree.nearest(np.empty((0, 3))).distance.shape == (0,)
