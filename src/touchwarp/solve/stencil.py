"""The discrete equation: seven-point stencils, with Shortley–Weller weights at cut edges.

Rows are scaled by h², h the shortest side of a cell: Σ w_d (u_d - u) - λh² u + f = 0 with w =
(h/h_d)² along each axis. A row with cut edges takes the crossing's distance and g there: w_± = 2w /
(θ_± (θ_- + θ_+)). All weights are non-negative, so the maximum principle holds on a level.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.solve.cuts import Cuts
from touchwarp.solve.level import FLOOR

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


class Equation(NamedTuple):
    """A level's equation for compiled loops.

    Attributes:
        row, rows, axis_weights, screening: as in `Cuts` and `Stencils`.
        boundary: (k, 4) float32, g's part of each cut row.
        slot: (b,) int32, a brick's rows of 512 in `source`, or -1 where f = 0 on all its nodes.
        source: (512 · s, 4) float32, f: what the finer level replaces the equation by, where it
            covers this one.
    """

    row: NDArray[np.int32]
    rows: NDArray[np.float32]
    axis_weights: NDArray[np.float32]
    screening: np.float32
    boundary: NDArray[np.float32]
    slot: NDArray[np.int32]
    source: NDArray[np.float32]


def make_stencils(
    cuts: Cuts, spacing: NDArray[np.float64], screening: float, depth: int
) -> Stencils:
    """The rows of a level with root spacing `spacing` (3,) m and screening λ in m⁻²."""
    h = spacing.min()
    axis_weights = (h / spacing) ** 2
    level_screening = screening * (h / 2.0**depth) ** 2
    rows = np.zeros((len(cuts.node), 7), np.float32)
    cut_weight = np.zeros(len(cuts.distance), np.float32)
    _assemble(cuts, axis_weights, level_screening, rows, cut_weight)
    return Stencils(axis_weights.astype(np.float32), np.float32(level_screening), rows, cut_weight)


@njit(cache=True, nogil=True)
def _assemble(cuts, axis_weights, screening, rows, cut_weight):
    theta = np.empty(6)
    for r in range(rows.shape[0]):
        for d in range(6):
            theta[d] = 1.0
        for k in range(cuts.start[r], cuts.start[r + 1]):
            theta[cuts.direction[k]] = cuts.distance[k]
        diagonal = screening
        for d in range(6):
            weight = 2.0 * axis_weights[d // 2] / (theta[d] * (theta[d] + theta[d ^ 1]))
            rows[r, d] = weight
            diagonal += weight
        rows[r, 6] = diagonal
        for k in range(cuts.start[r], cuts.start[r + 1]):
            cut_weight[k] = rows[r, cuts.direction[k]]
        for k in range(cuts.start[r], cuts.start[r + 1]):
            rows[r, cuts.direction[k]] = 0.0


@njit(cache=True, nogil=True)
def values_at_cuts(cuts, faces, data, values):
    """g's lanes at each cut: the triangle's corner data, linearly."""
    for k in range(values.shape[0]):
        t = cuts.triangle[k]
        w0, w1 = cuts.weights[k, 0], cuts.weights[k, 1]
        for q in range(LANES):
            values[k, q] = (
                w0 * data[faces[t, 0], q]
                + w1 * data[faces[t, 1], q]
                + (1.0 - w0 - w1) * data[faces[t, 2], q]
            )


@njit(cache=True, nogil=True)
def gather_boundary(cuts, cut_weight, values, boundary):
    """The boundary term of each cut row: Σ weight · g over its cuts."""
    for r in range(boundary.shape[0]):
        for q in range(LANES):
            total = np.float32(0.0)
            for k in range(cuts.start[r], cuts.start[r + 1]):
                total += cut_weight[k] * values[k, q]
            boundary[r, q] = total


@njit(cache=True, nogil=True, fastmath=True)
def relax(first, last, offset, places, equation, on_floor, u, result):
    """Gauss–Seidel over nodes offset + first..last, of one colour, into u; or their residual.

    The residual is what `result` (n, 4) receives, unless it is empty; cut rows are scaled to the
    plain rows' diagonal. On the sliding plane values are multiplied by `on_floor` (4,), 0 for lanes
    that vanish there. Sums are written out, and indices unsigned, for the compiler to see that
    four lanes are one vector and no index is counted from the end.
    """
    node, around, site = places.node.view(np.uint32), places.around, places.site
    row, rows, boundary = equation.row, equation.rows, equation.boundary
    slot, source = equation.slot, equation.source
    wx, wy, wz = equation.axis_weights[0], equation.axis_weights[1], equation.axis_weights[2]
    diagonal = np.float32(2.0) * (wx + wy + wz) + equation.screening
    inverse, smoothing = np.float32(1.0) / diagonal, len(result) == 0
    for m in range(np.uint32(offset + first), np.uint32(offset + last)):
        s = np.int64(site[m])
        brick, local = s >> 9, s & 511
        # the same place in the brick beyond, where the neighbour is not in this one
        if s & 448:
            a = node[s - 64]
        else:
            a = node[512 * np.int64(around[brick, 4]) + local + 448]
        if (s & 448) < 448:
            b = node[s + 64]
        else:
            b = node[512 * np.int64(around[brick, 22]) + local - 448]
        if s & 56:
            c = node[s - 8]
        else:
            c = node[512 * np.int64(around[brick, 10]) + local + 56]
        if (s & 56) < 56:
            d = node[s + 8]
        else:
            d = node[512 * np.int64(around[brick, 16]) + local - 56]
        if s & 7:
            e = node[s - 1]
        elif around[brick, FLOOR] == 1:
            e = node[s + 1]
        else:
            e = node[512 * np.int64(around[brick, 12]) + local + 7]
        if (s & 7) < 7:
            g = node[s + 1]
        else:
            g = node[512 * np.int64(around[brick, 14]) + local - 7]
        r = row[m]
        own, scale = diagonal, inverse
        if r < 0:
            s0 = wx * (u[a, 0] + u[b, 0]) + wy * (u[c, 0] + u[d, 0]) + wz * (u[e, 0] + u[g, 0])
            s1 = wx * (u[a, 1] + u[b, 1]) + wy * (u[c, 1] + u[d, 1]) + wz * (u[e, 1] + u[g, 1])
            s2 = wx * (u[a, 2] + u[b, 2]) + wy * (u[c, 2] + u[d, 2]) + wz * (u[e, 2] + u[g, 2])
            s3 = wx * (u[a, 3] + u[b, 3]) + wy * (u[c, 3] + u[d, 3]) + wz * (u[e, 3] + u[g, 3])
        else:
            own = rows[r, 6]
            scale = np.float32(1.0) / own
            s0, s1, s2, s3 = boundary[r, 0], boundary[r, 1], boundary[r, 2], boundary[r, 3]
            s0 += rows[r, 0] * u[a, 0] + rows[r, 1] * u[b, 0] + rows[r, 2] * u[c, 0]
            s1 += rows[r, 0] * u[a, 1] + rows[r, 1] * u[b, 1] + rows[r, 2] * u[c, 1]
            s2 += rows[r, 0] * u[a, 2] + rows[r, 1] * u[b, 2] + rows[r, 2] * u[c, 2]
            s3 += rows[r, 0] * u[a, 3] + rows[r, 1] * u[b, 3] + rows[r, 2] * u[c, 3]
            s0 += rows[r, 3] * u[d, 0] + rows[r, 4] * u[e, 0] + rows[r, 5] * u[g, 0]
            s1 += rows[r, 3] * u[d, 1] + rows[r, 4] * u[e, 1] + rows[r, 5] * u[g, 1]
            s2 += rows[r, 3] * u[d, 2] + rows[r, 4] * u[e, 2] + rows[r, 5] * u[g, 2]
            s3 += rows[r, 3] * u[d, 3] + rows[r, 4] * u[e, 3] + rows[r, 5] * u[g, 3]
        if slot[brick] >= 0:
            f = 512 * np.int64(slot[brick]) + local
            s0 += source[f, 0]
            s1 += source[f, 1]
            s2 += source[f, 2]
            s3 += source[f, 3]
        if (s & 7) == 0 and around[brick, FLOOR] == 1:
            s0 *= on_floor[0]
            s1 *= on_floor[1]
            s2 *= on_floor[2]
            s3 *= on_floor[3]
        if smoothing:
            u[m, 0], u[m, 1], u[m, 2], u[m, 3] = scale * s0, scale * s1, scale * s2, scale * s3
        else:
            scale *= diagonal
            result[m, 0] = scale * (s0 - own * u[m, 0])
            result[m, 1] = scale * (s1 - own * u[m, 1])
            result[m, 2] = scale * (s2 - own * u[m, 2])
            result[m, 3] = scale * (s3 - own * u[m, 3])


@njit(cache=True, nogil=True)
def hold_floor(u, nodes, lanes):
    """Set the lanes that vanish on the sliding plane to zero there."""
    for i in range(nodes.shape[0]):
        for q in range(LANES):
            if lanes[q]:
                u[nodes[i], q] = 0.0
