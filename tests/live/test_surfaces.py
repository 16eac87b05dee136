"""What the page draws of a fine mesh: its shape and its map, and no face turned over."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, cKDTree

from touchwarp.live import surfaces
from touchwarp.live.surfaces import CREASE, MOST_FACES, pack_surface

Float = NDArray[np.float64]
Int = NDArray[np.int64]

RADIUS = 0.05
STRETCHED = np.diag([1.2, 0.9, 1.1])


@pytest.fixture(scope="module")
def ball() -> tuple[Float, Int]:
    """A ball whose triangles are thin and of all sizes, as those of a map between two meshes."""
    random = np.random.default_rng(0)
    points = random.normal(size=(20_000, 3))
    points[::2, 0] = 0.02 * np.round(50 * points[::2, 0])  # in stripes
    points *= RADIUS / np.linalg.norm(points, axis=1, keepdims=True)
    points[::2] += random.normal(0.0, 1e-6, points[::2].shape)
    hull = ConvexHull(points)
    corners = points[hull.simplices]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.einsum("nd,nd->n", normals, corners.mean(axis=1)) < 0
    faces = np.where(inward[:, None], hull.simplices[:, ::-1], hull.simplices).astype(np.int64)
    assert len(faces) > MOST_FACES
    return points, faces


def unpacked(packed: bytes) -> tuple[Float, Float, Int]:
    n, m = np.frombuffer(packed, "<u4", 2)
    numbers = np.frombuffer(packed, "<f4", 6 * n, 8).astype(np.float64).reshape(2, n, 3)
    return numbers[0], numbers[1], np.frombuffer(packed, "<u4", 3 * m, 8 + 24 * n).reshape(m, 3)


def turned_share(points: Float, faces: Int) -> float:
    """Share of a ball's area in faces that are turned from its own normal by more than a crease."""
    corners = points[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(normals, axis=1)
    out = corners.mean(axis=1)
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    turned = np.einsum("nd,nd->n", normals, out) < np.cos(CREASE) * twice
    return float(twice[turned].sum() / twice.sum())


def test_a_fine_mesh_is_thinned_to_its_own_shape_and_map(ball: tuple[Float, Int]) -> None:
    points, faces = ball
    prop, virtual, few = unpacked(pack_surface(points, points @ STRETCHED, faces))
    assert len(few) <= MOST_FACES
    assert turned_share(prop, few) < 1e-3
    radii = np.linalg.norm(prop[few].mean(axis=1), axis=1)
    assert np.abs(radii - RADIUS).max() < 0.01 * RADIUS
    # g is affine: linear between the mesh's vertices it is exact, up to float32
    np.testing.assert_allclose(virtual, prop @ STRETCHED, atol=1e-8)


def test_the_claim_rejects_vertices_that_snap_to_the_nearest(
    ball: tuple[Float, Int], monkeypatch: pytest.MonkeyPatch
) -> None:
    points, faces = ball
    thinned: Callable[[Float, Int], tuple[Float, Int]] = surfaces._thinned

    def snapped(both: Float, fine: Int) -> tuple[Float, Int]:
        thin, few = thinned(both, fine)
        return both[cKDTree(both[:, :3]).query(thin[:, :3])[1]], few

    monkeypatch.setattr(surfaces, "_thinned", snapped)
    prop, _, few = unpacked(pack_surface(points, points @ STRETCHED, faces))
    assert turned_share(prop, few) > 1e-3
