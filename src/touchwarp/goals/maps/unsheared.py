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
from touchwarp.goals.maps.embed import embed
from touchwarp.goals.maps.layout import Layout
from touchwarp.goals.maps.refine import Weights
from touchwarp.goals.maps.rings import MOST_NEIGHBOURS, build_rings
from touchwarp.goals.maps.search import SETTLING_ROUNDS, Pair
from touchwarp.goals.maps.star import kernel_point

SHAPE = 10.0
"""The weight of shape beside area in the layout; 0.1 where areas count."""
ROUNDS, ALONE_ROUNDS = 30, 3
"""In which triangles are turned back; in the first of them by their own corners alone."""
RINGS_TO_SETTLE = 1


def unsheared(pair: Pair, found: Layout, weights: Weights) -> tuple[Layout, Layout]:
    """The prop's and the virtual surface's layouts on a domain where shapes are kept.

    The prop's vertices show what they did. But where a triangle would turn over, its corners move
    until it does not, and they and what is near them settle anew. Where that does not help, or the
    virtual surface cannot be laid out so, both layouts are returned as they are.

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
    carried, moved = untangled(carried)
    if (below.shares <= 0).any() or (carried.shares <= 0).any():
        return found, before
    if not moved.any():
        return carried, below
    chosen = _grown(found.mesh.faces, moved, RINGS_TO_SETTLE)
    density = _density(found, before, below)
    there = density[chosen[found.mesh.faces].any(axis=1)].mean()
    problem = replace(pair, virtual=below).problem(carried, np.arange(len(moved)), density)
    alike = replace(weights, area=weights.area / there)  # areas there count for what they are
    return problem.settle(carried, alike, SETTLING_ROUNDS, np.flatnonzero(chosen)), below


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


def _density(prop: Layout, before: Layout, after: Layout) -> NDArray[np.float64]:
    """(m,): how much more of the second domain the virtual surface has below each prop triangle."""
    middles = prop.corners.mean(axis=1)
    if not prop.flat:
        middles /= np.linalg.norm(middles, axis=1, keepdims=True)
    return np.asarray((after.shares / before.shares)[before.locator().find(middles)])


def _grown(faces: NDArray[np.int64], vertices: NDArray[np.bool_], rings: int) -> NDArray[np.bool_]:
    """(n,): the vertices (n,), and so many rings of neighbours around them."""
    grown = vertices.copy()
    for _ in range(rings):
        grown[faces[grown[faces].any(axis=1)]] = True
    return grown


def untangled(layout: Layout) -> tuple[Layout, NDArray[np.bool_]]:
    """The layout with no triangle turned over, if that can be had, and which vertices moved.

    Where a domain bends over the other, the straight triangle between three carried corners may be
    turned though the curved one that it stands for is not. Its corners, and in later rounds their
    neighbours too, go to where their rings are seen best (Freitag and Plassmann 2000).
    """
    mesh, points = layout.mesh, layout.points.copy()
    moved = np.zeros(len(points), np.bool_)
    ring, shift, degree, _ = build_rings(mesh.faces, layout.corner_shift, len(points))
    for turn in range(ROUNDS):
        turned = layout.moved(points).shares <= 0
        if not turned.any():
            break
        chosen = np.zeros(len(points), np.bool_)
        chosen[mesh.faces[turned]] = True
        chosen = _grown(mesh.faces, chosen, int(turn >= ALONE_ROUNDS))
        _to_kernels(points, ring, shift, degree, np.flatnonzero(chosen), layout.flat)
        moved |= chosen
    return layout.moved(points), moved


@njit(cache=True, error_model="numpy")
def _to_kernels(points, ring, shift, degree, chosen, flat):
    """Move each vertex to where the least of its triangles is as high as it can be."""
    corners = np.empty((MOST_NEIGHBOURS, 3))
    for v in chosen:
        for j in range(degree[v]):
            corners[j] = points[ring[v, j]]
            corners[j, :2] += shift[v, j]
        points[v], _ = kernel_point(corners, degree[v], flat)
