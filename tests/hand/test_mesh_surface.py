"""Nearest points of a mesh."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from tests.hand.hands import RADII, pose
from tests.hand.test_contact import HANDS, PLAIN, ball
from tests.warp.tables import turned
from touchwarp.hand import HandOptions, HandRetargeter, MeshSurface
from touchwarp.scene.surface import Surface


def mesh(inverted: bool = False) -> Surface:
    sphere = trimesh.creation.icosphere(subdivisions=4, radius=0.05)
    return Surface(sphere.vertices, sphere.faces[:, ::-1] if inverted else sphere.faces)


def points() -> np.ndarray:
    return np.random.default_rng(0).normal(0.0, 0.05, (200, 3))


def differences(surface: Surface) -> tuple[float, float]:
    """m and of unit vectors, from a ball."""
    x = points()
    nearest, normals = MeshSurface(surface)(x)
    expected, outward = ball(x)
    far = np.linalg.norm(x, axis=1) > 0.02
    return (
        float(np.linalg.norm(nearest - expected, axis=1)[far].max()),
        float(np.abs(normals - outward)[far].max()),
    )


def test_it_is_the_ball_that_it_was_made_of() -> None:
    away, turned_by = differences(mesh())
    assert away < 4e-3  # towards the middle of the ball facets matter
    assert turned_by < 0.1


def test_that_claim_rejects_faces_turned_inwards() -> None:
    assert differences(mesh(inverted=True))[1] > 1.0


def test_it_goes_along_with_its_prop() -> None:
    T, x = turned(), points()
    surface = MeshSurface(mesh())
    nearest, normals = surface(x)
    surface.place(T)
    carried = surface(x @ T[:3, :3].T + T[:3, 3])
    np.testing.assert_allclose(carried[0], nearest @ T[:3, :3].T + T[:3, 3], atol=1e-9)
    np.testing.assert_allclose(carried[1], normals @ T[:3, :3].T, atol=1e-9)
    with pytest.raises(ValueError, match="T_room_scene is not rigid"):
        surface.place(pose(2 * np.eye(3), np.zeros(3)))


def test_hands_take_it_and_lost_fingers_do_not_matter() -> None:
    shown = []
    for surface in (ball, MeshSurface(mesh())):
        hand = HANDS[1].copy()
        hand[24] = np.nan
        options = HandOptions(contact="skin", surface=surface, onset=0.0)
        shown.append(HandRetargeter(options).update(PLAIN, hand, 0.0, RADII))
    kept = np.isfinite(shown[0]).all(axis=(1, 2))
    assert kept.sum() == 21
    assert np.abs(shown[0][kept, :3, 3] - shown[1][kept, :3, 3]).max() < 0.5e-3


def test_segments_are_refused() -> None:
    with pytest.raises(ValueError, match="triangles are needed"):
        MeshSurface(Surface([[0, 0], [1, 0], [0, 1]], [[0, 1], [1, 2], [2, 0]]))
