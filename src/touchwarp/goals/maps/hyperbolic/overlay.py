"""The common overlay of two layouts on the hyperbolic surface: a map on triangles, without a flip.

The triangles of the prop and of the virtual object cut each other into cells. A cell lies in one
triangle of each, so the map sends it to a piece of a face of the virtual object. Lines of the plane
are straight in (x, y, z) up to scale, so the map of a cell is projective and keeps its outline's
order. Where neither layout turns a triangle over, nothing of the map does; its image is the virtual
surface itself, all of it, once.

What lies on which side of what is told by signs of det(a, b, c). Where one is too small to be told
in floating point from 0, as where a corner lies on an edge, the prop's points are moved a little
and all is done again: so all signs agree with one another, whatever side of a cut they are taken
on.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.maps.cell import (
    CROSSING,
    PROP_CORNER,
    VIRTUAL_CORNER,
    Cells,
    cut_cell,
    edge_meets,
    no_cells,
)
from touchwarp.goals.maps.hyperbolic.deck import carry, product
from touchwarp.goals.maps.hyperbolic.layout import HyperbolicLayout, HyperbolicLocator
from touchwarp.goals.maps.overlay import Overlay, assembled, numbered_edges

Float = NDArray[np.float64]
Int = NDArray[np.int64]

SURE = 1e-12
"""A determinant below this part of its terms is not told from 0."""
JITTER = 1e-7
"""In parts of the plane's unit of length; ten times more at each try."""
TRIES = 4


def overlay(prop: HyperbolicLayout, virtual: HyperbolicLayout) -> Overlay:
    """The overlay of two layouts with one deck group.

    Raises:
        GoalError: a triangle is too thin to be told from one that is turned over.
    """
    rng = np.random.default_rng(0)
    jitter = JITTER
    placed = prop
    for _ in range(TRIES):
        found = _cells(placed, virtual)
        if found is not None:
            met, cells = found
            keys = _keys(placed, virtual, met, cells)
            return assembled(prop.mesh, virtual.mesh, (met[:, 0], met[:, 1]), cells, keys)
        moves = jitter * rng.uniform(-1, 1, (len(prop.points), 2))
        placed = prop.moved(prop.along(prop.frames(), moves))
        if not (placed.shares > 0).all():
            break
        jitter *= 10
    raise GoalError(
        "a map has triangles too thin to be told from turned ones; remesh the prop and the virtual "
        "object to even triangles."
    )


def _cells(prop: HyperbolicLayout, virtual: HyperbolicLayout) -> tuple[Int, Cells] | None:
    """Pairs of triangles that meet (q, 3: prop, virtual, element), and their cells; or None."""
    locator = virtual.locator()
    assert isinstance(locator, HyperbolicLocator)
    firsts = np.ascontiguousarray(prop.corners[:, 0])
    start = locator.find(firsts)
    tables = virtual.deck.tables
    met, sure = _meet(
        prop.corners,
        start,
        locator.frame,
        virtual.corners,
        virtual.mesh.neighbours,
        virtual.jump_elements,
        tables,
    )
    if not sure:
        return None
    cells = no_cells(len(met))
    closed = _cut(prop.corners, virtual.corners, met, tables[0], *cells[:4])
    return (met, cells) if closed else None


def _keys(own: HyperbolicLayout, other: HyperbolicLayout, met: Int, cells: Cells) -> Int:
    """(k,): one number for each corner of cells, the same for the same corner of other cells.

    Two edges may cross more than once; the deck's element between their frames tells which.
    """
    there = cells.there
    row, _ = np.nonzero(there)
    met, kind, place = met[row], cells.kind[there], cells.place[there]
    keys = np.zeros((len(kind), 4), np.int64)
    keys[:, 0] = kind
    for what, mesh, column in ((PROP_CORNER, own.mesh, 0), (VIRTUAL_CORNER, other.mesh, 1)):
        some = kind == what
        keys[some, 1] = mesh.faces[met[some, column], place[some, 0]]
    some = np.flatnonzero(kind == CROSSING)
    f, t, element = met[some].T
    one, low = numbered_edges(own.mesh.faces)
    two, under = numbered_edges(other.mesh.faces)
    e, k = place[some].T
    keys[some, 1], keys[some, 2] = one[f, e], two[t, k]
    frames = own.elements[f, low[f, e]], other.elements[t, under[t, k]]
    keys[some, 3] = _between(*frames, element, own.deck.tables)
    return np.asarray(np.unique(keys, axis=0, return_inverse=True)[1]).reshape(-1)


@njit(cache=True, error_model="numpy")
def _between(own, other, element, tables):
    between = np.empty_like(own)
    for i in range(len(own)):
        between[i] = product(tables, -own[i], product(tables, element[i], other[i]))
    return between


@njit(cache=True, error_model="numpy")
def _side(a, b, c):
    """det(a, b, c), or 0 where rounding may have turned its sign."""
    total, size = 0.0, 0.0
    for d in range(3):
        e, g = (d + 1) % 3, (d + 2) % 3
        one, other = b[e] * c[g], b[g] * c[e]
        total += a[d] * (one - other)
        size += abs(a[d]) * (abs(one) + abs(other))
    return total if abs(total) > SURE * size else 0.0


@njit(cache=True, error_model="numpy")
def _carried(matrices, element, corners, out):
    for k in range(3):
        x, y, z = carry(matrices, element, corners[k, 0], corners[k, 1], corners[k, 2])
        out[k, 0], out[k, 1], out[k, 2] = x, y, z


@njit(cache=True, error_model="numpy")
def _meet(corners, start, frame, others, neighbours, jumps, tables):
    """All pairs that meet (q, 3): prop triangle, virtual triangle, what carries that beside it."""
    capacity = 8 * len(corners) + 64
    found = np.empty((capacity, 3), np.int64)
    count, sure = 0, True
    here = np.empty((3, 3))
    of_prop, of_virtual = np.empty((3, 3)), np.empty((3, 3))
    for f in range(len(corners)):
        first = count
        for head in range(1 << 30):
            if head == 0:
                t, element = start[f], -frame[f]
            elif first + head < count:
                t, element = found[first + head, 1], found[first + head, 2]
            else:
                break
            if head == 0:
                if count == capacity:
                    found, capacity = _longer(found)
                found[count, 0], found[count, 1], found[count, 2] = f, t, element
                count += 1
            _carried(tables[0], element, others[t], here)
            _tell_sides(corners[f], here, of_prop, of_virtual)
            for k in range(3):
                meets, certain = edge_meets(of_prop, of_virtual, (k + 1) % 3)
                sure = sure and certain
                if not meets:
                    continue
                g, beyond = neighbours[t, k], product(tables, element, -jumps[t, k])
                known = False
                for j in range(first, count):
                    known = known or (found[j, 1] == g and found[j, 2] == beyond)
                if known:
                    continue
                if count == capacity:
                    found, capacity = _longer(found)
                found[count, 0], found[count, 1], found[count, 2] = f, g, beyond
                count += 1
        if not sure:
            break
    return found[:count], sure


@njit(cache=True, error_model="numpy")
def _longer(found):
    longer = np.empty((2 * len(found), 3), np.int64)
    longer[: len(found)] = found
    return longer, len(longer)


@njit(cache=True, error_model="numpy")
def _tell_sides(own, there, of_prop, of_virtual):
    for e in range(3):
        for i in range(3):
            of_prop[e, i] = _side(own[e], own[(e + 1) % 3], there[i])
            of_virtual[e, i] = _side(there[e], there[(e + 1) % 3], own[i])


@njit(cache=True, error_model="numpy")
def _cut(corners, others, met, matrices, count, kind, place, part):
    closed = True
    there = np.empty((3, 3))
    of_prop, of_virtual = np.empty((3, 3)), np.empty((3, 3))
    for r in range(len(met)):
        _carried(matrices, met[r, 2], others[met[r, 1]], there)
        _tell_sides(corners[met[r, 0]], there, of_prop, of_virtual)
        count[r], closes = cut_cell(of_prop, of_virtual, kind[r], place[r], part[r])
        closed = closed and closes
    return closed
