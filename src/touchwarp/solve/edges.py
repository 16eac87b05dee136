"""Where the exact warp is singular: sharp edges, open rims, walls thinner than two cells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

SHARP_DEG = 30.0
"""An edge across which the surface turns by more than this is sharp."""


def sharp_edges(corners: NDArray[np.float64], faces: NDArray[np.integer]) -> NDArray[np.int64]:
    """(e, 2) rows of `corners` (v, 3): edges with one face, more than two, or a sharp turn.

    Coincident vertices count as one. Faces need not be oriented alike.
    """
    unique, inverse = np.unique(np.round(corners, 9), axis=0, return_inverse=True)
    inverse = inverse.reshape(-1)
    triangles = inverse[faces].astype(np.int64)
    triangles = triangles[
        (triangles[:, 0] != triangles[:, 1])
        & (triangles[:, 1] != triangles[:, 2])
        & (triangles[:, 2] != triangles[:, 0])
    ]
    p = unique[triangles]
    normals = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    length = np.linalg.norm(normals, axis=1)
    normals /= np.maximum(length, 1e-300)[:, None]
    ends = np.sort(
        np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1
    )
    face = np.tile(np.arange(len(triangles)), 3)
    key = ends[:, 0] * len(unique) + ends[:, 1]
    order = np.argsort(key, kind="stable")
    key, face, ends = key[order], face[order], ends[order]
    first = np.flatnonzero(np.r_[True, key[1:] != key[:-1]])
    count = np.diff(np.append(first, len(key)))
    sharp = count != 2
    pair = first[~sharp]
    oriented = _same_way(triangles, face[pair], face[pair + 1], ends[pair])
    signed = np.einsum("ij,ij->i", normals[face[pair]], normals[face[pair + 1]])
    cosine = np.where(oriented, signed, -signed)
    solid = (length[face[pair]] > 0) & (length[face[pair + 1]] > 0)
    sharp[~sharp] = solid & (cosine < np.cos(np.radians(SHARP_DEG)))
    chosen = ends[first[sharp]]
    representative = np.zeros(len(unique), np.int64)
    representative[inverse] = np.arange(len(inverse))
    return np.asarray(representative[chosen])


def _same_way(
    faces: NDArray[np.int64],
    a: NDArray[np.int64],
    b: NDArray[np.int64],
    ends: NDArray[np.int64],
) -> NDArray[np.bool_]:
    """Whether two faces of an edge are oriented alike, that is, run along it in opposite ways."""

    def forward(f: NDArray[np.int64]) -> NDArray[np.bool_]:
        corner = faces[f]
        at = (corner == ends[:, :1]).argmax(axis=1)
        after = np.take_along_axis(corner, ((at + 1) % 3)[:, None], axis=1)[:, 0]
        return np.asarray(after == ends[:, 1])

    return np.asarray(forward(a) != forward(b))


def points_along(
    corners: NDArray[np.float64], edges: NDArray[np.int64], pitch: float
) -> NDArray[np.float64]:
    """(k, 3) points on edges (e, 2), at most `pitch` apart, ends included."""
    a, b = corners[edges[:, 0]], corners[edges[:, 1]]
    steps = np.maximum(np.ceil(np.linalg.norm(b - a, axis=1) / pitch), 1).astype(np.int64)
    which = np.repeat(np.arange(len(edges)), steps + 1)
    start = np.cumsum(steps + 1) - (steps + 1)
    t = (np.arange(len(which)) - start[which]) / steps[which]
    return np.asarray(a[which] + t[:, None] * (b - a)[which])
