"""Folds of straight images are ironed out, and what is flat stays."""

from __future__ import annotations

import numpy as np

from touchwarp.goals.maps.iron import folded_faces, iron
from touchwarp.goals.surface_tree import SurfaceTree
from touchwarp.scene.shapes import sphere

BALL = sphere(0.03, 0.5)
NORMALS = np.cross(
    BALL.vertices[BALL.faces[:, 1]] - BALL.vertices[BALL.faces[:, 0]],
    BALL.vertices[BALL.faces[:, 2]] - BALL.vertices[BALL.faces[:, 0]],
)
TREE = SurfaceTree(BALL.vertices, BALL.faces)


def test_a_vertex_pushed_over_its_neighbours_comes_back() -> None:
    images = BALL.vertices.copy()
    neighbours = np.unique(BALL.faces[(BALL.faces == 0).any(axis=1)])
    images[0] = TREE.nearest(2.5 * images[neighbours[1:2]] - 1.5 * BALL.vertices[:1]).points[0]
    assert folded_faces(images, BALL.faces, TREE, NORMALS).any()  # the twin: it is a fold
    flat = iron(images, BALL.faces, BALL)
    assert not folded_faces(flat, BALL.faces, TREE, NORMALS).any()
    assert TREE.nearest(flat).distance.max() <= 1e-12


def test_images_without_folds_stay_as_they_are() -> None:
    assert np.array_equal(iron(BALL.vertices, BALL.faces, BALL), BALL.vertices)
