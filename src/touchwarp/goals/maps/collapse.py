"""A closed mesh taken apart vertex by vertex, so that it can be put together on its domain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.goals.maps.rings import MOST_NEIGHBOURS, can_collapse, collapse


@dataclass(eq=False)
class Collapsed:
    """What is left of a mesh, and how each removed vertex stood among its neighbours.

    Attributes:
        ring, shift, degree: of what is left; see `rings`.
        alive: (n,) whether a vertex is left.
        removed: (r,) vertices in the order of removal.
        removed_degree: (r,).
        removed_ring: (r, …) the ring when removed, beginning with the vertex collapsed onto.
        removed_shift: (r, …, 2).
    """

    ring: NDArray[np.int32]
    shift: NDArray[np.float64]
    degree: NDArray[np.int32]
    alive: NDArray[np.bool_]
    removed: NDArray[np.int32]
    removed_degree: NDArray[np.int32]
    removed_ring: NDArray[np.int32]
    removed_shift: NDArray[np.float64]


def collapse_to(
    vertices: NDArray[np.float64],
    ring: NDArray[np.int32],
    shift: NDArray[np.float64],
    degree: NDArray[np.int32],
    least: int,
    points: NDArray[np.float64] | None = None,
) -> Collapsed:
    """Collapse edges, well-shaped results first, until `least` vertices are left or none can go.

    Where points (n, 3) of the domain are given, no collapse turns a triangle over there.
    """
    guarded = points is not None
    if points is None:
        points = np.zeros((0, 3))
    alive, removed, counts, rings, shifts = _collapse_all(
        vertices, ring, shift, degree, least, points, guarded
    )
    return Collapsed(ring, shift, degree, alive, removed, counts, rings, shifts)


@njit(cache=True, error_model="numpy", nogil=True)
def _collapse_all(vertices, ring, shift, degree, least, points, guarded):
    n = len(vertices)
    removed = np.empty(n, np.int32)
    removed_degree = np.empty(n, np.int32)
    removed_ring = np.empty((n, MOST_NEIGHBOURS), np.int32)
    removed_shift = np.empty((n, MOST_NEIGHBOURS, 2))
    alive = np.ones(n, np.bool_)
    left, count, most = n, 0, 10
    cost = np.empty(n)
    best = np.empty(n, np.int32)
    while left > least:
        locked = np.zeros(n, np.bool_)
        for v in range(n):
            cost[v] = np.inf
            if not alive[v] or degree[v] > most + 2:
                continue
            for i in range(degree[v]):
                if can_collapse(ring, degree, v, i, most):
                    c = _cost(vertices, ring, degree, v, i)
                    if c < cost[v] and (
                        not guarded or _stays_turned(points, ring, shift, degree, v, i)
                    ):
                        cost[v], best[v] = c, i
        done = 0
        for v in np.argsort(cost):
            if cost[v] == np.inf or done >= max(1, left // 4) or left <= least:
                break
            i = best[v]
            if locked[v] or not can_collapse(ring, degree, v, i, most):
                continue
            k = degree[v]
            for j in range(k):
                removed_ring[count, j] = ring[v, (i + j) % k]
                for d in range(2):
                    removed_shift[count, j, d] = shift[v, (i + j) % k, d]
                locked[ring[v, j]] = True
            removed[count], removed_degree[count] = v, k
            collapse(ring, shift, degree, removed_ring[count], removed_shift[count], k, v)
            alive[v] = False
            count += 1
            left -= 1
            done += 1
        if done == 0:
            most += 4
            if most > MOST_NEIGHBOURS - 4:
                break
    return (
        alive,
        removed[:count],
        removed_degree[:count],
        removed_ring[:count],
        removed_shift[:count],
    )


@njit(cache=True, error_model="numpy")
def _cost(vertices, ring, degree, v, i):
    """Of the triangles after the collapse: poor shape, and how far their normals turn.

    Times the edge's length, so that short edges go first and what is left is even.
    """
    k = degree[v]
    target = ring[v, i]
    worst = 0.0
    length = 0.0
    for d in range(3):
        length += (vertices[target, d] - vertices[v, d]) ** 2
    for j in range(1, k - 1):
        a, b = ring[v, (i + j) % k], ring[v, (i + j + 1) % k]
        new_area, sides, nx, ny, nz = triangle_shape(vertices, target, a, b)
        old_area, _, ox, oy, oz = triangle_shape(vertices, v, a, b)
        turn = 1.0 - (nx * ox + ny * oy + nz * oz) / (new_area * old_area)
        worst = max(worst, sides / (3.46 * new_area) + 5.0 * turn)
    return worst * np.sqrt(length)


@njit(cache=True, error_model="numpy")
def _stays_turned(points, ring, shift, degree, v, i):
    """Whether every triangle after the collapse keeps a sound share of its area on the domain."""
    k = degree[v]
    target = ring[v, i]
    before, least = 0.0, np.inf
    a, b, c = np.empty(3), np.empty(3), np.empty(3)
    for j in range(k):
        for d in range(3):
            a[d], b[d] = points[ring[v, (i + j) % k], d], points[ring[v, (i + j + 1) % k], d]
            if d < 2:
                a[d] += shift[v, (i + j) % k, d]
                b[d] += shift[v, (i + j + 1) % k, d]
            c[d] = points[target, d] + (shift[v, i, d] if d < 2 else 0.0)
        nx, ny, nz = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
        before += points[v, 0] * nx + points[v, 1] * ny + points[v, 2] * nz
        if 0 < j < k - 1:
            least = min(least, c[0] * nx + c[1] * ny + c[2] * nz)
    return least > 1e-3 * before


@njit(cache=True, error_model="numpy")
def triangle_shape(vertices, p, a, b):
    """Twice the area, the sum of squared sides and the cross product of a triangle."""
    ux = vertices[a, 0] - vertices[p, 0]
    uy = vertices[a, 1] - vertices[p, 1]
    uz = vertices[a, 2] - vertices[p, 2]
    wx = vertices[b, 0] - vertices[p, 0]
    wy = vertices[b, 1] - vertices[p, 1]
    wz = vertices[b, 2] - vertices[p, 2]
    nx, ny, nz = uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx
    sides = (
        ux * ux + uy * uy + uz * uz + wx * wx + wy * wy + wz * wz
        + (wx - ux) ** 2 + (wy - uy) ** 2 + (wz - uz) ** 2
    )  # fmt: skip
    return np.sqrt(nx * nx + ny * ny + nz * nz) + 1e-30, sides, nx, ny, nz
