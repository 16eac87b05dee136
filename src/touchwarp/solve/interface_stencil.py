"""The compiled part of `interface`: the polynomial through nodes and crossings along a line."""

from __future__ import annotations

import numpy as np
from numba import njit, prange

from touchwarp.solve.cuts import cut_along
from touchwarp.solve.level import node_at

APART = 0.3
"""A crossing nearer than this (in coarse cells) to another point of the polynomial is left out."""


@njit(cache=True)
def _cut_along(row, start, direction, distance, node, wanted):
    """(cut, distance) of a node's edge in one direction, or (-1, 2)."""
    k = cut_along(row, start, direction, node, wanted)
    return k, (distance[k] if k >= 0 else 2.0)


@njit(cache=True)
def _lagrange(at, points, count, weights):
    for i in range(count):
        w = 1.0
        for j in range(count):
            if j != i:
                w *= (at - points[j]) / (points[i] - points[j])
        weights[i] = w


@njit(cache=True)
def _points_on_edge(c, cut, theta, ends, points, kinds):
    """Choose up to four points for the middle (t = ½) of the edge t = 0..1.

    `c` holds the nodes at t = -1, 0, 1, 2 (or -1). `cut`, `theta` (2, 2): at [0] from the node at 0
    towards 1 and away, at [1] from the node at 1 towards 0 and away. `ends` allows the far nodes.
    `kinds` receives 0..3 for a node, 4 + 2·side + way for a crossing. Returns the count.
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
        elif c[0] >= 0 and ends:
            points[n], kinds[n] = -1.0, 0
            n += 1
    if right:
        points[n], kinds[n] = 1.0, 2
        n += 1
        if cut[1, 1] >= 0:
            if theta[1, 1] >= APART:
                points[n], kinds[n] = 1.0 + theta[1, 1], 7
                n += 1
        elif c[3] >= 0 and ends:
            points[n], kinds[n] = 2.0, 3
            n += 1
    if blocked:
        if left:
            points[n], kinds[n] = theta[0, 0], 4
        else:
            points[n], kinds[n] = 1.0 - theta[1, 0], 6
        n += 1
    return n


@njit(cache=True)
def _line(
    node, around, floor, row, start, direction, distance, b, x, y, z, axis, nodes, cut, theta
):
    """Nodes at -1, 0, 1, 2 along an axis from (x, y, z) of brick b, and the cuts of the middle
    two."""
    dx, dy, dz = int(axis == 0), int(axis == 1), int(axis == 2)
    for t in range(4):
        s = t - 1
        if floor and z + s * dz < 0:
            nodes[t] = -1
        else:
            nodes[t] = node_at(node, around, floor, b, x + s * dx, y + s * dy, z + s * dz)
    for side in range(2):
        m = nodes[1 + side]
        towards = 2 * axis + 1 - side
        cut[side, 0], theta[side, 0] = _cut_along(row, start, direction, distance, m, towards)
        cut[side, 1], theta[side, 1] = _cut_along(row, start, direction, distance, m, towards ^ 1)


@njit(cache=True)
def _edge_terms(
    node, around, floor, row, start, direction, distance, b, x, y, z, axis, source, weight
):
    """Terms of the middle of the coarse edge from (x, y, z) of coarse brick b along an axis."""
    nodes = np.empty(4, np.int64)
    cut = np.empty((2, 2), np.int64)
    theta = np.empty((2, 2))
    points = np.empty(5)
    kinds = np.empty(5, np.int64)
    _line(node, around, floor, row, start, direction, distance, b, x, y, z, axis, nodes, cut, theta)
    n = _points_on_edge(nodes, cut, theta, True, points, kinds)
    _lagrange(0.5, points, n, weight)
    for i in range(n):
        if kinds[i] < 4:
            source[i] = nodes[kinds[i]]
        else:
            source[i] = -1 - cut[(kinds[i] - 4) // 2, kinds[i] % 2]
    return n


@njit(cache=True, parallel=True)
def expand_rim(
    rim,
    site,
    bricks,
    parent,
    node,
    around,
    row,
    start,
    direction,
    distance,
    coarse_node,
    coarse_around,
    coarse_bricks,
    mirrored,
    coarse_row,
    coarse_start,
    coarse_direction,
    coarse_distance,
    out_start,
    out_length,
    out_source,
    out_weight,
    fine_start,
    fine_length,
    fine_cut,
    fine_weight,
):
    for i in prange(rim.shape[0]):
        m = rim[i]
        b = site[m] // 512
        local = site[m] % 512
        at = np.empty(3, np.int64)
        at[0], at[1], at[2] = local // 64, local // 8 % 8, local % 8
        p = parent[b]
        floor = mirrored and coarse_bricks[p, 2] == 0
        half = np.empty(3, np.int64)
        odd = np.empty(3, np.int64)
        n_odd = 0
        for d in range(3):
            half[d] = 4 * (bricks[b, d] & 1) + at[d] // 2
            if at[d] & 1:
                odd[n_odd] = d
                n_odd += 1
        source = np.empty(5, np.int64)
        weight = np.empty(5)
        terms = 0
        fine_terms = 0
        first = out_start[i]
        fine_first = fine_start[i]
        if n_odd == 0:
            out_source[first] = node_at(
                coarse_node, coarse_around, floor, p, half[0], half[1], half[2]
            )
            out_weight[first] = 1.0
            terms = 1
        elif n_odd == 1:
            terms = _edge_terms(
                coarse_node,
                coarse_around,
                floor,
                coarse_row,
                coarse_start,
                coarse_direction,
                coarse_distance,
                p,
                half[0],
                half[1],
                half[2],
                odd[0],
                source,
                weight,
            )
            for k in range(terms):
                out_source[first + k] = source[k]
                out_weight[first + k] = weight[k]
        else:
            # Along the first odd axis lie middles of coarse edges; fine cuts tell what blocks them.
            axis, other = odd[0], odd[1]
            step = np.zeros(3, np.int64)
            step[axis] = 1
            mids = np.empty(4, np.int64)
            cut = np.full((2, 2), -1, np.int64)
            theta = np.full((2, 2), 2.0)
            points = np.empty(5)
            kinds = np.empty(5, np.int64)
            fine_floor = mirrored and bricks[b, 2] == 0
            for t in range(4):
                s = 2 * t - 3
                mids[t] = node_at(
                    node,
                    around,
                    fine_floor,
                    b,
                    at[0] + s * step[0],
                    at[1] + s * step[1],
                    at[2] + s * step[2],
                )
                if fine_floor and at[2] + s * step[2] < 0:
                    mids[t] = -1
            for side in range(2):
                way = 2 * axis + side
                k, distance_near = _cut_along(row, start, direction, distance, m, way)
                if k >= 0:
                    cut[side, 0] = k
                    theta[side, 0] = 0.5 * distance_near
                elif mids[1 + side] >= 0:
                    k, distance_far = _cut_along(
                        row, start, direction, distance, mids[1 + side], way
                    )
                    s = 2 if side else -2
                    beyond = node_at(
                        node,
                        around,
                        fine_floor,
                        b,
                        at[0] + s * step[0],
                        at[1] + s * step[1],
                        at[2] + s * step[2],
                    )
                    if k >= 0:
                        cut[side, 1] = k
                        theta[side, 1] = 0.5 * distance_far
                    elif beyond >= 0:
                        k, distance_far = _cut_along(row, start, direction, distance, beyond, way)
                        if k >= 0:
                            cut[side, 1] = k
                            theta[side, 1] = 0.5 + 0.5 * distance_far
            n = 0
            for side in range(2):
                sign = 1.0 if side else -1.0
                if cut[side, 0] >= 0:
                    points[n], kinds[n] = sign * theta[side, 0], 4 + 2 * side
                    n += 1
                    continue
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
            line_weight = np.empty(5)
            _lagrange(0.0, points, n, line_weight)
            for k in range(n):
                if kinds[k] >= 4:
                    fine_cut[fine_first + fine_terms] = cut[(kinds[k] - 4) // 2, kinds[k] % 2]
                    fine_weight[fine_first + fine_terms] = line_weight[k]
                    fine_terms += 1
                    continue
                along = kinds[k] - 1
                count = _edge_terms(
                    coarse_node,
                    coarse_around,
                    floor,
                    coarse_row,
                    coarse_start,
                    coarse_direction,
                    coarse_distance,
                    p,
                    half[0] + along * step[0],
                    half[1] + along * step[1],
                    half[2] + along * step[2],
                    other,
                    source,
                    weight,
                )
                for j in range(count):
                    out_source[first + terms + j] = source[j]
                    out_weight[first + terms + j] = line_weight[k] * weight[j]
                terms += count
        out_length[i] = terms
        fine_length[i] = fine_terms
