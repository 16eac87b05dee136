"""Needles taken out of a mesh while it is laid out, and put back afterwards.

Unions of solids and CAD exports leave triangles a thousand times longer than wide. A search must
give each of them a share of the other surface, which it then tears along. So vertices collapse onto
neighbours where that makes the worst triangle around rounder and moves no surface farther than a
tolerance. All vertices that stay do not move, and those that went return once all else is done: the
map is one of the given surface. Each returns to where the mesh without it has its place on the
domain, or, where that would turn a triangle over, as near to there as it may: so the map of the
whole mesh is as smooth as that of the mesh without needles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.goals.maps.closed_mesh import ClosedMesh
from touchwarp.goals.maps.collapse import triangle_shape
from touchwarp.goals.maps.layout import Layout
from touchwarp.goals.maps.levels import faces_of
from touchwarp.goals.maps.rings import (
    MOST_NEIGHBOURS,
    build_rings,
    can_collapse,
    collapse,
    place_in_ring,
    restore,
)
from touchwarp.goals.maps.star import kernel_point, onto_domain

POOR_SHAPE = 3.0
"""Sides² over area, 1 for an equilateral triangle; about 10° and less are poor."""
MOST_AROUND = 24
PASSES = 6
TOWARDS_KERNEL = (0.0, 1e-3, 0.01, 0.03, 0.1, 0.3, 0.6, 1.0)
"""Parts of the way from a vertex's own place to the kernel of its ring, tried in turn."""
LEAST_SHARE = 0.1
"""Of what a triangle's area on the domain should be, in that of its star, when a vertex returns."""

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
        vertices = (self.whole.vertices - self.whole.centre) / self.whole.diagonal
        state = (vertices, points, ring, shift, degree)
        _return(*state, self.removed, self.degrees, self.rings, layout.flat)
        alive[self.removed] = True
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


@njit(cache=True, error_model="numpy", nogil=True)
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


@njit(cache=True, error_model="numpy", nogil=True)
def _return(vertices, points, ring, shift, degree, removed, degrees, rings, flat):
    """Let all removed vertices return, the last one first."""
    corners, shifts = np.empty((MOST_NEIGHBOURS, 3)), np.zeros((MOST_NEIGHBOURS, 2))
    curvature = 0.0 if flat else 1.0
    for r in range(len(removed) - 1, -1, -1):
        v, k = removed[r], degrees[r]
        # It went inside one vertex's star: so do its neighbours' periods follow from that star's.
        onto = rings[r, 0]
        for j in range(k):
            w = rings[r, j]
            if j > 0:
                shifts[j] = shift[onto, place_in_ring(ring, degree, onto, w)]
            corners[j, 0] = points[w, 0] + shifts[j, 0]
            corners[j, 1] = points[w, 1] + shifts[j, 1]
            corners[j, 2] = points[w, 2]
        own = _own_place(vertices, v, rings[r], k, corners)
        inner, _ = kernel_point(corners, k, flat)
        for part in TOWARDS_KERNEL:
            for d in range(3):
                points[v, d] = (1.0 - part) * own[d] + part * inner[d]
            onto_domain(points[v], curvature)
            if _even_enough(vertices, v, rings[r], k, corners, points[v]):
                break
        restore(ring, shift, degree, rings[r], shifts, k, v)


@njit(cache=True, error_model="numpy")
def _own_place(vertices, v, around, k, corners):
    """Where the faces that a vertex went into have its place: a point in them on the domain."""
    nearest, place = np.inf, corners[0].copy()
    for j in range(1, k - 1):
        a, b, c = vertices[around[0]], vertices[around[j]], vertices[around[j + 1]]
        parts = _nearest_parts(vertices[v], a, b, c)
        gap = parts[0] * a + parts[1] * b + parts[2] * c - vertices[v]
        far = (gap * gap).sum()
        if far < nearest:
            nearest = far
            place = parts[0] * corners[0] + parts[1] * corners[j] + parts[2] * corners[j + 1]
    return place


@njit(cache=True, error_model="numpy")
def _even_enough(vertices, v, around, k, corners, place):
    """Whether no triangle from `place` to its ring is turned over or far smaller than it should."""
    share, seen = np.empty(k), np.empty(k)
    for j in range(k):
        i = (j + 1) % k
        doubled, sides, _, _, _ = triangle_shape(vertices, v, around[j], around[i])
        # A needle counts as a triangle of some width: without area it would have no share.
        share[j] = max(doubled, 1e-4 * sides)
        a, b = corners[j], corners[i]
        seen[j] = (
            place[0] * (a[1] * b[2] - a[2] * b[1])
            + place[1] * (a[2] * b[0] - a[0] * b[2])
            + place[2] * (a[0] * b[1] - a[1] * b[0])
        )
    return (seen * share.sum() >= LEAST_SHARE * share * seen.sum()).all() and seen.min() > 0.0


@njit(cache=True, error_model="numpy")
def _nearest_parts(p, a, b, c):
    """Barycentric coordinates (3,) of the point of a triangle that is nearest to p."""
    best, parts = np.inf, np.zeros(3)
    ab, ac, ap = b - a, c - a, p - a
    d00, d01, d11 = (ab * ab).sum(), (ab * ac).sum(), (ac * ac).sum()
    d20, d21 = (ap * ab).sum(), (ap * ac).sum()
    square = d00 * d11 - d01 * d01
    if square > 0.0:
        s, t = (d11 * d20 - d01 * d21) / square, (d00 * d21 - d01 * d20) / square
        if s >= 0.0 and t >= 0.0 and s + t <= 1.0:
            parts[0], parts[1], parts[2] = 1.0 - s - t, s, t
            return parts
    corners = (a, b, c)
    for i in range(3):
        j = (i + 1) % 3
        start, along = corners[i], corners[j] - corners[i]
        t = ((p - start) * along).sum() / max((along * along).sum(), 1e-300)
        t = min(max(t, 0.0), 1.0)
        far = ((start + t * along - p) ** 2).sum()
        if far < best:
            best = far
            parts[:] = 0.0
            parts[i], parts[j] = 1.0 - t, t
    return parts


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
    dot, square, squared_gap = 0.0, 0.0, 0.0
    for d in range(3):
        dot += (p[d] - a[d]) * (b[d] - a[d])
        square += (b[d] - a[d]) ** 2
    t = min(max(dot / max(square, 1e-300), 0.0), 1.0)
    for d in range(3):
        squared_gap += (a[d] + t * (b[d] - a[d]) - p[d]) ** 2
    return np.sqrt(squared_gap)
