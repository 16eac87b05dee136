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
) -> Collapsed:
    """Collapse edges, well-shaped results first, until `least` vertices are left or none can go."""
    alive, removed, counts, rings, shifts = _collapse_all(vertices, ring, shift, degree, least)
    return Collapsed(ring, shift, degree, alive, removed, counts, rings, shifts)


@njit(cache=True, error_model="numpy")
def _collapse_all(vertices, ring, shift, degree, least):
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
                    if c < cost[v]:
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
                removed_shift[count, j] = shift[v, (i + j) % k]
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
    """Of the triangles after the collapse: poor shape, and how far their normals turn."""
    k = degree[v]
    target = ring[v, i]
    worst = 0.0
    for j in range(1, k - 1):
        a, b = ring[v, (i + j) % k], ring[v, (i + j + 1) % k]
        new_area, sides, nx, ny, nz = _triangle(vertices, target, a, b)
        old_area, _, ox, oy, oz = _triangle(vertices, v, a, b)
        turn = 1.0 - (nx * ox + ny * oy + nz * oz) / (new_area * old_area)
        worst = max(worst, sides / (3.46 * new_area) + 5.0 * turn)
    return worst


@njit(cache=True, error_model="numpy")
def _triangle(vertices, p, a, b):
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
