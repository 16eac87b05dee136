"""Values just behind a surface: the field outside, continued through it.

A node behind a surface, beside a node in Ω, is where the table's cells that the surface crosses
need a value. The first guess is the parabola through the crossing (where u = g) and the second and
third node in Ω from it: the first may be too near to the crossing; or a line, where there are fewer
nodes.
"""

from __future__ import annotations

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from touchwarp.solve.cuts import cut_along
from touchwarp.solve.multigrid import Stage
from touchwarp.solve.region import Region


def extend_inwards(
    stage: Stage, region: Region, values: NDArray[np.float64], normal_lanes: NDArray[np.bool_]
) -> None:
    """Replace, in place, the values (n, 4) of the nodes behind surfaces, one node deep.

    The lanes that vanish on the sliding plane stay 0 there.
    """
    cuts, level = stage.cuts, stage.level
    known = np.zeros(level.n, np.bool_)
    before = values.copy()
    _extend(
        level.neighbours,
        cuts.row,
        cuts.start,
        cuts.direction,
        cuts.distance,
        stage.cut_values,
        region,
        before,
        values,
        known,
    )
    before = values.copy()
    _spread(level.neighbours, known, region, before, values)
    values[np.ix_(stage.floor, normal_lanes)] = 0.0


@njit(cache=True, parallel=True)
def _extend(neighbours, row, start, direction, distance, cut_values, region, u, values, known):
    n_inner = neighbours.shape[0]
    channels = values.shape[1]
    for m in prange(n_inner):
        if region[m] != 0 or row[m] < 0:
            continue
        count = 0
        for d in range(6):
            near = neighbours[m, d]
            if region[near] != 1:
                continue
            cut = cut_along(row, start, direction, near, d ^ 1)
            if cut < 0:
                continue
            at = 1.0 - distance[cut]
            far, farther = near, -1
            if near < n_inner and cut_along(row, start, direction, near, d) < 0:
                far = neighbours[near, d]
                if far < n_inner and cut_along(row, start, direction, far, d) < 0:
                    farther = neighbours[far, d]
            if count == 0:
                for q in range(channels):
                    values[m, q] = 0.0
            count += 1
            if farther >= 0:
                # Lagrange weights at 0 of points at `at`, 2 and 3.
                w2, w3 = -3.0 * at / (2.0 - at), 2.0 * at / (3.0 - at)
            else:
                w2, w3 = -at / max((1.0 if far == near else 2.0) - at, 0.5), 0.0
            for q in range(channels):
                g = cut_values[cut, q]
                values[m, q] += g + w2 * (u[far, q] - g)
                if farther >= 0:
                    values[m, q] += w3 * (u[farther, q] - g)
        if count:
            known[m] = True
            for q in range(channels):
                values[m, q] /= count


@njit(cache=True, parallel=True)
def _spread(neighbours, known, region, u, values):
    for m in prange(neighbours.shape[0]):
        if known[m] or region[m] != 0:
            continue
        count = 0
        for d in range(6):
            k = neighbours[m, d]
            if k < neighbours.shape[0] and known[k]:
                if count == 0:
                    for q in range(values.shape[1]):
                        values[m, q] = 0.0
                count += 1
                for q in range(values.shape[1]):
                    values[m, q] += u[k, q]
        if count:
            for q in range(values.shape[1]):
                values[m, q] /= count
