"""A found map on a domain where both surfaces keep their shapes, so that it is smooth within faces.

Layouts that keep areas shear: about a mug's handle by a hundred to one. A map is linear on the
domain between the vertices that a search has placed, and what two such shears leave of one another
there is rough: it stretches a hundredfold across pieces as wide as a hair. So before the layouts
are laid over one another the virtual surface is laid out once more, now for shapes, and each vertex
of the prop goes along with the point of the virtual surface that it shows.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.maps.closed_mesh import ClosedMesh
from touchwarp.goals.maps.embed import embed
from touchwarp.goals.maps.layout import Layout
from touchwarp.goals.maps.levels import faces_of
from touchwarp.goals.maps.refine import Weights
from touchwarp.goals.maps.rings import MOST_NEIGHBOURS, build_rings, can_collapse, collapse
from touchwarp.goals.maps.search import SETTLING_ROUNDS, Pair
from touchwarp.goals.maps.tidy import Tidied

SHAPE = 10.0
"""The weight of shape beside area in the layout; 0.1 where areas count."""
MOST_AROUND = 24
PASSES = 20
RINGS_TO_SETTLE = 3
BARRIER = 0.02
"""The weight of areas while vertices settle."""


def unsheared(pair: Pair, found: Layout, weights: Weights) -> tuple[Layout, Layout]:
    """The prop's and the virtual surface's layouts on a domain where shapes are kept.

    The prop's vertices show what they did. But where a triangle would turn over, vertices are taken
    out and put back into the triangles that they leave, and they and what is near them settle anew.
    Where that does not help, or the virtual surface cannot be laid out so, both layouts are
    returned as they are.

    Args:
        pair: the surfaces.
        found: the prop's mesh laid over `pair.virtual`; no triangle of either turned over.
        weights: of the energy that found it.
    """
    before = pair.virtual
    try:
        below = before.moved(embed(before.mesh, before.corner_shift, SHAPE))
    except GoalError:
        return found, before
    carried = found.moved(_carried(found, before, below))
    carried, moved = _untangled(carried)
    if (below.shares <= 0).any() or (carried.shares <= 0).any():
        return found, before
    # Shares of this domain are none of the virtual surface's area: they only keep triangles open.
    problem = replace(pair, virtual=below).problem(carried, np.arange(len(moved)))
    chosen = np.flatnonzero(_grown(found.mesh.faces, moved, RINGS_TO_SETTLE))
    return problem.settle(carried, replace(weights, area=BARRIER), SETTLING_ROUNDS, chosen), below


def _carried(prop: Layout, before: Layout, after: Layout) -> NDArray[np.float64]:
    """Where the prop's points are when the virtual surface below them is laid out otherwise."""
    locator = before.locator()
    face = locator.find(prop.points)
    here, there = (
        np.einsum("nk,nkd->nd", locator.weights, layout.corners[face]) for layout in (before, after)
    )
    if prop.flat:
        there[:, :2] += np.rint(prop.points - here)[:, :2]
        return np.asarray(there)
    return np.asarray(there / np.linalg.norm(there, axis=1, keepdims=True))


def _grown(faces: NDArray[np.int64], vertices: NDArray[np.bool_], rings: int) -> NDArray[np.bool_]:
    """(n,): the vertices (n,), and so many rings of neighbours around them."""
    grown = vertices.copy()
    for _ in range(rings):
        grown[faces[grown[faces].any(axis=1)]] = True
    return grown


def _untangled(layout: Layout) -> tuple[Layout, NDArray[np.bool_]]:
    """The layout with no triangle turned over, if that can be had, and which vertices moved."""
    mesh, points = layout.mesh, layout.points
    n = len(points)
    moved = np.zeros(n, np.bool_)
    if (layout.shares > 0).all():
        return layout, moved
    ring, shift, degree, _ = build_rings(mesh.faces, layout.corner_shift, n)
    removed, degrees = np.empty(n, np.int32), np.empty(n, np.int32)
    rings = np.empty((n, MOST_NEIGHBOURS), np.int32)
    alive = np.ones(n, np.bool_)
    count = _take_out(points, ring, shift, degree, alive, removed, degrees, rings)
    faces, shifts = faces_of(ring, shift, degree, alive)
    kept = np.flatnonzero(alive)
    number = np.full(n, -1)
    number[kept] = np.arange(len(kept))
    slim = ClosedMesh(mesh.vertices[kept], number[faces])
    taken = Tidied(mesh, slim, kept, removed[:count], rings[:count].copy(), degrees[:count])
    again = taken.restore(Layout(slim, points[kept], shifts)).points
    if layout.flat:  # on the side of the cuts where they were
        again[:, :2] += np.rint(points - again)[:, :2]
    moved[removed[:count]] = True
    return layout.moved(again), moved


@njit(cache=True, error_model="numpy")
def _take_out(points, ring, shift, degree, alive, removed, degrees, rings):
    """Collapse vertices with turned triangles onto neighbours where that leaves fewer of them.

    Every other pass does so where it leaves as many: with larger triangles around, the next one
    finds a way.

    Returns:
        How many vertices were taken out; they stand in `removed`, `degrees` and `rings`.
    """
    count = 0
    corners = np.empty((MOST_NEIGHBOURS + 1, 3))
    shifts = np.empty((MOST_NEIGHBOURS, 2))
    for turn in range(PASSES):
        tangled = False
        for v in range(len(points)):
            if not alive[v]:
                continue
            k = degree[v]
            for j in range(k):
                corners[j] = points[ring[v, j]]
                corners[j, :2] += shift[v, j]
            corners[k] = points[v]
            fewest, chosen = _turned(corners, k, k), -1
            if fewest == 0:
                continue
            tangled = True
            fewest += turn % 2
            for i in range(k):
                if can_collapse(ring, degree, v, i, MOST_AROUND):
                    left = _turned(corners, k, i)
                    if left < fewest:
                        fewest, chosen = left, i
            if chosen < 0:
                continue
            for j in range(k):
                rings[count, j] = ring[v, (chosen + j) % k]
                shifts[j] = shift[v, (chosen + j) % k]
            removed[count], degrees[count] = v, k
            collapse(ring, shift, degree, rings[count], shifts, k, v)
            alive[v] = False
            count += 1
        if not tangled:
            break
    return count


@njit(cache=True, error_model="numpy")
def _turned(corners, k, apex):
    """How many triangles from corner `apex` to the edges of the ring corners[:k] are turned."""
    turned = 0
    p = corners[apex]
    for j in range(k):
        i = (j + 1) % k
        if (apex - i) * (apex - j) == 0:
            continue
        a, b = corners[j], corners[i]
        x, y, z = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
        turned += x * p[0] + y * p[1] + z * p[2] <= 0.0
    return turned
