"""Quadratic fields on tetrahedra, at the nodes of a regular grid and at scattered points.

Sampling a finite-element field point by point costs the packages 4–15 s for a 128³ table, so it is
rasterised instead: each tetrahedron writes the grid nodes that lie in it.
"""

from __future__ import annotations

import numpy as np
from numba import njit, prange

EDGES = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]])
"""The edge on whose middle each of the last six of a tetrahedron's ten nodes lies."""


@njit(cache=True)
def _inverse(corners, inverse):
    """Rows of the matrix that takes x − corner 0 to the last three barycentric coordinates."""
    volume = 0.0
    for d in range(3):
        e, f = (d + 1) % 3, (d + 2) % 3
        for k in range(3):
            one, two = 1 + (k + 1) % 3, 1 + (k + 2) % 3
            inverse[k, d] = (corners[one, e] - corners[0, e]) * (corners[two, f] - corners[0, f])
            inverse[k, d] -= (corners[one, f] - corners[0, f]) * (corners[two, e] - corners[0, e])
        volume += (corners[1, d] - corners[0, d]) * inverse[0, d]
    if volume == 0.0:
        return False
    for k in range(3):
        for d in range(3):
            inverse[k, d] /= volume
    return True


@njit(cache=True)
def _span(corners, d):
    """Least and greatest coordinate of a tetrahedron along an axis."""
    one, two, three, four = corners[0, d], corners[1, d], corners[2, d], corners[3, d]
    return min(min(one, two), min(three, four)), max(max(one, two), max(three, four))


@njit(cache=True)
def _barycentric(x, y, z, corner, inverse, weight):
    dx, dy, dz = x - corner[0], y - corner[1], z - corner[2]
    weight[0] = 1.0
    for k in range(3):
        weight[k + 1] = inverse[k, 0] * dx + inverse[k, 1] * dy + inverse[k, 2] * dz
        weight[0] -= weight[k + 1]
    return min(min(weight[0], weight[1]), min(weight[2], weight[3]))


@njit(cache=True)
def _quadratic(weight, values, out):
    for c in range(3):
        out[c] = 0.0
    for k in range(4):
        shape = weight[k] * (2.0 * weight[k] - 1.0)
        for c in range(3):
            out[c] += shape * values[k, c]
    for k in range(6):
        shape = 4.0 * weight[EDGES[k, 0]] * weight[EDGES[k, 1]]
        for c in range(3):
            out[c] += shape * values[4 + k, c]


@njit(cache=True, parallel=True)
def _rasterise(corners, values, origin, spacing, table):
    for t in prange(corners.shape[0]):
        inverse, weight = np.empty((3, 3)), np.empty(4)
        if not _inverse(corners[t], inverse):
            continue
        first, last = np.empty(3, np.int64), np.empty(3, np.int64)
        for d in range(3):
            low, high = _span(corners[t], d)
            first[d] = max(0, int(np.ceil((low - origin[d]) / spacing[d] - 1e-9)))
            last[d] = min(table.shape[d] - 1, int((high - origin[d]) / spacing[d] + 1e-9))
        for i in range(first[0], last[0] + 1):
            for j in range(first[1], last[1] + 1):
                for k in range(first[2], last[2] + 1):
                    x = origin[0] + i * spacing[0]
                    y = origin[1] + j * spacing[1]
                    z = origin[2] + k * spacing[2]
                    if _barycentric(x, y, z, corners[t, 0], inverse, weight) >= -1e-9:
                        _quadratic(weight, values[t], table[i, j, k])


@njit(cache=True)
def _scatter(corners, values, points, bucket_start, origin, width, counts, best, result):
    inverse, weight = np.empty((3, 3)), np.empty(4)
    first, last = np.empty(3, np.int64), np.empty(3, np.int64)
    for t in range(corners.shape[0]):
        if not _inverse(corners[t], inverse):
            continue
        for d in range(3):
            low, high = _span(corners[t], d)
            margin = 0.05 * (high - low)
            first[d] = max(0, int((low - margin - origin[d]) / width[d]))
            last[d] = min(counts[d] - 1, int((high + margin - origin[d]) / width[d]))
        for i in range(first[0], last[0] + 1):
            for j in range(first[1], last[1] + 1):
                for k in range(first[2], last[2] + 1):
                    b = (i * counts[1] + j) * counts[2] + k
                    for p in range(bucket_start[b], bucket_start[b + 1]):
                        x, y, z = points[p]
                        least = _barycentric(x, y, z, corners[t, 0], inverse, weight)
                        if least > best[p]:
                            best[p] = least
                            _quadratic(weight, values[t], result[p])


def rasterise(corners: np.ndarray, values: np.ndarray, axes: list[np.ndarray]) -> np.ndarray:
    """The field at the nodes of a regular grid, 0 where there is no tetrahedron.

    Args:
        corners: (t, 4, 3) m.
        values: (t, 10, 3) at the corners, then at the middles of `EDGES`.
        axes: three, evenly spaced, m.
    Returns:
        (nx, ny, nz, 3).
    """
    table = np.zeros((*(len(axis) for axis in axes), 3))
    origin = np.array([axis[0] for axis in axes])
    spacing = np.array([axis[1] - axis[0] for axis in axes])
    _rasterise(corners, values, origin, spacing, table)
    return table


def evaluate(corners: np.ndarray, values: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The field (n, 3) at points (n, 3) m, in the tetrahedron that holds each, or nearly so.

    Raises:
        ValueError: a point is far from every tetrahedron.
    """
    counts = np.array([40, 40, 40])
    low, high = points.min(axis=0), points.max(axis=0)
    width = (high - low) / counts + 1e-12
    bucket = np.minimum(((points - low) / width).astype(np.int64), counts - 1)
    bucket = (bucket[:, 0] * counts[1] + bucket[:, 1]) * counts[2] + bucket[:, 2]
    order = np.argsort(bucket, kind="stable")
    start = np.searchsorted(bucket[order], np.arange(counts.prod() + 1))
    best, result = np.full(len(points), -np.inf), np.zeros((len(points), 3))
    _scatter(corners, values, points[order], start, low, width, counts, best, result)
    if best.min() < -1.0:
        raise ValueError(f"{(best < -1.0).sum()} points are not in the finite-element mesh.")
    back = np.empty_like(result)
    back[order] = result
    return back


def compile_kernels() -> None:
    """Compile before the clock starts."""
    corners = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]], dtype=np.float64)
    rasterise(corners, np.zeros((1, 10, 3)), [np.linspace(0, 1, 2)] * 3)
