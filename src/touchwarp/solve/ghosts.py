"""Values just behind a surface: the field outside, continued through it.

A node behind a surface, beside a node in Ω, is where the table's cells that the surface crosses
need a value. The first guess is the parabola through the crossing (where u = g) and the second and
third node in Ω from it: the first may be too near to the crossing; or a line, where there are fewer
nodes.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.solve.cuts import cut_along
from touchwarp.solve.level import beside
from touchwarp.solve.multigrid import Lanes, Stage
from touchwarp.solve.region import Region
from touchwarp.solve.stencil import LANES
from touchwarp.solve.threads import share


def extended_inwards(stage: Stage, region: Region, normal_lanes: NDArray[np.bool_]) -> Lanes:
    """(n, 4) u, but for the nodes behind surfaces, which are continued from Ω, one node deep.

    The lanes that vanish on the sliding plane stay 0 there.
    """
    n = stage.level.n_inner
    values = stage.u.copy()
    known = np.zeros(stage.level.n, np.bool_)
    places = stage.level.places
    share(_extend, n, places, stage.cuts, stage.cut_values, region, stage.u, values, known)
    share(_spread, n, places, known, region, values)
    values[np.ix_(stage.floor, normal_lanes)] = 0.0
    return values


@njit(cache=True, nogil=True)
def _extend(first, last, places, cuts, cut_values, region, u, values, known):
    node, around, site, n_inner = places.node, places.around, places.site, places.n_inner
    row, start, direction, distance = cuts.row, cuts.start, cuts.direction, cuts.distance
    for m in range(first, last):
        if region[m] != 0 or row[m] < 0:
            continue
        count = 0
        for d in range(6):
            near = beside(node, around, site[m], d)
            if region[near] != 1:
                continue
            cut = cut_along(row, start, direction, near, d ^ 1)
            if cut < 0:
                continue
            at = 1.0 - distance[cut]
            far, farther = near, -1
            if near < n_inner and cut_along(row, start, direction, near, d) < 0:
                far = beside(node, around, site[near], d)
                if far < n_inner and cut_along(row, start, direction, far, d) < 0:
                    farther = beside(node, around, site[far], d)
            if count == 0:
                for q in range(LANES):
                    values[m, q] = 0.0
            count += 1
            # Weights at 0 of the crossing and of points at 2 and 3, or of what there is of them.
            w2, w3 = -at / max((1.0 if far == near else 2.0) - at, 0.5), 0.0
            if farther >= 0:
                w2, w3 = -3.0 * at / (2.0 - at), 2.0 * at / (3.0 - at)
            for q in range(LANES):
                g = cut_values[cut, q]
                values[m, q] += g + w2 * (u[far, q] - g)
                if farther >= 0:
                    values[m, q] += w3 * (u[farther, q] - g)
        if count:
            known[m] = True
            for q in range(LANES):
                values[m, q] /= count


@njit(cache=True, nogil=True)
def _spread(first, last, places, known, region, values):
    """Nodes behind surfaces that see no crossing take the mean of those beside them that do."""
    node, around, site = places.node, places.around, places.site
    for m in range(first, last):
        if known[m] or region[m] != 0:
            continue
        count = 0
        for d in range(6):
            k = beside(node, around, site[m], d)
            if known[k]:
                for q in range(LANES):
                    own = values[m, q] if count else np.float32(0.0)
                    values[m, q] = own + values[k, q]
                count += 1
        if count:
            for q in range(LANES):
                values[m, q] /= count
