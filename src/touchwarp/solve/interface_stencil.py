"""The compiled part of `interface`: the polynomial through nodes and crossings along a line."""

from __future__ import annotations

import numpy as np
from numba import njit

from touchwarp.solve.cuts import cut_along
from touchwarp.solve.level import FLOOR, node_at

APART = 0.3
"""A crossing nearer than this (in coarse cells) to another point of the polynomial is left out."""


@njit(cache=True, nogil=True)
def _cut_along(cuts, node, wanted):
    """(cut, distance) of a node's edge in one direction, or (-1, 2)."""
    k = cut_along(cuts.row, cuts.start, cuts.direction, node, wanted)
    return k, (cuts.distance[k] if k >= 0 else 2.0)


@njit(cache=True, nogil=True)
def _lagrange(at, points, count, weights):
    for i in range(count):
        w = 1.0
        for j in range(count):
            if j != i:
                w *= (at - points[j]) / (points[i] - points[j])
        weights[i] = w


@njit(cache=True, nogil=True)
def _points_on_edge(c, cut, theta, points, kinds):
    """Choose up to four points for the middle (t = ½) of the edge t = 0..1.

    `c` holds the nodes at t = -1, 0, 1, 2 (or -1). `cut`, `theta` (2, 2): at [0] from the node at 0
    towards 1 and away, at [1] from the node at 1 towards 0 and away. `kinds` receives 0..3 for a
    node, 4 + 2·side + way for a crossing. Returns the count.
    """
    n = 0
    blocked = cut[0, 0] >= 0
    left = not blocked or theta[0, 0] > 0.5
    right = not blocked or (theta[0, 0] <= 0.5 and theta[1, 0] >= 0.5)
    if left and blocked:
        right = False
    if not left and not right:
        points[0], kinds[0] = theta[0, 0], 4
        points[1], kinds[1] = 1.0 - theta[1, 0], 6
        if points[1] - points[0] < 1e-3:
            return 1
        return 2
    if left:
        points[n], kinds[n] = 0.0, 1
        n += 1
        if cut[0, 1] >= 0:
            if theta[0, 1] >= APART:
                points[n], kinds[n] = -theta[0, 1], 5
                n += 1
        elif c[0] >= 0:
            points[n], kinds[n] = -1.0, 0
            n += 1
    if right:
        points[n], kinds[n] = 1.0, 2
        n += 1
        if cut[1, 1] >= 0:
            if theta[1, 1] >= APART:
                points[n], kinds[n] = 1.0 + theta[1, 1], 7
                n += 1
        elif c[3] >= 0:
            points[n], kinds[n] = 2.0, 3
            n += 1
    if blocked:
        if left:
            points[n], kinds[n] = theta[0, 0], 4
        else:
            points[n], kinds[n] = 1.0 - theta[1, 0], 6
        n += 1
    return n


@njit(cache=True, nogil=True)
def _edge_terms(places, cuts, b, at, axis, line, source, weight):
    """Terms of the middle of the coarse edge that starts at `at` (3,) of brick b, along an axis.

    `line` is working space.
    """
    nodes, kinds, cut, points, theta = line
    dx, dy, dz = int(axis == 0), int(axis == 1), int(axis == 2)
    for s in range(-1, 3):
        x, y, z = at[0] + s * dx, at[1] + s * dy, at[2] + s * dz
        nodes[s + 1] = node_at(places.node, places.around, b, x, y, z)
        if z < 0 and places.around[b, FLOOR] == 1:
            nodes[s + 1] = -1
    for side in range(2):
        for way in range(2):
            # first towards the other node, then away from it
            towards = 2 * axis + 1 - (side ^ way)
            cut[side, way], theta[side, way] = _cut_along(cuts, nodes[1 + side], towards)
    n = _points_on_edge(nodes, cut, theta, points, kinds)
    _lagrange(0.5, points, n, weight)
    for i in range(n):
        if kinds[i] < 4:
            source[i] = nodes[kinds[i]]
        else:
            source[i] = -1 - cut[(kinds[i] - 4) // 2, kinds[i] % 2]
    return n


@njit(cache=True, nogil=True)
def _working_space():
    return (
        np.empty(4, np.int64),
        np.empty(5, np.int64),
        np.empty((2, 2), np.int64),
        np.empty(5),
        np.empty((2, 2)),
    )


@njit(cache=True, nogil=True)
def _fine_line(fine, cuts, m, brick, at, axis, line):
    """Choose the middles of coarse edges, and the fine crossings, that make a face's middle m.

    They lie along an axis through m, at distances of ½ and 3/2 coarse cells; fine cuts tell what
    blocks them. Returns how many there are.
    """
    mids, kinds, cut, points, theta = line
    dx, dy, dz = int(axis == 0), int(axis == 1), int(axis == 2)
    for t in range(4):
        s = 2 * t - 3
        x, y, z = at[0] + s * dx, at[1] + s * dy, at[2] + s * dz
        mids[t] = node_at(fine.node, fine.around, brick, x, y, z)
        if z < 0 and fine.around[brick, FLOOR] == 1:
            mids[t] = -1
    n = 0
    for side in range(2):
        way = 2 * axis + side
        sign = 1.0 if side else -1.0
        cut[side, 0], cut[side, 1] = -1, -1
        k, near = _cut_along(cuts, m, way)
        if k >= 0:
            cut[side, 0] = k
            points[n], kinds[n] = sign * 0.5 * near, 4 + 2 * side
            n += 1
            continue
        if mids[1 + side] >= 0:
            k, beyond = _cut_along(cuts, mids[1 + side], way)
            theta[side, 1] = 0.5 * beyond
            if k < 0:
                s = 4 * side - 2
                x, y, z = at[0] + s * dx, at[1] + s * dy, at[2] + s * dz
                far = node_at(fine.node, fine.around, brick, x, y, z)
                if far >= 0:
                    k, beyond = _cut_along(cuts, far, way)
                    theta[side, 1] = 0.5 + 0.5 * beyond
            cut[side, 1] = k
        points[n], kinds[n] = sign * 0.5, 1 + side
        n += 1
        if cut[side, 1] >= 0:
            if theta[side, 1] >= APART:
                points[n], kinds[n] = sign * (0.5 + theta[side, 1]), 5 + 2 * side
                n += 1
        elif mids[3 * side] >= 0:
            points[n], kinds[n] = sign * 1.5, 3 * side
            n += 1
    if n == 2 and abs(points[0] - points[1]) < 1e-3:
        n = 1
    return n


@njit(cache=True, nogil=True)
def expand_rim(
    first,
    last,
    rim,
    fine,
    coarse,
    cuts,
    coarse_cuts,
    out_start,
    out_length,
    out_source,
    out_weight,
    fine_start,
    fine_length,
    fine_cut,
    fine_weight,
):
    """The terms of rim nodes first..last; see `Interface`."""
    at, half, odd = np.empty(3, np.int64), np.empty(3, np.int64), np.empty(3, np.int64)
    source, weight, line_weight = np.empty(5, np.int64), np.empty(5), np.empty(5)
    across, along = _working_space(), _working_space()
    for i in range(first, last):
        m = rim[i]
        b, local = np.int64(fine.site[m] >> 9), fine.site[m] & 511
        at[0], at[1], at[2] = local >> 6, (local >> 3) & 7, local & 7
        p = np.int64(fine.parent[b])
        n_odd = 0
        for d in range(3):
            half[d] = 4 * (fine.bricks[b, d] & 1) + (at[d] >> 1)
            if at[d] & 1:
                odd[n_odd] = d
                n_odd += 1
        terms, fine_terms = 0, 0
        if n_odd == 0:
            out_source[out_start[i]] = node_at(
                coarse.node, coarse.around, p, half[0], half[1], half[2]
            )
            out_weight[out_start[i]] = 1.0
            terms = 1
        # A face's middle is made of the middles of four coarse edges, an edge's of one.
        axis, n = odd[0], min(n_odd, 1)
        line_weight[0] = 1.0
        if n_odd == 2:
            n = _fine_line(fine, cuts, m, b, at, axis, across)
            _lagrange(0.0, across[3], n, line_weight)
        for k in range(n):
            step = 0
            if n_odd == 2:
                kind = across[1][k]
                if kind >= 4:
                    fine_cut[fine_start[i] + fine_terms] = across[2][(kind - 4) // 2, kind % 2]
                    fine_weight[fine_start[i] + fine_terms] = line_weight[k]
                    fine_terms += 1
                    continue
                step = kind - 1
            half[axis] += step
            count = _edge_terms(coarse, coarse_cuts, p, half, odd[n_odd - 1], along, source, weight)
            half[axis] -= step
            for j in range(count):
                out_source[out_start[i] + terms + j] = source[j]
                out_weight[out_start[i] + terms + j] = line_weight[k] * weight[j]
            terms += count
        out_length[i] = terms
        fine_length[i] = fine_terms
