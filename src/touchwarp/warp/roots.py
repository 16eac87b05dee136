"""The nearest real position that a table shows at a point: branch and bound over its bricks.

Over a brick f = x + u stays in the hull of its values at the nodes. Bricks whose hull leaves the
displayed position out hold no root, nor need bricks farther away than a root already found be
opened. What remains are cells, see `touchwarp.warp.cell_roots`. Nothing is left to chance.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.warp.bricks import CELLS, NODES
from touchwarp.warp.cell_roots import DEEPEST, SLACK, distance2, search_cell


@njit(cache=True, nogil=True)
def hulls(order, level, position, child, slot, values, width, open_hull, hull):
    """Bounds of f over each brick, and over each octant that it decides itself.

    Args:
        order: (b,) the bricks, coarse before fine.
        values: (v · 729 · 3,) float32.
        open_hull: (b, 8, 6) and hull: (b, 6), written: least, then greatest f, table frame.
    """
    half = CELLS // 2
    for n in range(len(order) - 1, -1, -1):
        brick = order[n]
        for d in range(3):
            hull[brick, d], hull[brick, 3 + d] = np.inf, -np.inf
        scale = 1.0 / (CELLS * 2.0 ** level[brick])
        for octant in range(8):
            below = child[brick, octant]
            for d in range(3):
                low, high = np.inf, -np.inf
                if below >= 0:
                    low, high = hull[below, d], hull[below, 3 + d]
                else:
                    i0, j0, k0 = octant >> 2, octant >> 1 & 1, octant & 1
                    for i in range(half * i0, half * i0 + half + 1):
                        for j in range(half * j0, half * j0 + half + 1):
                            for k in range(half * k0, half * k0 + half + 1):
                                here = i if d == 0 else (j if d == 1 else k)
                                x = (position[brick, d] * CELLS + here) * scale * width[d]
                                at = ((np.int64(slot[brick]) * NODES + i) * NODES + j) * NODES + k
                                f = x + np.float64(values[at * 3 + d])
                                low, high = min(low, f), max(high, f)
                open_hull[brick, octant, d] = low - SLACK
                open_hull[brick, octant, 3 + d] = high + SLACK
                hull[brick, d] = min(hull[brick, d], low - SLACK)
                hull[brick, 3 + d] = max(hull[brick, 3 + d], high + SLACK)


@njit(cache=True, nogil=True)
def nearest_roots(
    y, root, child, slot, level, position, values, width, open_hull, hull, reach, out
):
    """For each y the nearest x with f(x) = y; NaN rows where there is none.

    Args:
        y: (n, 3) m, table frame, inside the root bricks. reach: m, no |u| is greater.
        values: (v · 729 · 3,) float32. out: (n, 3), written, table frame.
    """
    tree = (child, slot, level, position, values, width, open_hull, hull)
    queue = (np.empty((512, 2), np.int64), np.empty(512), np.empty(8), np.empty(8, np.int64))
    cell = (np.empty(3), np.empty(3), np.empty((8, 3)), np.empty((10, 3)))
    stack, nearest = np.empty((8 * DEEPEST + 16, 4)), np.empty(3)
    least, most, own = np.empty(3, np.int64), np.empty(3, np.int64), np.empty(3, np.int64)
    for n in range(len(y)):
        q = y[n]
        best = (reach * (1.0 + 1e-9) + 1e-9) ** 2
        span = math.sqrt(best)
        for d in range(3):
            least[d] = int(max(q[d] - span, 0.0) / width[d])
            most[d] = min(int((q[d] + span) / width[d]), root.shape[d] - 1)
            own[d] = min(max(int(q[d] / width[d]), least[d]), most[d])
        nearest[:] = np.nan
        # the root brick that holds q first: its roots are likely the nearest
        here = root[own[0], own[1], own[2]]
        if here >= 0:
            best = _search_brick(here, q, best, nearest, tree, queue, cell, stack)
        for i in range(least[0], most[0] + 1):
            for j in range(least[1], most[1] + 1):
                for k in range(least[2], most[2] + 1):
                    other = root[i, j, k]
                    if other >= 0 and other != here:
                        best = _search_brick(other, q, best, nearest, tree, queue, cell, stack)
        out[n] = nearest


@njit(cache=True, nogil=True)
def _search_brick(first, q, best, nearest, tree, queue, cell, stack):
    """The squared distance of the nearest root in a root brick if it is below `best`, else `best`.

    Args:
        nearest: (3,), written where there is one.
        tree: as in `nearest_roots`. queue, cell, stack: room to work in.
    """
    child, slot, level, position, values, width, open_hull, hull = tree
    waiting, away, distances, order = queue
    i, j, k = position[first]
    waiting[0, 0], waiting[0, 1] = first, -1
    away[0] = distance2(q, i * width[0], j * width[1], k * width[2], width[0], width[1], width[2])
    top = 1
    while top > 0:
        top -= 1
        if away[top] >= best:
            continue
        brick, octant = waiting[top, 0], waiting[top, 1]
        part = 1.0 / 2.0 ** level[brick]
        if octant >= 0:
            if _holds(open_hull[brick, octant], q):
                best = _search_octant(
                    brick,
                    octant,
                    q,
                    part,
                    best,
                    nearest,
                    slot,
                    position,
                    values,
                    width,
                    cell,
                    stack,
                )
        elif _holds(hull[brick], q):
            _sort_octants(position[brick], q, part, width, distances, order)
            for m in range(8):
                below = child[brick, order[m]]
                away[top] = distances[m]
                waiting[top, 0] = below if below >= 0 else brick
                waiting[top, 1] = -1 if below >= 0 else order[m]
                top += 1
    return best


@njit(cache=True, nogil=True)
def _holds(hull, q):
    """Whether q lies in a box: least, then greatest corner."""
    return hull[0] <= q[0] <= hull[3] and hull[1] <= q[1] <= hull[4] and hull[2] <= q[2] <= hull[5]


@njit(cache=True, nogil=True)
def _sort_octants(position, q, part, width, distances, order):
    """Write a brick's octants and their squared distances from q, farthest first."""
    for o in range(8):
        distance = distance2(
            q,
            (position[0] + 0.5 * (o >> 2)) * part * width[0],
            (position[1] + 0.5 * (o >> 1 & 1)) * part * width[1],
            (position[2] + 0.5 * (o & 1)) * part * width[2],
            0.5 * part * width[0],
            0.5 * part * width[1],
            0.5 * part * width[2],
        )
        place = o
        while place > 0 and distances[place - 1] < distance:
            distances[place], order[place] = distances[place - 1], order[place - 1]
            place -= 1
        distances[place], order[place] = distance, o


@njit(cache=True, nogil=True)
def _search_octant(
    brick, octant, q, part, best, nearest, slot, position, values, width, cell, stack
):
    """As `_search_brick`, in the cells of one octant that the brick decides itself."""
    x0, side, corner, work = cell
    half = CELLS // 2
    row = np.int64(slot[brick]) * NODES
    for d in range(3):
        side[d] = part * width[d] / CELLS
    a0, b0, c0 = half * (octant >> 2), half * (octant >> 1 & 1), half * (octant & 1)
    for a in range(a0, a0 + half):
        for b in range(b0, b0 + half):
            for c in range(c0, c0 + half):
                x0[0] = (position[brick, 0] * CELLS + a) * side[0]
                x0[1] = (position[brick, 1] * CELLS + b) * side[1]
                x0[2] = (position[brick, 2] * CELLS + c) * side[2]
                if distance2(q, x0[0], x0[1], x0[2], side[0], side[1], side[2]) >= best:
                    continue
                first = (row + a) * NODES * NODES + b * NODES + c
                if _may_reach(first, q, x0, side, values, corner):
                    best = search_cell(corner, q, x0, side, best, nearest, work, stack)
    return best


@njit(cache=True, nogil=True)
def _may_reach(first, q, x0, side, values, corner):
    """Write f − q at a cell's corners; whether each component comes to 0 between them.

    Args:
        first: the node at the cell's least corner x0. corner: (8, 3) m, written as far as needed.
    """
    for d in range(3):
        low, high = np.inf, -np.inf
        for o in range(8):
            i, j, k = o >> 2, o >> 1 & 1, o & 1
            at = first + (i * NODES + j) * NODES + k
            step = i if d == 0 else (j if d == 1 else k)
            v = x0[d] + step * side[d] - q[d] + np.float64(values[at * 3 + d])
            corner[o, d] = v
            low, high = min(low, v), max(high, v)
        if low > SLACK or high < -SLACK:
            return False
    return True


class RootSearch:
    """The search of one table, with the bounds it needs; made once, shared by re-posed tables."""

    def __init__(
        self,
        root: NDArray[np.int32],
        child: NDArray[np.int32],
        slot: NDArray[np.int32],
        level: NDArray[np.int32],
        position: NDArray[np.int32],
        values: NDArray[np.float32],
        width: NDArray[np.float64],
        reach: float,
    ) -> None:
        count = len(child)
        self._open_hull = np.empty((count, 8, 6))
        self._hull = np.empty((count, 6))
        order = np.argsort(level, kind="stable")
        hulls(order, level, position, child, slot, values, width, self._open_hull, self._hull)
        self._tree = (root, child, slot, level, position, values, width)
        self._reach = reach

    def __call__(self, y: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, 3) m, table frame, NaN where there is none; for y (n, 3) m inside the table."""
        out = np.empty_like(y)
        nearest_roots(y, *self._tree, self._open_hull, self._hull, self._reach, out)
        return out
