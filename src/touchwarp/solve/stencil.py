"""The discrete equation: seven-point stencils, with Shortley–Weller weights at cut edges.

Rows are scaled by h², h the shortest side of a cell: Σ w_d (u_d - u) - λh² u + f = 0 with w =
(h/h_d)² along each axis. A row with cut edges takes the crossing's distance and g there: w_± = 2w /
(θ_± (θ_- + θ_+)). All weights are non-negative, so the maximum principle holds on a level.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from touchwarp.solve.cuts import Cuts

LANES = 4
"""Right-hand sides solved together: one 128-bit lane of float32."""


@dataclass(eq=False)
class Stencils:
    """The rows of a level.

    Attributes:
        axis_weights: (3,) float32, (h/h_d)².
        screening: λh² of this level.
        rows: (k, 7) float32, weights of the six neighbours (0 where cut) and the diagonal, for
            the nodes of `Cuts.node`.
        cut_weight: (c,) float32, what each cut multiplies g by.
    """

    axis_weights: NDArray[np.float32]
    screening: np.float32
    rows: NDArray[np.float32]
    cut_weight: NDArray[np.float32]


def make_stencils(
    cuts: Cuts, spacing: NDArray[np.float64], screening: float, depth: int
) -> Stencils:
    """The rows of a level with root spacing `spacing` (3,) m and screening λ in m⁻²."""
    h = spacing.min()
    axis_weights = (h / spacing) ** 2
    level_screening = screening * (h / 2.0**depth) ** 2
    rows = np.zeros((len(cuts.node), 7), np.float32)
    cut_weight = np.zeros(len(cuts.distance), np.float32)
    _assemble(
        cuts.start, cuts.direction, cuts.distance, axis_weights, level_screening, rows, cut_weight
    )
    return Stencils(axis_weights.astype(np.float32), np.float32(level_screening), rows, cut_weight)


@njit(cache=True)
def _assemble(start, direction, distance, axis_weights, screening, rows, cut_weight):
    theta = np.empty(6)
    for r in range(rows.shape[0]):
        theta[:] = 1.0
        for k in range(start[r], start[r + 1]):
            theta[direction[k]] = distance[k]
        diagonal = screening
        for d in range(6):
            weight = 2.0 * axis_weights[d // 2] / (theta[d] * (theta[d] + theta[d ^ 1]))
            rows[r, d] = weight
            diagonal += weight
        rows[r, 6] = diagonal
        for k in range(start[r], start[r + 1]):
            cut_weight[k] = rows[r, direction[k]]
        for k in range(start[r], start[r + 1]):
            rows[r, direction[k]] = 0.0


@njit(cache=True)
def values_at_cuts(triangle, weights, faces, data, values):
    """g's lanes at each cut: the triangle's corner data, linearly."""
    for k in range(triangle.shape[0]):
        t = triangle[k]
        w0, w1 = weights[k, 0], weights[k, 1]
        for q in range(LANES):
            values[k, q] = (
                w0 * data[faces[t, 0], q]
                + w1 * data[faces[t, 1], q]
                + (1.0 - w0 - w1) * data[faces[t, 2], q]
            )


@njit(cache=True)
def gather_boundary(start, cut_weight, values, boundary):
    """The boundary term of each cut row: Σ weight · g over its cuts."""
    for r in range(boundary.shape[0]):
        for q in range(LANES):
            boundary[r, q] = 0.0
        for k in range(start[r], start[r + 1]):
            for q in range(LANES):
                boundary[r, q] += cut_weight[k] * values[k, q]


@njit(cache=True, parallel=True, fastmath=True)
def sweep(u, f, neighbours, row, rows, boundary, axis_weights, screening, first, last):
    """Gauss–Seidel over nodes first..last, which must be of one colour."""
    wx, wy, wz = axis_weights[0], axis_weights[1], axis_weights[2]
    inverse = np.float32(1.0) / (np.float32(2.0) * (wx + wy + wz) + screening)
    for m in prange(first, last):
        r = row[m]
        a, b, c = neighbours[m, 0], neighbours[m, 1], neighbours[m, 2]
        d, e, g = neighbours[m, 3], neighbours[m, 4], neighbours[m, 5]
        if r < 0:
            for q in range(LANES):
                u[m, q] = (
                    wx * (u[a, q] + u[b, q])
                    + wy * (u[c, q] + u[d, q])
                    + wz * (u[e, q] + u[g, q])
                    + f[m, q]
                ) * inverse
        else:
            own = np.float32(1.0) / rows[r, 6]
            for q in range(LANES):
                u[m, q] = (
                    rows[r, 0] * u[a, q]
                    + rows[r, 1] * u[b, q]
                    + rows[r, 2] * u[c, q]
                    + rows[r, 3] * u[d, q]
                    + rows[r, 4] * u[e, q]
                    + rows[r, 5] * u[g, q]
                    + boundary[r, q]
                    + f[m, q]
                ) * own


@njit(cache=True, fastmath=True, inline="always")
def row_residual(u, neighbours, row, rows, boundary, axis_weights, diagonal, m, out):
    """Boundary term - (A u) in the row of inner node m, scaled to the plain rows' diagonal."""
    wx, wy, wz = axis_weights[0], axis_weights[1], axis_weights[2]
    r = row[m]
    a, b, c = neighbours[m, 0], neighbours[m, 1], neighbours[m, 2]
    d, e, g = neighbours[m, 3], neighbours[m, 4], neighbours[m, 5]
    if r < 0:
        for q in range(LANES):
            out[q] = (
                wx * (u[a, q] + u[b, q])
                + wy * (u[c, q] + u[d, q])
                + wz * (u[e, q] + u[g, q])
                - diagonal * u[m, q]
            )
    else:
        scale = diagonal / rows[r, 6]
        for q in range(LANES):
            out[q] = scale * (
                rows[r, 0] * u[a, q]
                + rows[r, 1] * u[b, q]
                + rows[r, 2] * u[c, q]
                + rows[r, 3] * u[d, q]
                + rows[r, 4] * u[e, q]
                + rows[r, 5] * u[g, q]
                + boundary[r, q]
                - rows[r, 6] * u[m, q]
            )


@njit(cache=True, parallel=True, fastmath=True)
def residual(u, f, neighbours, row, rows, boundary, axis_weights, screening, result):
    """The residual at every inner node; cut rows are scaled to the plain rows' diagonal."""
    diagonal = np.float32(2.0) * axis_weights.sum() + screening
    for m in prange(neighbours.shape[0]):
        row_residual(u, neighbours, row, rows, boundary, axis_weights, diagonal, m, result[m])
        scale = np.float32(1.0) if row[m] < 0 else diagonal / rows[row[m], 6]
        for q in range(LANES):
            result[m, q] += scale * f[m, q]


@njit(cache=True)
def hold_floor(u, nodes, lanes):
    """Set the lanes that vanish on the sliding plane to zero there."""
    for i in range(nodes.shape[0]):
        for q in range(LANES):
            if lanes[q]:
                u[nodes[i], q] = 0.0
