"""Small surfaces, so that maps of them take moments, and a cache of their own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from touchwarp.goals.maps import parameterise
from touchwarp.scene.surface import Surface


@pytest.fixture(autouse=True)
def small_and_alone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(parameterise, "EDGES_PER_SIZE", 14)
    monkeypatch.setenv("TOUCHWARP_CACHE", str(tmp_path / "cache"))


def ring_surface(
    radius: float = 0.03, tube: float = 0.012, around: int = 28, across: int = 14
) -> Surface:
    """A torus about the z axis, m."""
    u, v = np.meshgrid(
        2 * np.pi * np.arange(around) / around,
        2 * np.pi * np.arange(across) / across,
        indexing="ij",
    )
    reach = radius + tube * np.cos(v)
    points = np.stack([reach * np.cos(u), reach * np.sin(u), tube * np.sin(v)], -1).reshape(-1, 3)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(around), np.arange(across), indexing="ij"))
    a, b = i * across + j, (i + 1) % around * across + j
    c, d = (i + 1) % around * across + (j + 1) % across, i * across + (j + 1) % across
    return Surface(points, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def slab_with_holes(holes: int) -> Surface:
    """A slab with square holes in a row: as many of them as its genus."""
    import manifold3d

    slab = manifold3d.Manifold.cube((0.02 + 0.04 * holes, 0.05, 0.02))
    for k in range(holes):
        hole = manifold3d.Manifold.cube((0.02, 0.02, 0.04))
        slab -= hole.translate((0.02 + 0.04 * k, 0.015, -0.01))
    mesh = slab.to_mesh64()
    return Surface(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts, np.int64))


def two_holed_surface() -> Surface:
    return slab_with_holes(2)


def crowded_surface() -> Surface:
    """A double cone; its tips have 80 neighbours each."""
    n = 80
    angle = 2 * np.pi * np.arange(n) / n
    points = np.concatenate(
        [np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1), [[0, 0, 1], [0, 0, -1]]]
    )
    i = np.arange(n)
    j = (i + 1) % n
    faces = np.concatenate([np.stack([i, j, 0 * i + n], 1), np.stack([j, i, 0 * i + n + 1], 1)])
    return Surface(points, faces)
