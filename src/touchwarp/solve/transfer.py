"""Between two levels: injection, full weighting of the residual, trilinear and cubic prolongation.

All work brick by brick: the coarse values a brick needs are gathered into a small dense block once.
"""

from __future__ import annotations

import numpy as np
from numba import njit, prange

from touchwarp.solve.level import node_at
from touchwarp.solve.stencil import LANES, row_residual


@njit(cache=True)
def covered_pairs(bricks, parent, node, n_inner, coarse_node, coarse_n_inner):
    """Fine inner nodes at even coordinates and the coarse inner nodes they coincide with."""
    count = 0
    for pass_ in range(2):
        if pass_ == 1:
            fine = np.empty(count, np.int32)
            coarse = np.empty(count, np.int32)
            count = 0
        for b in range(bricks.shape[0]):
            x0, y0, z0 = 4 * (bricks[b, 0] & 1), 4 * (bricks[b, 1] & 1), 4 * (bricks[b, 2] & 1)
            for x in range(4):
                for y in range(4):
                    for z in range(4):
                        m = node[b, 128 * x + 16 * y + 2 * z]
                        if m < 0 or m >= n_inner:
                            continue
                        c = coarse_node[parent[b], 64 * (x0 + x) + 8 * (y0 + y) + z0 + z]
                        if c < 0 or c >= coarse_n_inner:
                            continue
                        if pass_ == 1:
                            fine[count] = m
                            coarse[count] = c
                        count += 1
    return fine, coarse


@njit(cache=True, parallel=True)
def inject(fine_u, coarse_u, coarse_before, fine, coarse):
    """Coarse values take the fine ones where covered; all are kept for the correction."""
    for i in prange(fine.shape[0]):
        for q in range(LANES):
            coarse_u[coarse[i], q] = fine_u[fine[i], q]
    for m in prange(coarse_u.shape[0]):
        for q in range(LANES):
            coarse_before[m, q] = coarse_u[m, q]


@njit(cache=True, parallel=True, fastmath=True)
def restrict_equation(
    fine_r,
    fine,
    coarse,
    site,
    node,
    around,
    bricks,
    mirrored,
    n_inner,
    coarse_u,
    coarse_neighbours,
    coarse_row,
    coarse_rows,
    coarse_boundary,
    axis_weights,
    screening,
    floor_zero,
    coarse_f,
):
    """FAS right-hand side where covered: f_c = L_c(I u) + R r."""
    diagonal = np.float32(2.0) * axis_weights.sum() + screening
    for i in prange(fine.shape[0]):
        m, c = fine[i], coarse[i]
        b = site[m] // 512
        x, y, z = site[m] % 512 // 64, site[m] % 64 // 8, site[m] % 8
        floor = mirrored and bricks[b, 2] == 0
        s0 = s1 = s2 = s3 = np.float32(0.0)
        for dx in range(-1, 2):
            for dy in range(-1, 2):
                for dz in range(-1, 2):
                    k = node_at(node, around, floor, b, x + dx, y + dy, z + dz)
                    if 0 <= k < n_inner:
                        weight = np.float32(0.5 / (1 << (abs(dx) + abs(dy) + abs(dz))))
                        s0 += weight * fine_r[k, 0]
                        s1 += weight * fine_r[k, 1]
                        s2 += weight * fine_r[k, 2]
                        s3 += weight * fine_r[k, 3]
        own = coarse_f[c]
        row_residual(
            coarse_u,
            coarse_neighbours,
            coarse_row,
            coarse_rows,
            coarse_boundary,
            axis_weights,
            diagonal,
            c,
            own,
        )
        if floor and z == 0:
            for q in range(LANES):
                if floor_zero[q]:
                    own[q] = np.float32(0.0)
        r = coarse_row[c]
        scale = np.float32(1.0) if r < 0 else coarse_rows[r, 6] / diagonal
        own[0] = scale * (s0 - own[0])
        own[1] = scale * (s1 - own[1])
        own[2] = scale * (s2 - own[2])
        own[3] = scale * (s3 - own[3])


@njit(cache=True, parallel=True, fastmath=True)
def prolong_correction(
    fine_u,
    coarse_u,
    coarse_before,
    bricks,
    parent,
    node,
    n_inner,
    coarse_node,
    coarse_around,
    coarse_bricks,
    mirrored,
):
    """Add the trilinear interpolant of the coarse change to the fine inner nodes."""
    for b in prange(bricks.shape[0]):
        block = np.zeros((5, 5, 5, LANES), np.float32)
        p = parent[b]
        floor = mirrored and coarse_bricks[p, 2] == 0
        x0, y0, z0 = 4 * (bricks[b, 0] & 1), 4 * (bricks[b, 1] & 1), 4 * (bricks[b, 2] & 1)
        for x in range(5):
            for y in range(5):
                for z in range(5):
                    c = node_at(coarse_node, coarse_around, floor, p, x0 + x, y0 + y, z0 + z)
                    if c >= 0:
                        for q in range(LANES):
                            block[x, y, z, q] = coarse_u[c, q] - coarse_before[c, q]
        for x in range(8):
            for y in range(8):
                for z in range(8):
                    m = node[b, 64 * x + 8 * y + z]
                    if m < 0 or m >= n_inner:
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


@njit(cache=True, parallel=True, fastmath=True)
def prolong_cubic(
    fine_u,
    coarse_u,
    bricks,
    parent,
    node,
    n_inner,
    coarse_node,
    coarse_around,
    coarse_bricks,
    mirrored,
    floor_sign,
):
    """Set the fine inner nodes to the coarse values, cubic where the coarse nodes are all there."""
    for b in prange(bricks.shape[0]):
        block = np.zeros((7, 7, 7, LANES), np.float32)
        p = parent[b]
        floor = mirrored and coarse_bricks[p, 2] == 0
        x0, y0, z0 = 4 * (bricks[b, 0] & 1), 4 * (bricks[b, 1] & 1), 4 * (bricks[b, 2] & 1)
        whole = True
        for x in range(7):
            for y in range(7):
                for z in range(7):
                    c = node_at(
                        coarse_node, coarse_around, floor, p, x0 + x - 1, y0 + y - 1, z0 + z - 1
                    )
                    if c < 0:
                        whole = False
                    else:
                        below = floor and z0 + z < 1
                        for q in range(LANES):
                            sign = floor_sign[q] if below else np.float32(1.0)
                            block[x, y, z, q] = sign * coarse_u[c, q]
        near = np.float32(9.0 / 16.0) if whole else np.float32(0.5)
        far = np.float32(-1.0 / 16.0) if whole else np.float32(0.0)
        along_z = np.empty((7, 7, 8, LANES), np.float32)
        for x in range(7):
            for y in range(7):
                for z in range(8):
                    k = 1 + (z >> 1)
                    for q in range(LANES):
                        if z & 1:
                            along_z[x, y, z, q] = near * (
                                block[x, y, k, q] + block[x, y, k + 1, q]
                            ) + far * (block[x, y, k - 1, q] + block[x, y, k + 2, q])
                        else:
                            along_z[x, y, z, q] = block[x, y, k, q]
        along_y = np.empty((7, 8, 8, LANES), np.float32)
        for x in range(7):
            for y in range(8):
                k = 1 + (y >> 1)
                for z in range(8):
                    for q in range(LANES):
                        if y & 1:
                            along_y[x, y, z, q] = near * (
                                along_z[x, k, z, q] + along_z[x, k + 1, z, q]
                            ) + far * (along_z[x, k - 1, z, q] + along_z[x, k + 2, z, q])
                        else:
                            along_y[x, y, z, q] = along_z[x, k, z, q]
        for x in range(8):
            k = 1 + (x >> 1)
            for y in range(8):
                for z in range(8):
                    m = node[b, 64 * x + 8 * y + z]
                    if m < 0 or m >= n_inner:
                        continue
                    for q in range(LANES):
                        if x & 1:
                            fine_u[m, q] = near * (
                                along_y[k, y, z, q] + along_y[k + 1, y, z, q]
                            ) + far * (along_y[k - 1, y, z, q] + along_y[k + 2, y, z, q])
                        else:
                            fine_u[m, q] = along_y[k, y, z, q]
