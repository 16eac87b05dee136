"""Which triangles of two layouts meet on their domain, and the convex cells in which they do.

All answers rest on the signs of exact determinants, so they agree with one another. A cell's
corners are corners of the one triangle inside the other, and crossings of their edges; each of the
six edges that takes part holds one side of the cell, from its first corner to its last, and so the
cell's outline is found without measuring anything.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.goals.maps.lattice import BITS, LatticeLayout, determinant

Float = NDArray[np.float64]
Int = NDArray[np.int64]

MOST_CORNERS = 6
PROP_CORNER, VIRTUAL_CORNER, CROSSING = 0, 1, 2


class Meetings(NamedTuple):
    """Pairs of triangles that meet.

    Attributes:
        prop, virtual: (q,) the triangles.
        offset: (q, 2) periods to add to the virtual triangle's corners.
        exact: no corner lies on an edge, no three edges cross in a point.
    """

    prop: Int
    virtual: Int
    offset: Int
    exact: bool


class Cells(NamedTuple):
    """Where pairs of triangles meet: convex polygons, counter-clockwise seen from outside.

    Attributes:
        corners: (q,) how many each cell has, 3 to 6.
        kind: (q, 6) PROP_CORNER, VIRTUAL_CORNER or CROSSING.
        place: (q, 6, 2) which corner of its own triangle it is, or which edges of the prop's and
            of the virtual triangle cross, edge k from corner k to the next.
        part: (q, 6, 3) barycentric coordinates of a corner in the other triangle; for a crossing,
            how far along the two edges it is.
        closed: every outline was.
    """

    corners: Int
    kind: Int
    place: Int
    part: Float
    closed: bool


def find_meetings(prop: LatticeLayout, virtual: LatticeLayout, start: Int) -> Meetings:
    """All pairs of triangles that meet; `start` (m,) is a virtual triangle near each corner 0."""
    found, exact = _meet(
        prop.corners,
        start,
        virtual.corners,
        virtual.layout.mesh.neighbours,
        virtual.jumps,
        prop.layout.flat,
    )
    return Meetings(found[:, 0], found[:, 1], found[:, 2:], exact)


def cut_cells(prop: LatticeLayout, virtual: LatticeLayout, meetings: Meetings) -> Cells:
    """The cells of pairs of triangles that meet."""
    return Cells(*_cut(prop.corners, virtual.corners, *meetings[:3]))


@njit(cache=True, error_model="numpy")
def _meet(corners, start, others, neighbours, jumps, flat):
    capacity = 8 * len(corners) + 64
    found = np.empty((capacity, 4), np.int64)
    count = 0
    exact = True
    here = np.empty((3, 3), np.int64)
    queue = np.empty((256, 3), np.int64)
    for f in range(len(corners)):
        own = corners[f]
        t, x, y, sound = _walk(own[0], start[f], others, neighbours, jumps, flat)
        exact = exact and sound
        queue[0, 0], queue[0, 1], queue[0, 2] = t, x, y
        size, head = 1, 0
        while head < size:
            t, x, y = queue[head]
            head += 1
            if count == capacity:
                longer = np.empty((2 * capacity, 4), np.int64)
                longer[:capacity] = found
                found, capacity = longer, 2 * capacity
            found[count, 0], found[count, 1], found[count, 2], found[count, 3] = f, t, x, y
            count += 1
            _shifted(others[t], x, y, here)
            for k in range(3):
                meets, sound = _edge_meets(own, here[(k + 1) % 3], here[(k + 2) % 3])
                exact = exact and sound
                if not meets:
                    continue
                g = neighbours[t, k]
                gx, gy = x - jumps[t, k, 0], y - jumps[t, k, 1]
                known = False
                for j in range(size):
                    if queue[j, 0] == g and queue[j, 1] == gx and queue[j, 2] == gy:
                        known = True
                        break
                if known:
                    continue
                if size == len(queue):
                    longer = np.empty((2 * size, 3), np.int64)
                    longer[:size] = queue
                    queue = longer
                queue[size, 0], queue[size, 1], queue[size, 2] = g, gx, gy
                size += 1
    return found[:count], exact


@njit(cache=True, error_model="numpy")
def _walk(point, start, others, neighbours, jumps, flat):
    """From a triangle to the one that holds the point: it, its offset, and whether that is sure."""
    t, x, y = start, np.int64(0), np.int64(0)
    here = np.empty((3, 3), np.int64)
    if flat:  # beside the triangle that the walk starts from
        half = np.int64(1) << (BITS - 1)
        x = (point[0] - others[t, 0, 0] + half) >> BITS
        y = (point[1] - others[t, 0, 1] + half) >> BITS
    for turn in range(4 * len(others)):
        _shifted(others[t], x, y, here)
        across = -1
        for k in range(3):
            e = (k + turn) % 3  # across edges in turn, lest the walk go in circles
            side = determinant(here[(e + 1) % 3], here[(e + 2) % 3], point)
            if side == 0.0:
                return t, x, y, False
            if side < 0.0:
                across = e
                break
        if across < 0:
            return t, x, y, True
        x, y = x - jumps[t, across, 0], y - jumps[t, across, 1]
        t = neighbours[t, across]
    return t, x, y, False


@njit(cache=True, error_model="numpy")
def _shifted(corners, x, y, out):
    for k in range(3):
        out[k, 0] = corners[k, 0] + (x << BITS)
        out[k, 1] = corners[k, 1] + (y << BITS)
        out[k, 2] = corners[k, 2]


@njit(cache=True, error_model="numpy")
def _edge_meets(own, u, w):
    """Whether the edge u–w meets the triangle `own`; and whether no sign was zero."""
    u_inside, w_inside, crosses = True, True, False
    for e in range(3):
        a, b = own[e], own[(e + 1) % 3]
        at_u, at_w = determinant(a, b, u), determinant(a, b, w)
        if at_u == 0.0 or at_w == 0.0:
            return True, False
        u_inside = u_inside and at_u > 0
        w_inside = w_inside and at_w > 0
        if (at_u > 0) != (at_w > 0):
            at_a, at_b = determinant(u, w, a), determinant(u, w, b)
            if at_a == 0.0 or at_b == 0.0:
                return True, False
            # the third comparison tells a crossing from one on the far side of the sphere
            crosses = crosses or ((at_a > 0) != (at_b > 0) and (at_a > 0) != (at_u > 0))
    return u_inside or w_inside or crosses, True


@njit(cache=True, error_model="numpy")
def _cut(corners, others, prop, virtual, offset):
    q = len(prop)
    count = np.zeros(q, np.int64)
    kind = np.zeros((q, MOST_CORNERS), np.int64)
    place = np.zeros((q, MOST_CORNERS, 2), np.int64)
    part = np.zeros((q, MOST_CORNERS, 3))
    closed = True
    there = np.empty((3, 3), np.int64)
    # side of the prop's edge e at the virtual corner i, and of virtual edge k at prop corner j
    of_prop, of_virtual = np.empty((3, 3)), np.empty((3, 3))
    first, last = np.empty(6, np.int64), np.empty(6, np.int64)
    kinds, places, parts = np.empty(15, np.int64), np.empty((15, 2), np.int64), np.empty((15, 3))
    after = np.empty(15, np.int64)
    for r in range(q):
        own = corners[prop[r]]
        _shifted(others[virtual[r]], offset[r, 0], offset[r, 1], there)
        for e in range(3):
            for i in range(3):
                of_prop[e, i] = determinant(own[e], own[(e + 1) % 3], there[i])
                of_virtual[e, i] = determinant(there[e], there[(e + 1) % 3], own[i])
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
                if (at_a > 0) == (at_b > 0) or (at_u > 0) == (at_w > 0) or (at_a > 0) == (at_u > 0):
                    continue
                kinds[n], places[n, 0], places[n, 1] = CROSSING, e, k
                parts[n, 0], parts[n, 1] = at_a / (at_a - at_b), at_u / (at_u - at_w)
                if at_a < 0:  # the prop's edge comes into the virtual triangle here
                    first[e], last[3 + k] = n, n
                else:
                    last[e], first[3 + k] = n, n
                n += 1
        after[:n] = -1
        for side_number in range(6):
            if (first[side_number] < 0) != (last[side_number] < 0):
                closed = False
            elif first[side_number] >= 0:
                after[first[side_number]] = last[side_number]
        here, done = 0, 0
        while done < n and done < MOST_CORNERS and here >= 0:
            kind[r, done] = kinds[here]
            place[r, done] = places[here]
            part[r, done] = parts[here]
            done += 1
            here = after[here]
        closed = closed and here == 0 and done == n and n >= 3
        count[r] = done
    return count, kind, place, part, closed
