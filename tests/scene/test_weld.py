"""Welding is exact: it undoes what STL does to a mesh, and nothing more."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from touchwarp.scene import weld as weld_module
from touchwarp.scene.shapes import sphere
from touchwarp.scene.weld import weld


def test_triangle_soup_becomes_the_mesh_again() -> None:
    mesh = sphere(0.03)
    soup = mesh.vertices[mesh.faces].reshape(-1, 3)
    vertices, faces = weld(soup, np.arange(len(soup)).reshape(-1, 3))
    assert len(vertices) == len(mesh.vertices)
    assert np.array_equal(vertices[faces], mesh.vertices[mesh.faces])


@settings(max_examples=50, deadline=None)
@given(
    hnp.arrays(
        np.float64,
        st.tuples(st.integers(3, 30), st.just(3)),
        elements=st.sampled_from([0, -0.0, 1]),
    )
)
def test_welding_agrees_with_sorting_rows(points: np.ndarray) -> None:
    faces = np.arange(len(points) // 3 * 3).reshape(-1, 3)
    vertices, welded = weld(points, faces)
    used = np.unique(points[faces.ravel()] + 0.0, axis=0)
    proper = [f for f in faces if len(np.unique(points[f] + 0.0, axis=0)) == 3]
    assert len(vertices) == len(used)
    assert np.array_equal(vertices[welded], points[np.array(proper, int).reshape(-1, 3)])


def test_a_hash_collision_does_not_merge_two_points(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(weld_module, "_hash", lambda v: np.zeros(len(v), dtype=np.uint64))
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [0, 0, 0], [1, 1, 0.0]])
    vertices, faces = weld(points, np.array([[0, 1, 2], [3, 4, 5]]))
    assert len(vertices) == 4
    assert np.array_equal(vertices[faces], points[[[0, 1, 2], [3, 4, 5]]])


def test_vertices_keep_the_order_of_the_file() -> None:
    points = np.random.default_rng(1).normal(size=(300, 3))
    vertices, faces = weld(points, np.arange(300).reshape(-1, 3))
    assert np.array_equal(vertices, points)
    assert np.array_equal(faces, np.arange(300).reshape(-1, 3))


def test_unused_vertices_are_dropped() -> None:
    points = np.array([[9, 9, 9], [0, 0, 0], [1, 0, 0], [0, 1, 0.0]])
    vertices, faces = weld(points, np.array([[1, 2, 3]]))
    assert vertices.tolist() == points[1:].tolist()
    assert faces.tolist() == [[0, 1, 2]]
