"""Values on the rim of a refined level: cubic from the coarser level, never through a surface.

A rim node lies on a coarse node, on the middle of a coarse edge or on the middle of a coarse face.
Along a line, its value is the Lagrange polynomial through up to four points at coarse distance;
where a surface cuts the line, the crossing (where u = g is known) takes the place of the points
behind it. So the stencil is linear in u and g, third or fourth order on both sides of every wall,
and cubic away from walls: linear interpolation there costs an order of accuracy.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from touchwarp.solve.cuts import Cuts
from touchwarp.solve.interface_stencil import expand_rim
from touchwarp.solve.level import Level, node_at
from touchwarp.solve.stencil import LANES

TERMS = np.array([1, 4, 16, 0])
FINE_TERMS = np.array([0, 0, 4, 0])
"""The most terms of a rim node, by the number of its odd coordinates."""


@dataclass(eq=False)
class Interface:
    """Rim values as sums over coarse nodes and over cuts.

    Attributes:
        rim: (k,) int32, the fine rim nodes that are interpolated.
        start: (k + 1,) int64, length: (k,), each one's terms in `source` and `weight`.
        source: (t,) int32, a coarse node, or -1 - cut for a coarse cut.
        fine_start, fine_length, fine_cut, fine_weight: the same for terms that are fine cuts.
        weight: (t,) float32.
    """

    rim: NDArray[np.int32]
    start: NDArray[np.int64]
    length: NDArray[np.int32]
    source: NDArray[np.int32]
    weight: NDArray[np.float32]
    fine_start: NDArray[np.int64]
    fine_length: NDArray[np.int32]
    fine_cut: NDArray[np.int32]
    fine_weight: NDArray[np.float32]


def make_interface(fine: Level, fine_cuts: Cuts, coarse: Level, coarse_cuts: Cuts) -> Interface:
    """How the rim of `fine` follows from `coarse`; the rim on the outer box stays 0."""
    where = fine.coordinates(slice(fine.n_inner, None))
    on_box = (where == 0) | (where == fine.cells)
    if fine.mirrored:
        on_box[:, 2] &= where[:, 2] != 0
    rim = (fine.n_inner + np.flatnonzero(~on_box.any(axis=1))).astype(np.int32)
    odd = (where[rim - fine.n_inner] & 1).sum(axis=1)
    start = np.concatenate([[0], np.cumsum(TERMS[odd])])
    fine_start = np.concatenate([[0], np.cumsum(FINE_TERMS[odd])])
    result = Interface(
        rim,
        start,
        np.zeros(len(rim), np.int32),
        np.empty(start[-1], np.int32),
        np.empty(start[-1], np.float32),
        fine_start,
        np.zeros(len(rim), np.int32),
        np.empty(fine_start[-1], np.int32),
        np.empty(fine_start[-1], np.float32),
    )
    expand_rim(
        rim,
        fine.site,
        fine.bricks,
        fine.parent,
        fine.node,
        fine.around,
        fine_cuts.row,
        fine_cuts.start,
        fine_cuts.direction,
        fine_cuts.distance,
        coarse.node,
        coarse.around,
        coarse.bricks,
        fine.mirrored,
        coarse_cuts.row,
        coarse_cuts.start,
        coarse_cuts.direction,
        coarse_cuts.distance,
        start,
        result.length,
        result.source,
        result.weight,
        fine_start,
        result.fine_length,
        result.fine_cut,
        result.fine_weight,
    )
    return result


@njit(cache=True, parallel=True)
def interface_constants(
    start,
    length,
    source,
    weight,
    coarse_values,
    fine_start,
    fine_length,
    fine_cut,
    fine_weight,
    fine_values,
    constant,
):
    """The part of the rim values that comes from g at cuts."""
    for i in prange(constant.shape[0]):
        for q in range(LANES):
            total = np.float32(0.0)
            for k in range(start[i], start[i] + length[i]):
                if source[k] < 0:
                    total += weight[k] * coarse_values[-1 - source[k], q]
            for k in range(fine_start[i], fine_start[i] + fine_length[i]):
                total += fine_weight[k] * fine_values[fine_cut[k], q]
            constant[i, q] = total


@njit(cache=True, parallel=True, fastmath=True)
def set_rim(fine_u, coarse_u, rim, start, length, source, weight, constant):
    """Rim values of the fine level from the coarse one."""
    for i in prange(rim.shape[0]):
        s0, s1, s2, s3 = constant[i, 0], constant[i, 1], constant[i, 2], constant[i, 3]
        for k in range(start[i], start[i] + length[i]):
            c = source[k]
            if c >= 0:
                w = weight[k]
                s0 += w * coarse_u[c, 0]
                s1 += w * coarse_u[c, 1]
                s2 += w * coarse_u[c, 2]
                s3 += w * coarse_u[c, 3]
        m = rim[i]
        fine_u[m, 0], fine_u[m, 1], fine_u[m, 2], fine_u[m, 3] = s0, s1, s2, s3


def hanging_values(
    fine: Level, coarse: Level, nodes: NDArray[np.integer], values: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(k, C): the trilinear interpolant of coarse node values (n, C) at nodes of the finer level.

    The solver's own rim is cubic; a table whose fine bricks meet coarse ones must be trilinear
    there.
    """
    result = np.empty((len(nodes), values.shape[1]))
    _hang(nodes, fine.site, fine.bricks, fine.parent, coarse.node, coarse.around, values, result)
    return result


@njit(cache=True, parallel=True)
def _hang(nodes, site, bricks, parent, coarse_node, coarse_around, coarse, result):
    for i in prange(nodes.shape[0]):
        b, local = site[nodes[i]] // 512, site[nodes[i]] % 512
        x, y, z = local // 64, local // 8 % 8, local % 8
        x0 = 4 * (bricks[b, 0] & 1) + x // 2
        y0 = 4 * (bricks[b, 1] & 1) + y // 2
        z0 = 4 * (bricks[b, 2] & 1) + z // 2
        weight = 1.0 / ((1 + (x & 1)) * (1 + (y & 1)) * (1 + (z & 1)))
        for q in range(result.shape[1]):
            total = 0.0
            for dx in range(1 + (x & 1)):
                for dy in range(1 + (y & 1)):
                    for dz in range(1 + (z & 1)):
                        c = node_at(
                            coarse_node, coarse_around, False, parent[b], x0 + dx, y0 + dy, z0 + dz
                        )
                        total += coarse[c, q]
            result[i, q] = weight * total
