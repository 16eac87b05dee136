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
from touchwarp.goals.maps.hyperbolic.deck import carry, product
from touchwarp.goals.maps.hyperbolic.layout import HyperbolicLayout, HyperbolicLocator
from touchwarp.goals.maps.meeting import CROSSING, MOST_CORNERS, PROP_CORNER, VIRTUAL_CORNER
from touchwarp.goals.maps.overlay import Overlay, numbered_edges

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
        cells = _cells(placed, virtual)
        if cells is not None:
            return _assembled(placed, virtual, *cells)
        moves = jitter * rng.uniform(-1, 1, (len(prop.points), 2))
        placed = prop.moved(prop.along(prop.frames(), moves))
        if not (placed.shares > 0).all():
            break
        jitter *= 10
    raise GoalError(
        "a map has triangles too thin to be told from turned ones; remesh the prop and the virtual "
        "object to even triangles."
    )


def _cells(
    prop: HyperbolicLayout, virtual: HyperbolicLayout
) -> tuple[Int, Int, Int, Int, Float] | None:
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
    count, kind, place, part, closed = _cut(prop.corners, virtual.corners, met, tables[0])
    return (met, count, kind, place, part) if closed else None


def _assembled(
    own: HyperbolicLayout,
    other: HyperbolicLayout,
    met: Int,
    count: Int,
    kind: Int,
    place: Int,
    part: Float,
) -> Overlay:
    prop, virtual = own.mesh, other.mesh
    there = np.arange(MOST_CORNERS) < count[:, None]
    row, _ = np.nonzero(there)
    f, t = met[row, 0], met[row, 1]
    kinds, places, parts = kind[there], place[there], part[there]
    keys = _keys(own, other, met[row], kinds, places)
    _, chosen, number = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    kinds, places, parts = kinds[chosen], places[chosen], parts[chosen]
    corners = prop.vertices[prop.faces[f[chosen]]], virtual.vertices[virtual.faces[t[chosen]]]
    points, images = np.empty((len(chosen), 3)), np.empty((len(chosen), 3))
    for what, at, away, (home, there_too) in (
        (PROP_CORNER, corners[0], corners[1], (points, images)),
        (VIRTUAL_CORNER, corners[1], corners[0], (images, points)),
    ):
        some = kinds == what
        home[some] = at[some, places[some, 0]]
        there_too[some] = np.einsum("nk,nkd->nd", parts[some], away[some])
    some = np.flatnonzero(kinds == CROSSING)
    for side, on in ((0, points), (1, images)):
        edge = places[some, side]
        a, b = corners[side][some, edge], corners[side][some, (edge + 1) % 3]
        on[some] = a + parts[some, side, None] * (b - a)
    outline = np.zeros(there.shape, np.int64)
    outline[there] = number.reshape(-1)
    fans = [np.flatnonzero(count > k + 1) for k in range(1, MOST_CORNERS - 1)]
    return Overlay(
        points,
        images,
        np.concatenate([outline[fan][:, [0, k + 1, k + 2]] for k, fan in enumerate(fans)]),
        np.concatenate([met[fan, 0] for fan in fans]),
        np.concatenate([met[fan, 1] for fan in fans]),
    )


def _keys(own: HyperbolicLayout, other: HyperbolicLayout, met: Int, kind: Int, place: Int) -> Int:
    """(k, 4): the same for the same corner of other cells.

    Two edges may cross more than once; the deck's element between their frames tells which.
    """
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
    return keys


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
            for k in range(3):
                meets, certain = _edge_meets(corners[f], here[(k + 1) % 3], here[(k + 2) % 3])
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
def _edge_meets(own, u, w):
    """Whether the edge u–w meets the triangle `own`; and whether all signs are sure."""
    u_inside, w_inside, crosses = True, True, False
    for e in range(3):
        a, b = own[e], own[(e + 1) % 3]
        at_u, at_w = _side(a, b, u), _side(a, b, w)
        if at_u == 0.0 or at_w == 0.0:
            return False, False
        u_inside, w_inside = u_inside and at_u > 0, w_inside and at_w > 0
        if (at_u > 0) != (at_w > 0):
            at_a, at_b = _side(u, w, a), _side(u, w, b)
            if at_a == 0.0 or at_b == 0.0:
                return False, False
            crosses = crosses or (at_a > 0) != (at_b > 0)
    return u_inside or w_inside or crosses, True


@njit(cache=True, error_model="numpy")
def _cut(corners, others, met, matrices):
    """The cell of each pair: its corners, counter-clockwise.

    Each of the six edges that takes part holds one side of the cell, from its first corner to its
    last; so the outline is followed without measuring anything.
    """
    q = len(met)
    count, kind = np.zeros(q, np.int64), np.zeros((q, MOST_CORNERS), np.int64)
    place, part = np.zeros((q, MOST_CORNERS, 2), np.int64), np.zeros((q, MOST_CORNERS, 3))
    there = np.empty((3, 3))
    of_prop, of_virtual = np.empty((3, 3)), np.empty((3, 3))
    first, last, after = np.empty(6, np.int64), np.empty(6, np.int64), np.empty(15, np.int64)
    kinds, places, parts = np.empty(15, np.int64), np.empty((15, 2), np.int64), np.empty((15, 3))
    closed = True
    for r in range(q):
        own = corners[met[r, 0]]
        _carried(matrices, met[r, 2], others[met[r, 1]], there)
        for e in range(3):
            for i in range(3):
                of_prop[e, i] = _side(own[e], own[(e + 1) % 3], there[i])
                of_virtual[e, i] = _side(there[e], there[(e + 1) % 3], own[i])
        first[:], last[:] = -1, -1
        n = 0
        for which, side in ((PROP_CORNER, of_virtual), (VIRTUAL_CORNER, of_prop)):
            for j in range(3):
                if side[0, j] > 0 and side[1, j] > 0 and side[2, j] > 0:
                    total = side[0, j] + side[1, j] + side[2, j]
                    kinds[n], places[n, 0], places[n, 1] = which, j, 0
                    for d in range(3):
                        parts[n, d] = side[(d + 1) % 3, j] / total
                    first[3 * which + j] = n
                    last[3 * which + (j + 2) % 3] = n
                    n += 1
        for e in range(3):
            for k in range(3):
                at_a, at_b = of_virtual[k, e], of_virtual[k, (e + 1) % 3]
                at_u, at_w = of_prop[e, k], of_prop[e, (k + 1) % 3]
                if (at_a > 0) == (at_b > 0) or (at_u > 0) == (at_w > 0):
                    continue
                kinds[n], places[n, 0], places[n, 1] = CROSSING, e, k
                parts[n, 0], parts[n, 1] = at_a / (at_a - at_b), at_u / (at_u - at_w)
                if at_a < 0:  # the prop's edge comes into the virtual triangle here
                    first[e], last[3 + k] = n, n
                else:
                    last[e], first[3 + k] = n, n
                n += 1
        after[:n] = -1
        for s in range(6):
            if (first[s] < 0) != (last[s] < 0):
                closed = False
            elif first[s] >= 0:
                after[first[s]] = last[s]
        here, done = 0, 0
        while done < n and done < MOST_CORNERS and here >= 0:
            kind[r, done], place[r, done], part[r, done] = kinds[here], places[here], parts[here]
            done += 1
            here = after[here]
        closed = closed and here == 0 and done == n and n >= 3
        count[r] = done
    return count, kind, place, part, closed
