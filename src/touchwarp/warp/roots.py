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
    stack = np.empty((8 * DEEPEST + 16, 4))
    waiting = np.empty((512, 2), np.int64)
    away = np.empty(512)
    work = np.empty((10, 3))
    corner = np.empty((8, 3))
    x0, side, nearest = np.empty(3), np.empty(3), np.empty(3)
    queue_d, queue = np.empty(8), np.empty(8, np.int64)
    for n in range(len(y)):
        q = y[n]
        out[n] = np.nan
        best = (reach * (1.0 + 1e-9) + 1e-9) ** 2
        span = math.sqrt(best)
        i0, i1 = int(max(q[0] - span, 0.0) / width[0]), int((q[0] + span) / width[0])
        j0, j1 = int(max(q[1] - span, 0.0) / width[1]), int((q[1] + span) / width[1])
        k0, k1 = int(max(q[2] - span, 0.0) / width[2]), int((q[2] + span) / width[2])
        i1, j1, k1 = (
            min(i1, root.shape[0] - 1),
            min(j1, root.shape[1] - 1),
            min(k1, root.shape[2] - 1),
        )
        # the root brick that holds q first: its roots are likely the nearest
        ci = min(max(int(q[0] / width[0]), i0), i1)
        cj = min(max(int(q[1] / width[1]), j0), j1)
        ck = min(max(int(q[2] / width[2]), k0), k1)
        for turn in range(-1, (i1 - i0 + 1) * (j1 - j0 + 1) * (k1 - k0 + 1)):
            if turn < 0:
                i, j, k = ci, cj, ck
            else:
                k = k0 + turn % (k1 - k0 + 1)
                j = j0 + turn // (k1 - k0 + 1) % (j1 - j0 + 1)
                i = i0 + turn // ((k1 - k0 + 1) * (j1 - j0 + 1))
                if i == ci and j == cj and k == ck:
                    continue
            first = root[i, j, k]
            if first < 0:
                continue
            away[0] = distance2(
                q, i * width[0], j * width[1], k * width[2], width[0], width[1], width[2]
            )
            waiting[0, 0], waiting[0, 1] = first, -1
            top = 1
            while top > 0:
                top -= 1
                if away[top] >= best:
                    continue
                brick, octant = waiting[top, 0], waiting[top, 1]
                part = 1.0 / 2.0 ** level[brick]
                if octant < 0:
                    h = hull[brick]
                    if (
                        q[0] < h[0]
                        or q[0] > h[3]
                        or q[1] < h[1]
                        or q[1] > h[4]
                        or q[2] < h[2]
                        or q[2] > h[5]
                    ):
                        continue
                    for o in range(8):
                        distance = distance2(
                            q,
                            (position[brick, 0] + 0.5 * (o >> 2)) * part * width[0],
                            (position[brick, 1] + 0.5 * (o >> 1 & 1)) * part * width[1],
                            (position[brick, 2] + 0.5 * (o & 1)) * part * width[2],
                            0.5 * part * width[0],
                            0.5 * part * width[1],
                            0.5 * part * width[2],
                        )
                        place = o
                        while place > 0 and queue_d[place - 1] < distance:
                            queue_d[place], queue[place] = queue_d[place - 1], queue[place - 1]
                            place -= 1
                        queue_d[place], queue[place] = distance, o
                    for m in range(8):
                        o = queue[m]
                        away[top] = queue_d[m]
                        below = child[brick, o]
                        if below >= 0:
                            waiting[top, 0], waiting[top, 1] = below, -1
                        else:
                            waiting[top, 0], waiting[top, 1] = brick, o
                        top += 1
                    continue
                h = open_hull[brick, octant]
                if (
                    q[0] < h[0]
                    or q[0] > h[3]
                    or q[1] < h[1]
                    or q[1] > h[4]
                    or q[2] < h[2]
                    or q[2] > h[5]
                ):
                    continue
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
                            possible = True
                            for d in range(3):
                                low, high = np.inf, -np.inf
                                for o in range(8):
                                    di, dj, dk = o >> 2, o >> 1 & 1, o & 1
                                    at = ((row + a + di) * NODES + b + dj) * NODES + c + dk
                                    step = di if d == 0 else (dj if d == 1 else dk)
                                    v = (
                                        x0[d]
                                        + step * side[d]
                                        - q[d]
                                        + np.float64(values[at * 3 + d])
                                    )
                                    corner[o, d] = v
                                    low, high = min(low, v), max(high, v)
                                if low > SLACK or high < -SLACK:
                                    possible = False
                                    break
                            if not possible:
                                continue
                            nearer = search_cell(corner, q, x0, side, best, nearest, work, stack)
                            if nearer < best:
                                best = nearer
                                for d in range(3):
                                    out[n, d] = nearest[d]


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
