"""Which triangles of two layouts meet on their domain, and the convex cells in which they do.

All answers rest on the signs of exact determinants, so they agree with one another.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.goals.maps.cell import Cells, cut_cell, edge_meets, no_cells
from touchwarp.goals.maps.lattice import BITS, LatticeLayout, determinant

Int = NDArray[np.int64]


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
    cells = no_cells(len(meetings.prop))
    closed = _cut(prop.corners, virtual.corners, *meetings[:3], *cells[:4])
    return cells._replace(closed=closed)


@njit(cache=True, error_model="numpy")
def _meet(corners, start, others, neighbours, jumps, flat):
    capacity = 8 * len(corners) + 64
    found = np.empty((capacity, 4), np.int64)
    count = 0
    exact = True
    here = np.empty((3, 3), np.int64)
    of_prop, of_virtual = np.empty((3, 3)), np.empty((3, 3))
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
            _tell_sides(own, here, of_prop, of_virtual)
            for k in range(3):
                meets, sound = edge_meets(of_prop, of_virtual, (k + 1) % 3)
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
def _tell_sides(own, there, of_prop, of_virtual):
    for e in range(3):
        for i in range(3):
            of_prop[e, i] = determinant(own[e], own[(e + 1) % 3], there[i])
            of_virtual[e, i] = determinant(there[e], there[(e + 1) % 3], own[i])


@njit(cache=True, error_model="numpy")
def _cut(corners, others, prop, virtual, offset, count, kind, place, part):
    closed = True
    there = np.empty((3, 3), np.int64)
    of_prop, of_virtual = np.empty((3, 3)), np.empty((3, 3))
    for r in range(len(prop)):
        _shifted(others[virtual[r]], offset[r, 0], offset[r, 1], there)
        _tell_sides(corners[prop[r]], there, of_prop, of_virtual)
        count[r], closes = cut_cell(of_prop, of_virtual, kind[r], place[r], part[r])
        closed = closed and closes
    return closed
