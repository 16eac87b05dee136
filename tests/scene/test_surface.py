"""Surfaces are frozen and refuse arrays that are none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from touchwarp.errors import SceneError
from touchwarp.scene import Surface, pose_matrix

VERTICES = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [9, 9, 9]], dtype=np.float64)
FACES = np.array([[0, 1, 2]])


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (VERTICES[:, :1], FACES, r"vertices have shape \(4, 1\); \(n, 3\) or \(n, 2\) is needed"),
        (VERTICES, FACES[:, :2], r"faces have shape \(1, 2\); \(m, 3\) is needed"),
        (VERTICES, FACES[:0], "A surface has no faces"),
        (VERTICES * np.nan, FACES, "4 of 4 vertices are NaN or infinite"),
        (VERTICES, FACES + 2, "Faces refer to vertices 2 to 4, but there are 4 vertices"),
    ],
)
def test_arrays_that_are_no_surface(vertices: Any, faces: Any, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        Surface(vertices, faces)


def test_bounds_leave_out_unused_vertices() -> None:
    surface = Surface(VERTICES.copy(), FACES)
    assert surface.bounds.tolist() == [[0, 0, 0], [1, 1, 0]]
    assert surface.used_vertices.tolist() == VERTICES[:3].tolist()


def test_surfaces_are_frozen() -> None:
    surface = Surface(VERTICES.copy(), FACES.copy())
    for array in (surface.vertices, surface.faces, surface.bounds):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_poses_turn_about_x_then_y_then_z() -> None:
    T = pose_matrix((1, 2, 3), (90, 0, 90))
    # y turns to z about x, and stays there about z; x turns to y about z.
    assert (T @ [0, 1, 0, 1]).tolist() == [1, 2, 4, 1]
    assert (T @ [1, 0, 0, 1]).tolist() == [1, 3, 3, 1]
    assert pose_matrix((0, 0), 30.0)[:2, :2] == pytest.approx(
        np.array([[np.sqrt(3), -1], [1, np.sqrt(3)]]) / 2
    )


def test_an_affine_map_moves_the_vertices() -> None:
    moved = Surface(VERTICES.copy(), FACES).transformed(np.diag([2.0, 3.0, 1.0, 1.0]))
    assert moved.vertices[:3].tolist() == [[0, 0, 0], [2, 0, 0], [0, 3, 0]]
