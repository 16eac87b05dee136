"""Needles taken out of a mesh while it is laid out, and put back afterwards.

Unions of solids and CAD exports leave triangles a thousand times longer than wide. A search must
give each of them a share of the other surface, which it then tears along. So vertices collapse onto
neighbours where that makes the worst triangle around rounder and moves no surface farther than a
tolerance. All vertices that stay do not move, and those that went return into the kernels of their
rings on the domain once all else is done: the map is one of the given surface.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.goals.maps.closed_mesh import ClosedMesh
from touchwarp.goals.maps.collapse import triangle_shape
from touchwarp.goals.maps.layout import Layout
from touchwarp.goals.maps.levels import faces_of, return_vertices
from touchwarp.goals.maps.rings import (
    MOST_NEIGHBOURS,
    build_rings,
    can_collapse,
    collapse,
)

POOR_SHAPE = 3.0
"""Sides² over area, 1 for an equilateral triangle; about 10° and less are poor."""
MOST_AROUND = 24
PASSES = 6

Int = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Tidied:
    """A mesh without needles, and how they come back.

    Attributes:
        whole: the mesh as it was.
        mesh: the mesh without needles.
        kept: (k,) the vertices of `whole` that are those of `mesh`.
        removed: (r,) the others, in the order in which they went.
        rings: (r, …) the neighbours of each then, first the one that it went onto.
        degrees: (r,) how many neighbours that were.
    """

    whole: ClosedMesh
    mesh: ClosedMesh
    kept: Int
    removed: NDArray[np.int32]
    rings: NDArray[np.int32]
    degrees: NDArray[np.int32]

    def restore(self, layout: Layout) -> Layout:
        """The whole mesh laid out, from a layout of the mesh without needles."""
        if len(self.removed) == 0:
            return layout
        n = len(self.whole.vertices)
        faces = self.kept[self.mesh.faces].astype(np.int64)
        ring, shift, degree, _ = build_rings(faces, layout.corner_shift, n)
        alive = np.zeros(n, np.bool_)
        alive[self.kept] = True
        points = np.zeros((n, 3))
        points[self.kept] = layout.points
        # Each went inside one vertex's star: so do its neighbours' periods follow from that star's.
        shifts = np.zeros((*self.rings.shape, 2))
        vertices = (self.whole.vertices - self.whole.centre) / self.whole.diagonal
        scale = layout.domain_area / (self.whole.area / self.whole.diagonal**2)
        state = (vertices, points, ring, shift, degree, alive)
        record = (self.removed, self.degrees, self.rings, shifts)
        return_vertices(*state, *record, len(self.removed), 0, scale, layout.flat, True)
        faces, corner_shift = faces_of(ring, shift, degree, alive)
        return Layout(ClosedMesh(self.whole.vertices, faces), points, corner_shift)


def tidy(mesh: ClosedMesh, tolerance: float, short: float) -> Tidied:
    """The mesh with fewer needles and crumbs.

    Args:
        mesh: a mesh with a vertex of very many neighbours comes back as it is.
        tolerance: m, how far a collapse may move the surface.
        short: m, edges shorter than this go too, where the tolerance and shapes allow it.
    """
    n = len(mesh.vertices)
    shifts = np.zeros((len(mesh.faces), 3, 2))
    ring, shift, degree, built = build_rings(mesh.faces, shifts, n)
    removed, degrees = np.empty(n, np.int32), np.empty(n, np.int32)
    rings = np.empty((n, MOST_NEIGHBOURS), np.int32)
    alive = np.ones(n, np.bool_)
    count = 0
    if built:
        vertices = (mesh.vertices - mesh.centre) / mesh.diagonal
        scaled = (tolerance / mesh.diagonal, short / mesh.diagonal)
        for _ in range(PASSES):
            before = count
            count = _pass(
                vertices, ring, shift, degree, alive, *scaled, removed, degrees, rings, count
            )
            if count == before:
                break
    chosen = np.flatnonzero(alive)
    slim = mesh
    if count:
        number = np.full(n, -1)
        number[chosen] = np.arange(len(chosen))
        faces, _ = faces_of(ring, shift, degree, alive)
        slim = ClosedMesh(mesh.vertices[chosen], number[faces])
    return Tidied(mesh, slim, chosen, removed[:count], rings[:count].copy(), degrees[:count])


@njit(cache=True, error_model="numpy")
def _pass(vertices, ring, shift, degree, alive, tolerance, short, removed, degrees, rings, count):
    old_shift = np.zeros((MOST_NEIGHBOURS, 2))
    for v in range(len(vertices)):
        if not alive[v]:
            continue
        k = degree[v]
        worst, area, nearest = 0.0, 0.0, np.inf
        for j in range(k):
            nearest = min(nearest, ((vertices[ring[v, j]] - vertices[v]) ** 2).sum())
            shape, doubled = _shape(vertices, v, ring[v, j], ring[v, (j + 1) % k])
            worst = max(worst, shape)
            area += doubled
        if nearest < short * short:
            worst = max(worst, POOR_SHAPE)
        if worst < POOR_SHAPE:
            continue
        best, chosen = worst, -1
        for i in range(k):
            if not can_collapse(ring, degree, v, i, MOST_AROUND):
                continue
            after, area_after = 0.0, 0.0
            gap = np.inf
            for j in range(1, k - 1):
                a, b = ring[v, (i + j) % k], ring[v, (i + j + 1) % k]
                shape, doubled = _shape(vertices, ring[v, i], a, b)
                after = max(after, shape)
                area_after += doubled
                gap = min(
                    gap, _distance(vertices[v], vertices[ring[v, i]], vertices[a], vertices[b])
                )
            # A fold would show as area; a rim as wide as the tolerance may come and go.
            if after < best and gap <= tolerance and area_after < 1.02 * area:
                best, chosen = after, i
        if chosen < 0:
            continue
        for j in range(k):
            rings[count, j] = ring[v, (chosen + j) % k]
        removed[count], degrees[count] = v, k
        collapse(ring, shift, degree, rings[count], old_shift, k, v)
        alive[v] = False
        count += 1
    return count


@njit(cache=True, error_model="numpy")
def _shape(vertices, p, a, b):
    doubled, sides, _, _, _ = triangle_shape(vertices, p, a, b)
    return sides / (3.46 * doubled), doubled


@njit(cache=True, error_model="numpy")
def _distance(p, a, b, c):
    """From a point to a triangle."""
    ab, ac, ap = b - a, c - a, p - a
    nx = ab[1] * ac[2] - ab[2] * ac[1]
    ny = ab[2] * ac[0] - ab[0] * ac[2]
    nz = ab[0] * ac[1] - ab[1] * ac[0]
    square = nx * nx + ny * ny + nz * nz
    if square > 0.0:
        d00, d01, d11 = (ab * ab).sum(), (ab * ac).sum(), (ac * ac).sum()
        d20, d21 = (ap * ab).sum(), (ap * ac).sum()
        v = (d11 * d20 - d01 * d21) / square
        w = (d00 * d21 - d01 * d20) / square
        if v >= 0 and w >= 0 and v + w <= 1:
            return abs(ap[0] * nx + ap[1] * ny + ap[2] * nz) / np.sqrt(square)
    return min(_to_segment(p, a, b), _to_segment(p, b, c), _to_segment(p, c, a))


@njit(cache=True, error_model="numpy")
def _to_segment(p, a, b):
    along = b - a
    t = ((p - a) * along).sum() / max((along * along).sum(), 1e-300)
    gap = a + min(max(t, 0.0), 1.0) * along - p
    return np.sqrt((gap * gap).sum())
