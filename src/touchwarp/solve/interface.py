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
from numba import njit
from numpy.typing import NDArray

from touchwarp.solve.cuts import Cuts
from touchwarp.solve.interface_stencil import expand_rim
from touchwarp.solve.level import FLOOR, Level, node_at, octant_start
from touchwarp.solve.stencil import LANES
from touchwarp.solve.threads import share

TERMS = np.array([1, 4, 16, 0])
FINE_TERMS = np.array([0, 0, 4, 0])
"""The most terms of a rim node, by the number of its odd coordinates."""

ON_BOX, PLAIN, BESIDE_SURFACE = 0, 1, 2
"""Kinds of rim nodes."""

CUBIC = np.array([[0.0, 16.0, 0.0, 0.0], [-1.0, 9.0, 9.0, -1.0]], np.float32) / 16
"""Weights of four coarse nodes along a line: for the second of them, and for the middle."""


@dataclass(eq=False)
class Interface:
    """Rim values: the plain cubic where no surface is near, sums over nodes and cuts elsewhere.

    Attributes:
        plain: (p,) int32, the fine rim nodes that are cubic.
        rim: (k,) int32, all others that are interpolated.
        start: (k + 1,) int64, length: (k,), each one's terms in `source` and `weight`.
        source: (t,) int32, a coarse node, or -1 - cut for a coarse cut.
        fine_start, fine_length, fine_cut, fine_weight: the same for terms that are fine cuts.
        weight: (t,) float32.
    """

    plain: NDArray[np.int32]
    rim: NDArray[np.int32]
    start: NDArray[np.int64]
    length: NDArray[np.int32]
    source: NDArray[np.int32]
    weight: NDArray[np.float32]
    fine_start: NDArray[np.int64]
    fine_length: NDArray[np.int32]
    fine_cut: NDArray[np.int32]
    fine_weight: NDArray[np.float32]

    @property
    def nodes(self) -> NDArray[np.int32]:
        """All rim nodes that are interpolated."""
        return np.concatenate([self.plain, self.rim])


def make_interface(fine: Level, fine_cuts: Cuts, coarse: Level, coarse_cuts: Cuts) -> Interface:
    """How the rim of `fine` follows from `coarse`; the rim on the outer box stays 0."""
    kind = np.empty(fine.n - fine.n_inner, np.int8)
    places = fine.places, coarse.places
    given = *places, fine.cells, fine_cuts.row, coarse_cuts.row
    share(_classify_rim, len(kind), *given, kind, work=16, even=True)
    plain, rim = (
        (fine.n_inner + np.flatnonzero(kind == k)).astype(np.int32) for k in (PLAIN, BESIDE_SURFACE)
    )
    site = fine.site[rim]
    odd = (site >> 6 & 1) + (site >> 3 & 1) + (site & 1)
    start = np.concatenate([[0], np.cumsum(TERMS[odd])])
    fine_start = np.concatenate([[0], np.cumsum(FINE_TERMS[odd])])
    result = Interface(
        plain,
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
    terms = start, result.length, result.source, result.weight
    fine_terms = fine_start, result.fine_length, result.fine_cut, result.fine_weight
    share(expand_rim, len(rim), rim, *places, fine_cuts, coarse_cuts, *terms, *fine_terms, work=100)
    return result


@njit(cache=True, nogil=True)
def _classify_rim(first, last, fine, coarse, cells, fine_row, coarse_row, kind):
    """Which rim nodes n_inner + first..last lie on the outer box, are cubic, or beside a surface.

    They are cubic where all coarse nodes are there and no surface cuts their edges.
    """
    bricks, parent, site = fine.bricks, fine.parent, fine.site
    node, around = fine.node, fine.around
    coarse_node, coarse_around = coarse.node, coarse.around
    for n in range(first, last):
        s = np.int64(site[fine.n_inner + n])
        b, x, y, z = s >> 9, (s >> 6) & 7, (s >> 3) & 7, s & 7
        on_floor = z == 0 and around[b, FLOOR] == 1
        on_box = False
        for axis in range(3):
            at = 8 * bricks[b, axis] + (x if axis == 0 else y if axis == 1 else z)
            on_box |= at == cells[axis] or (at == 0 and not (axis == 2 and on_floor))
        if on_box:
            kind[n] = ON_BOX
            continue
        start, p = octant_start(bricks, b), np.int64(parent[b])
        x0, y0, z0 = (start >> 6) + (x >> 1), ((start >> 3) & 7) + (y >> 1), (start & 7) + (z >> 1)
        # the cubic would reach under a sliding plane, where there are no nodes of their own
        whole = not (z == 1 and around[b, FLOOR] == 1)
        for i in range(-(x & 1), 1 + 2 * (x & 1)):
            for j in range(-(y & 1), 1 + 2 * (y & 1)):
                for k in range(-(z & 1), 1 + 2 * (z & 1)):
                    c = node_at(coarse_node, coarse_around, p, x0 + i, y0 + j, z0 + k)
                    whole = whole and c >= 0 and coarse_row[c] < 0
        for axis in range(3):
            for step in range(-2, 3):
                dx, dy, dz = step * (axis == 0), step * (axis == 1), step * (axis == 2)
                near = node_at(node, around, b, x + dx, y + dy, z + dz)
                whole = whole and (near < 0 or fine_row[near] < 0)
        kind[n] = PLAIN if whole else BESIDE_SURFACE


@njit(cache=True, nogil=True)
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
    for i in range(constant.shape[0]):
        for q in range(LANES):
            total = np.float32(0.0)
            for k in range(start[i], start[i] + length[i]):
                if source[k] < 0:
                    total += weight[k] * coarse_values[-1 - source[k], q]
            for k in range(fine_start[i], fine_start[i] + fine_length[i]):
                total += fine_weight[k] * fine_values[fine_cut[k], q]
            constant[i, q] = total


@njit(cache=True, nogil=True, fastmath=True)
def set_plain_rim(first, last, plain, fine, coarse, coarse_u, fine_u):
    """Rim values of the fine level from the coarse one, where no surface is near."""
    bricks, parent, site = fine.bricks, fine.parent, fine.site
    node, around = coarse.node, coarse.around
    for n in range(first, last):
        m = plain[n]
        b, local = site[m] >> 9, site[m] & 511
        x, y, z = local >> 6, (local >> 3) & 7, local & 7
        start, p = octant_start(bricks, b), np.int64(parent[b])
        x0, y0, z0 = (start >> 6) + (x >> 1), ((start >> 3) & 7) + (y >> 1), (start & 7) + (z >> 1)
        x, y, z = x & 1, y & 1, z & 1
        s0 = s1 = s2 = s3 = np.float32(0.0)
        for i in range(1 - x, 2 + 2 * x):
            for j in range(1 - y, 2 + 2 * y):
                for k in range(1 - z, 2 + 2 * z):
                    w = CUBIC[x, i] * CUBIC[y, j] * CUBIC[z, k]
                    c = node_at(node, around, p, x0 + i - 1, y0 + j - 1, z0 + k - 1)
                    s0 += w * coarse_u[c, 0]
                    s1 += w * coarse_u[c, 1]
                    s2 += w * coarse_u[c, 2]
                    s3 += w * coarse_u[c, 3]
        fine_u[m, 0], fine_u[m, 1], fine_u[m, 2], fine_u[m, 3] = s0, s1, s2, s3


@njit(cache=True, nogil=True, fastmath=True)
def set_rim(first, last, rim, start, length, source, weight, constant, coarse_u, fine_u):
    """Rim values of the fine level from the coarse one, beside surfaces."""
    for i in range(first, last):
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
    fine: Level, coarse: Level, nodes: NDArray[np.integer], values: NDArray[np.float32]
) -> NDArray[np.float32]:
    """(k, 4): the trilinear interpolant of coarse node values (n, 4) at nodes of the finer level.

    The solver's own rim is cubic; a table whose fine bricks meet coarse ones must be trilinear
    there.
    """
    result = np.empty((len(nodes), values.shape[1]), np.float32)
    share(_hang, len(nodes), nodes, fine.places, coarse.places, values, result, work=4)
    return result


@njit(cache=True, nogil=True)
def _hang(first, last, nodes, fine, coarse, values, result):
    bricks, parent, site = fine.bricks, fine.parent, fine.site
    node, around = coarse.node, coarse.around
    for n in range(first, last):
        b, local = site[nodes[n]] >> 9, site[nodes[n]] & 511
        x, y, z = local >> 6, (local >> 3) & 7, local & 7
        start, p = octant_start(bricks, b), np.int64(parent[b])
        x0, y0, z0 = (start >> 6) + (x >> 1), ((start >> 3) & 7) + (y >> 1), (start & 7) + (z >> 1)
        # up to eight nodes; even coordinates name the same one twice
        for q in range(values.shape[1]):
            total = 0.0
            for k in range(8):
                i, j, k = (k >> 2) & x, (k >> 1) & y & 1, k & z & 1
                total += values[node_at(node, around, p, x0 + i, y0 + j, z0 + k), q]
            result[n, q] = 0.125 * total
