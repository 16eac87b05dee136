"""A closed mesh laid out on its domain, the sphere or the flat torus, with no triangle turned over.

What is left after all collapses is laid out by hand; then each vertex returns into the kernel of
its ring, and it and its neighbours relax by the barrier energy of `star`.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.maps.closed_mesh import ClosedMesh
from touchwarp.goals.maps.collapse import Collapsed, collapse_to
from touchwarp.goals.maps.layout import Layout
from touchwarp.goals.maps.rings import MOST_NEIGHBOURS, build_rings, restore, rings_of
from touchwarp.goals.maps.star import kernel_point, relax, set_targets

DIRICHLET = 0.1
"""The weight μ of shape beside area."""
SWEEPS = 6
RELAXING_SWEEPS = 30
LEAST_ON_SPHERE = 4
LEAST_ON_TORUS = 7


def embed(
    mesh: ClosedMesh, corner_shift: NDArray[np.float64], shape: float = DIRICHLET
) -> NDArray[np.float64]:
    """(n, 3) points of the domain: unit vectors, or (x, y, 1) on the torus of area 1.

    Args:
        mesh: genus 0 or 1.
        corner_shift: (m, 3, 2) what to add to a corner's point to stand beside the face's first
            corner; zero on the sphere.

    Raises:
        GoalError: the mesh cannot be laid out: a vertex has too many neighbours.
    """
    flat = mesh.genus == 1
    vertices = (mesh.vertices - mesh.centre) / mesh.diagonal
    ring, shift, degree = rings_of(mesh.faces, corner_shift, len(vertices))
    least = LEAST_ON_TORUS if flat else LEAST_ON_SPHERE
    left = collapse_to(vertices, ring, shift, degree, least)
    points = np.zeros_like(vertices)
    ok = _lay_torus(points, left) if flat else _lay_tetrahedron(points, left)
    if not ok:
        raise GoalError(
            f"the mesh cannot be laid out on the {'torus' if flat else 'sphere'}: "
            f"{int(left.alive.sum())} vertices are left that no collapse can take; remesh it."
        )
    turned = _put_back(
        vertices,
        points,
        left.ring,
        left.shift,
        left.degree,
        left.alive,
        left.removed,
        left.removed_degree,
        left.removed_ring,
        left.removed_shift,
        1.0 if flat else 4 * np.pi,
        flat,
        shape,
    )
    if turned:
        raise GoalError(
            f"the mesh cannot be laid out on the {'torus' if flat else 'sphere'}: {turned} "
            "triangles would be turned over; remesh it."
        )
    return points


def relax_layout(layout: Layout) -> Layout:
    """The layout after some sweeps in which each vertex relaxes among its neighbours."""
    mesh = layout.mesh
    vertices = (mesh.vertices - mesh.centre) / mesh.diagonal
    ring, shift, degree, _ = build_rings(mesh.faces, layout.corner_shift, len(vertices))
    alive = np.ones(len(vertices), np.bool_)
    points = layout.points.copy()
    scale = layout.domain_area / (mesh.area / mesh.diagonal**2)
    target, slope = np.empty((MOST_NEIGHBOURS, 4)), np.empty(9)
    state = (vertices, points, ring, shift, degree, alive)
    sweep(*state, scale, target, slope, layout.flat, RELAXING_SWEEPS, DIRICHLET)
    return layout.moved(points)


def _lay_tetrahedron(points: NDArray[np.float64], left: Collapsed) -> bool:
    base = np.flatnonzero(left.alive)
    if len(base) != LEAST_ON_SPHERE:
        return False
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(3)
    points[base] = corners
    v = base[0]
    first, second = points[left.ring[v, :2]]
    if np.dot(points[v], np.cross(first, second)) < 0:
        points[base] = corners[[0, 1, 3, 2]]
    return True


def _lay_torus(points: NDArray[np.float64], left: Collapsed) -> bool:
    """Each vertex at the mean of its neighbours (Tutte): one-to-one on a flat torus."""
    base = np.flatnonzero(left.alive)
    number = np.full(len(left.alive), -1)
    number[base] = np.arange(len(base))
    matrix = np.zeros((len(base), len(base)))
    pull = np.zeros((len(base), 2))
    for v in base:
        for i in range(left.degree[v]):
            matrix[number[v], number[v]] += 1
            matrix[number[v], number[left.ring[v, i]]] -= 1
            pull[number[v]] += left.shift[v, i]
    points[:, 2] = 1.0
    points[base, :2] = np.linalg.lstsq(matrix, pull, rcond=None)[0]
    for v in base:
        k = left.degree[v]
        around = points[left.ring[v, :k], :2] + left.shift[v, :k] - points[v, :2]
        after = np.roll(around, -1, axis=0)
        if (around[:, 0] * after[:, 1] - around[:, 1] * after[:, 0]).min() <= 1e-12:
            return False
    return True


@njit(cache=True, error_model="numpy", nogil=True)
def _put_back(
    vertices,
    points,
    ring,
    shift,
    degree,
    alive,
    removed,
    removed_degree,
    removed_ring,
    removed_shift,
    total,
    flat,
    shape,
):
    target = np.empty((MOST_NEIGHBOURS, 4))
    slope = np.empty(9)
    corners = np.empty((MOST_NEIGHBOURS, 3))
    count = alive.sum()
    turned = 0
    scale = area_scale(vertices, ring, degree, alive, total)
    state = (vertices, points, ring, shift, degree, alive)
    if flat:
        sweep(*state, scale, target, slope, flat, 60, shape)
    due = int(count * 1.4) + 1
    for r in range(len(removed) - 1, -1, -1):
        v, k = removed[r], removed_degree[r]
        for j in range(k):
            w = removed_ring[r, j]
            corners[j, 0] = points[w, 0] + removed_shift[r, j, 0]
            corners[j, 1] = points[w, 1] + removed_shift[r, j, 1]
            corners[j, 2] = points[w, 2]
        point, depth = kernel_point(corners, k, flat)
        points[v] = point
        turned += depth <= 0.0
        restore(ring, shift, degree, removed_ring[r], removed_shift[r], k, v)
        alive[v] = True
        count += 1
        for j in range(-1, k + 1):
            w = v if j < 0 or j == k else removed_ring[r, j]
            set_targets(vertices, ring, degree, w, scale, target)
            relax(points, ring, shift, degree, w, target, shape, slope, flat)
        if count >= due:
            due = int(count * 1.4) + 1
            scale = area_scale(vertices, ring, degree, alive, total)
            rounds = SWEEPS if count > 1500 else 40
            sweep(*state, scale, target, slope, flat, rounds, shape)
    scale = area_scale(vertices, ring, degree, alive, total)
    sweep(*state, scale, target, slope, flat, SWEEPS, shape)
    return turned


@njit(cache=True, error_model="numpy", nogil=True)
def sweep(vertices, points, ring, shift, degree, alive, scale, target, slope, flat, rounds, shape):
    for _ in range(rounds):
        for v in range(len(vertices)):
            if alive[v]:
                set_targets(vertices, ring, degree, v, scale, target)
                relax(points, ring, shift, degree, v, target, shape, slope, flat)


@njit(cache=True, error_model="numpy")
def area_scale(vertices, ring, degree, alive, total):
    """The domain's area over that of the vertices' triangles that are there now."""
    area = 0.0
    for v in range(len(vertices)):
        if not alive[v]:
            continue
        for j in range(degree[v]):
            b, c = ring[v, j], ring[v, (j + 1) % degree[v]]
            if v < b and v < c:
                ux, uy, uz = vertices[b] - vertices[v]
                wx, wy, wz = vertices[c] - vertices[v]
                x, y, z = uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx
                area += 0.5 * np.sqrt(x * x + y * y + z * z)
    return total / area
