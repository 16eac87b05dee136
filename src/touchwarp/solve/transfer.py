"""Between two levels: injection, full weighting of the residual, trilinear and cubic prolongation.

All work brick by brick: what a brick needs of the other level is gathered into a small dense block
once.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.solve.level import FLOOR, LOCAL, Level, beside, node_at, octant_start
from touchwarp.solve.stencil import LANES


def covered_bricks(fine: Level, coarse: Level) -> NDArray[np.bool_]:
    """(b,) coarse bricks with an inner node that is an inner node of the finer level, too."""
    marks = np.zeros(coarse.n, bool)
    mark_covered(0, len(fine.bricks), fine.places, coarse.places, marks)
    bricks = np.zeros(len(coarse.bricks), bool)
    bricks[coarse.site[np.flatnonzero(marks)] // LOCAL] = True
    return bricks


@njit(cache=True, nogil=True)
def amplify(first, last, fine, coarse, has_equation, slots, factor, source):
    """Multiply the coarse equation's right-hand side f where fine bricks first..last are finest.

    `has_equation` (n,) tells fine nodes that a still finer level covers; `slots` and `source` are
    the coarse level's.
    """
    bricks, parent, node, coarse_node = fine.bricks, fine.parent, fine.node, coarse.node
    for b in range(first, last):
        start = 512 * np.int64(parent[b]) + octant_start(bricks, b)
        slot = np.int64(slots[parent[b]])
        if slot < 0:
            continue
        for i in range(64):
            half = 64 * (i >> 4) + 8 * ((i >> 2) & 3) + (i & 3)
            m, c = node[512 * b + 2 * half], coarse_node[start + half]
            inner = 0 <= m < fine.n_inner and 0 <= c < coarse.n_inner
            if inner and not has_equation[m]:
                for q in range(LANES):
                    source[512 * slot + ((start + half) & 511), q] *= factor


@njit(cache=True, nogil=True)
def mark_covered(first, last, fine, coarse, marks):
    """Mark the coarse inner nodes (n,) that are inner nodes of fine bricks first..last as well."""
    bricks, parent, node, coarse_node = fine.bricks, fine.parent, fine.node, coarse.node
    for b in range(first, last):
        start = 512 * np.int64(parent[b]) + octant_start(bricks, b)
        for i in range(64):
            half = 64 * (i >> 4) + 8 * ((i >> 2) & 3) + (i & 3)
            m, c = node[512 * b + 2 * half], coarse_node[start + half]
            if 0 <= m < fine.n_inner and 0 <= c < coarse.n_inner:
                marks[c] = True


@njit(cache=True, nogil=True)
def inject(first, last, fine, coarse, fine_u, coarse_u):
    """Coarse values take the fine ones where they are covered, for fine bricks first..last."""
    bricks, parent, node, coarse_node = fine.bricks, fine.parent, fine.node, coarse.node
    for b in range(first, last):
        start = 512 * np.int64(parent[b]) + octant_start(bricks, b)
        for i in range(64):
            half = 64 * (i >> 4) + 8 * ((i >> 2) & 3) + (i & 3)
            m, c = node[512 * b + 2 * half], coarse_node[start + half]
            if 0 <= m < fine.n_inner and 0 <= c < coarse.n_inner:
                for q in range(LANES):
                    coarse_u[c, q] = fine_u[m, q]


@njit(cache=True, nogil=True, fastmath=True)
def restrict_equation(first, last, fine, coarse, fine_r, equation, coarse_u):
    """FAS right-hand side where fine bricks first..last cover: f_c = L_c(I u) + R r.

    `equation` is the coarse level's; its `source` is written.
    """
    bricks, parent, node, around = fine.bricks, fine.parent, fine.node, fine.around
    coarse_node, coarse_around = coarse.node, coarse.around
    row, rows, boundary = equation.row, equation.rows, equation.boundary
    slots, source, weights = equation.slot, equation.source, equation.axis_weights
    diagonal = np.float32(2.0) * (weights[0] + weights[1] + weights[2]) + equation.screening
    block = np.empty((9, 9, 9, LANES), np.float32)
    total = np.empty(LANES, np.float32)
    for b in range(first, last):
        start = 512 * np.int64(parent[b]) + octant_start(bricks, b)
        slot = np.int64(slots[parent[b]])
        if slot < 0:
            continue
        for x in range(9):
            for y in range(9):
                for z in range(9):
                    m = node_at(node, around, b, x - 1, y - 1, z - 1)
                    inner = 0 <= m < fine.n_inner
                    for q in range(LANES):
                        block[x, y, z, q] = fine_r[m, q] if inner else np.float32(0.0)
        for i in range(64):
            x, y, z = i >> 4, (i >> 2) & 3, i & 3
            half = 64 * x + 8 * y + z
            m, c = node[512 * b + 2 * half], coarse_node[start + half]
            if not (0 <= m < fine.n_inner and 0 <= c < coarse.n_inner):
                continue
            for q in range(LANES):
                total[q] = 0.0
            for dx in range(3):
                for dy in range(3):
                    for dz in range(3):
                        weight = np.float32(0.5 / (1 << ((dx != 1) + (dy != 1) + (dz != 1))))
                        for q in range(LANES):
                            total[q] += weight * block[2 * x + dx, 2 * y + dy, 2 * z + dz, q]
            r = row[c]
            own = diagonal if r < 0 else rows[r, 6]
            for q in range(LANES):
                total[q] = own * (total[q] / diagonal + coarse_u[c, q])
                if r >= 0:
                    total[q] -= boundary[r, q]
            for d in range(6):
                k = beside(coarse_node, coarse_around, start + half, d)
                weight = weights[d >> 1] if r < 0 else rows[r, d]
                for q in range(LANES):
                    total[q] -= weight * coarse_u[k, q]
            for q in range(LANES):
                source[512 * slot + ((start + half) & 511), q] = total[q]


@njit(cache=True, nogil=True)
def coarse_change(first, last, fine, coarse, fine_u, coarse_u, change):
    """What a coarse solve has changed, at the nodes that fine bricks first..last have as well.

    The fine level still holds what the coarse one started from.
    """
    bricks, parent, node, coarse_node = fine.bricks, fine.parent, fine.node, coarse.node
    for b in range(first, last):
        start = 512 * np.int64(parent[b]) + octant_start(bricks, b)
        for i in range(64):
            half = 64 * (i >> 4) + 8 * ((i >> 2) & 3) + (i & 3)
            m, c = node[512 * b + 2 * half], coarse_node[start + half]
            if m >= 0 and c >= 0:
                for q in range(LANES):
                    change[c, q] = coarse_u[c, q] - fine_u[m, q]


@njit(cache=True, nogil=True, fastmath=True)
def prolong_correction(first, last, fine, coarse, change, fine_u):
    """Add the trilinear interpolant of the coarse change to the inner nodes of fine bricks."""
    bricks, parent, node = fine.bricks, fine.parent, fine.node
    coarse_node, coarse_around = coarse.node, coarse.around
    block = np.zeros((5, 5, 5, LANES), np.float32)
    for b in range(first, last):
        p = np.int64(parent[b])
        x0, y0, z0 = 4 * (bricks[b, 0] & 1), 4 * (bricks[b, 1] & 1), 4 * (bricks[b, 2] & 1)
        for x in range(5):
            for y in range(5):
                for z in range(5):
                    c = node_at(coarse_node, coarse_around, p, x0 + x, y0 + y, z0 + z)
                    if c >= 0:
                        for q in range(LANES):
                            block[x, y, z, q] = change[c, q]
        for x in range(8):
            for y in range(8):
                for z in range(8):
                    m = node[512 * b + 64 * x + 8 * y + z]
                    if m < 0 or m >= fine.n_inner:
                        continue
                    a, d, e = x >> 1, y >> 1, z >> 1
                    i, j, k = a + (x & 1), d + (y & 1), e + (z & 1)
                    for q in range(LANES):
                        fine_u[m, q] += np.float32(0.125) * (
                            block[a, d, e, q]
                            + block[a, d, k, q]
                            + block[a, j, e, q]
                            + block[a, j, k, q]
                            + block[i, d, e, q]
                            + block[i, d, k, q]
                            + block[i, j, e, q]
                            + block[i, j, k, q]
                        )


@njit(cache=True, nogil=True, fastmath=True)
def prolong_cubic(first, last, fine, coarse, coarse_u, floor_sign, fine_u):
    """Set the inner nodes of fine bricks to the coarse values, cubic where these are all there.

    `floor_sign` (4,) is -1 for lanes that are odd across the sliding plane.
    """
    bricks, parent, node = fine.bricks, fine.parent, fine.node
    coarse_node, coarse_around = coarse.node, coarse.around
    line = np.empty((7, LANES), np.float32)
    block = np.zeros((LOCAL, LANES), np.float32)
    for b in range(first, last):
        p = np.int64(parent[b])
        x0, y0, z0 = 4 * (bricks[b, 0] & 1), 4 * (bricks[b, 1] & 1), 4 * (bricks[b, 2] & 1)
        whole = True
        for x in range(7):
            for y in range(7):
                for z in range(7):
                    c = node_at(coarse_node, coarse_around, p, x0 + x - 1, y0 + y - 1, z0 + z - 1)
                    whole = whole and c >= 0
                    under = z0 + z < 1 and coarse_around[p, FLOOR] == 1
                    for q in range(LANES):
                        value = coarse_u[c, q] if c >= 0 else np.float32(0.0)
                        block[64 * x + 8 * y + z, q] = value * floor_sign[q] if under else value
        near = np.float32(9.0 / 16.0) if whole else np.float32(0.5)
        far = np.float32(-1.0 / 16.0) if whole else np.float32(0.0)
        # along z, y, x in turn: seven values become eight
        for axis in range(3):
            step = 1 << 3 * axis
            other, third = (8 if axis == 2 else 64), (8 if axis == 0 else 1)
            for i in range(8 if axis == 2 else 7):
                for j in range(7 if axis == 0 else 8):
                    at = other * i + third * j
                    for k in range(7):
                        for q in range(LANES):
                            line[k, q] = block[at + step * k, q]
                    for k in range(4):
                        for q in range(LANES):
                            block[at + step * 2 * k, q] = line[k + 1, q]
                            block[at + step * (2 * k + 1), q] = near * (
                                line[k + 1, q] + line[k + 2, q]
                            ) + far * (line[k, q] + line[k + 3, q])
        for local in range(LOCAL):
            m = node[512 * b + local]
            if 0 <= m < fine.n_inner:
                for q in range(LANES):
                    fine_u[m, q] = block[local, q]


@njit(cache=True, nogil=True)
def take_inner(first, last, there, narrow_node, n_inner, node, narrow_u, u):
    """Copy inner nodes' values between levels of one depth, for the narrower one's bricks.

    `there` (b,) is each brick's number in the wider level, or -1.
    """
    for b in range(first, last):
        if there[b] < 0:
            continue
        for local in range(LOCAL):
            old, new = narrow_node[b, local], node[there[b], local]
            if 0 <= old < n_inner:
                for q in range(LANES):
                    u[new, q] = narrow_u[old, q]
