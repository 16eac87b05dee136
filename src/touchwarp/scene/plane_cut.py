"""Surfaces cut along planes, so that each triangle is on one side."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.scene.surface import Surface

# Vertices this near to the plane, m, are taken to lie on it.
ON_PLANE = 1e-9


def cut_by_plane(
    surface: Surface, point: NDArray[np.float64], normal: NDArray[np.float64]
) -> Surface:
    """The same surface, with triangles that cross the plane cut in two or three.

    Args:
        surface: in space; its vertices come first in the result.
        point: (3,) m: a point of the plane.
        normal: (3,): its normal.
    """
    height = (surface.vertices - point) @ normal
    side = np.where(np.abs(height) <= ON_PLANE, 0, np.sign(height)).astype(int)
    of_face = side[surface.faces]
    crossed = (of_face.min(axis=1) < 0) & (of_face.max(axis=1) > 0)
    if not crossed.any():
        return surface
    faces = surface.faces[crossed]
    pairs = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2), axis=2)
    base = len(surface.vertices)
    keys = pairs[..., 0] * base + pairs[..., 1]
    cuts = side[pairs[..., 0]] * side[pairs[..., 1]] < 0
    unique, number = np.unique(keys[cuts], return_inverse=True)
    ends = np.stack([unique // base, unique % base], axis=1)
    share = (height[ends[:, 0]] / (height[ends[:, 0]] - height[ends[:, 1]]))[:, None]
    low, high = surface.vertices[ends[:, 0]], surface.vertices[ends[:, 1]]
    on_edge = np.full(keys.shape, -1)
    on_edge[cuts] = base + number
    new: list[tuple[int, int, int]] = []
    for face, cut in zip(faces.tolist(), on_edge.tolist(), strict=True):
        new += _pieces(face, cut)
    return Surface(
        np.concatenate([surface.vertices, low + share * (high - low)]),
        np.concatenate([surface.faces[~crossed], np.array(new, dtype=np.int64)]),
    )


def _pieces(face: list[int], cut: list[int]) -> list[tuple[int, int, int]]:
    """A triangle cut through two edges, or an edge and a vertex; cut[i] is on edge i to i + 1."""
    if sum(vertex >= 0 for vertex in cut) == 1:
        i = next(i for i in range(3) if cut[i] >= 0)
        a, b, c = (face[(i + k) % 3] for k in range(3))
        return [(a, cut[i], c), (cut[i], b, c)]
    i = next(i for i in range(3) if cut[i] < 0)  # the edge a-b is whole, c is alone
    a, b, c = (face[(i + k) % 3] for k in range(3))
    on_bc, on_ca = cut[(i + 1) % 3], cut[(i + 2) % 3]
    return [(a, b, on_bc), (a, on_bc, on_ca), (on_ca, on_bc, c)]
