"""The neighbours of each vertex, in order around it, and edge collapses on them.

`ring[v, :degree[v]]` runs counter-clockwise seen from outside. `shift[v, i]` is the lattice vector
that takes the neighbour's coordinates on the flat torus to v's side of the cut; zero on a sphere.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.errors import GoalError

MOST_NEIGHBOURS = 64


def rings_of(
    faces: NDArray[np.int64], corner_shift: NDArray[np.float64], vertices: int
) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.int32]]:
    """`ring`, `shift` and `degree` of a closed manifold mesh; arguments as of `build_rings`.

    Raises:
        GoalError: a vertex has too many neighbours.
    """
    ring, shift, degree, built = build_rings(faces, corner_shift, vertices)
    if not built:
        raise GoalError(
            f"the mesh has a vertex with more than {MOST_NEIGHBOURS} neighbours, where a map needs "
            "rounder triangles: remesh it."
        )
    return ring, shift, degree


@njit(cache=True, error_model="numpy")
def build_rings(faces, corner_shift, vertices):
    """Rings of a closed manifold mesh from its faces (m, 3) and corner shifts (m, 3, 2).

    The last value is False where a vertex has more than `MOST_NEIGHBOURS` neighbours.
    """
    ring = np.full((vertices, MOST_NEIGHBOURS), -1, np.int32)
    shift = np.zeros((vertices, MOST_NEIGHBOURS, 2))
    degree = np.zeros(vertices, np.int32)
    after = np.full((vertices, MOST_NEIGHBOURS, 2), -1, np.int32)
    offset = np.zeros((vertices, MOST_NEIGHBOURS, 2))
    for f in range(len(faces)):
        for k in range(3):
            v, ahead, back = faces[f, k], faces[f, (k + 1) % 3], faces[f, (k + 2) % 3]
            if degree[v] == MOST_NEIGHBOURS:
                return ring, shift, degree, False
            after[v, degree[v], 0], after[v, degree[v], 1] = ahead, back
            for d in range(2):
                offset[v, degree[v], d] = corner_shift[f, (k + 1) % 3, d] - corner_shift[f, k, d]
            degree[v] += 1
    for v in range(vertices):
        current = 0
        for i in range(degree[v]):
            ring[v, i] = after[v, current, 0]
            shift[v, i, 0], shift[v, i, 1] = offset[v, current, 0], offset[v, current, 1]
            follower = after[v, current, 1]
            for j in range(degree[v]):
                if after[v, j, 0] == follower:
                    current = j
                    break
    return ring, shift, degree, True


@njit(cache=True, error_model="numpy")
def place_in_ring(ring, degree, v, neighbour):
    for i in range(degree[v]):
        if ring[v, i] == neighbour:
            return i
    return -1


@njit(cache=True, error_model="numpy")
def erase(ring, shift, degree, v, i):
    for j in range(i, degree[v] - 1):
        ring[v, j] = ring[v, j + 1]
        shift[v, j, 0], shift[v, j, 1] = shift[v, j + 1, 0], shift[v, j + 1, 1]
    degree[v] -= 1


@njit(cache=True, error_model="numpy")
def insert(ring, shift, degree, v, i, neighbour, shift_x, shift_y):
    for j in range(degree[v], i, -1):
        ring[v, j] = ring[v, j - 1]
        shift[v, j, 0], shift[v, j, 1] = shift[v, j - 1, 0], shift[v, j - 1, 1]
    ring[v, i] = neighbour
    shift[v, i, 0], shift[v, i, 1] = shift_x, shift_y
    degree[v] += 1


@njit(cache=True, error_model="numpy")
def can_collapse(ring, degree, v, i, most):
    """Whether moving v onto its i-th neighbour leaves a simple mesh of degrees 3 to `most`."""
    k = degree[v]
    target = ring[v, i]
    merged = degree[target] + k - 4
    if merged > most or merged < 3:
        return False
    if degree[ring[v, (i + 1) % k]] <= 3 or degree[ring[v, (i - 1) % k]] <= 3:
        return False
    for j in range(2, k - 1):
        if place_in_ring(ring, degree, target, ring[v, (i + j) % k]) >= 0:
            return False
    return True


@njit(cache=True, error_model="numpy")
def collapse(ring, shift, degree, old_ring, old_shift, k, v):
    """Remove v, whose ring (k,) begins with the vertex that it moves onto."""
    target = old_ring[0]
    for e in (1, k - 1):
        w = old_ring[e]
        erase(ring, shift, degree, w, place_in_ring(ring, degree, w, v))
    for j in range(2, k - 1):
        w = old_ring[j]
        i = place_in_ring(ring, degree, w, v)
        ring[w, i] = target
        for d in range(2):
            shift[w, i, d] = old_shift[0, d] - old_shift[j, d]
    i = place_in_ring(ring, degree, target, v)
    erase(ring, shift, degree, target, i)
    for j in range(2, k - 1):
        insert(
            ring,
            shift,
            degree,
            target,
            i + j - 2,
            old_ring[j],
            old_shift[j, 0] - old_shift[0, 0],
            old_shift[j, 1] - old_shift[0, 1],
        )


@njit(cache=True, error_model="numpy")
def restore(ring, shift, degree, old_ring, old_shift, k, v):
    """Undo `collapse`."""
    target = old_ring[0]
    for j in range(2, k - 1):
        w = old_ring[j]
        erase(ring, shift, degree, target, place_in_ring(ring, degree, target, w))
        i = place_in_ring(ring, degree, w, target)
        ring[w, i] = v
        shift[w, i, 0], shift[w, i, 1] = -old_shift[j, 0], -old_shift[j, 1]
    i = place_in_ring(ring, degree, target, old_ring[1]) + 1
    insert(ring, shift, degree, target, i, v, -old_shift[0, 0], -old_shift[0, 1])
    i = place_in_ring(ring, degree, old_ring[1], old_ring[2]) + 1
    insert(ring, shift, degree, old_ring[1], i, v, -old_shift[1, 0], -old_shift[1, 1])
    last = old_ring[k - 1]
    i = place_in_ring(ring, degree, last, target) + 1
    insert(ring, shift, degree, last, i, v, -old_shift[k - 1, 0], -old_shift[k - 1, 1])
    degree[v] = k
    for j in range(k):
        ring[v, j] = old_ring[j]
        shift[v, j, 0], shift[v, j, 1] = old_shift[j, 0], old_shift[j, 1]
