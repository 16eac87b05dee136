"""Where the grid must be finer: what trilinear interpolation between the nodes would miss.

Trilinear interpolation misses ½ Σ_i t_i (1 - t_i) h² ∂_i²u at the place t in a cell. Its greatest
norm is at a corner of the cube t_i (1 - t_i) ∈ {0, ¼}³, so the indicator of a node is ⅛ of the
greatest |Σ_{i ∈ S} h² ∂_i²u| over the sets S of axes. (A harmonic field's three terms add up to 0:
half of the sum of their norms.) Octants of bricks (4³ cells) whose indicator is too large are
split. An octant can only be split when all octants around it are on its level, so that
interpolation from coarse to fine has the nodes it needs.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.solve.level import FLOOR, LOCAL, OFFSETS, Level, beside, node_at
from touchwarp.solve.multigrid import Stage
from touchwarp.solve.region import Region
from touchwarp.solve.stencil import LANES
from touchwarp.solve.threads import share

SMALL = 0.2
"""Second differences over crossings nearer than this are left to the other axes: they amplify the
discretisation error of the node itself."""


def indicate(
    stage: Stage,
    region: Region,
    lane_scale: NDArray[np.float32],
    normal_lanes: NDArray[np.bool_],
) -> NDArray[np.float32]:
    """(n_inner,) float32 m, the indicator of each inner node in Ω, 0 elsewhere.

    Args:
        stage, region: the level.
        lane_scale: (4,) weight of each lane, to metres; 0 leaves one out.
        normal_lanes: (4,) lanes that vanish on the sliding plane, and are odd across it.
    """
    level = stage.level
    value = np.zeros(level.n_inner, np.float32)
    given = level.places, stage.cuts, stage.cut_values, stage.u, region, lane_scale, normal_lanes
    share(_indicate_nodes, level.n_inner, *given, value, work=4)
    return value


def greatest_of_octants(level: Level, value: NDArray[np.float32]) -> NDArray[np.float32]:
    """(b, 8) the greatest value (n_inner,) in each octant; on a face of two it counts for both."""
    octants = np.zeros((len(level.bricks), 8), np.float32)
    share(_gather_octants, len(octants), level.places, level.has_cells, value, octants, work=LOCAL)
    return octants


@njit(cache=True, nogil=True)
def _indicate_nodes(
    first, last, places, cuts, cut_values, u, region, lane_scale, normal_lanes, value
):
    node, around, site = places.node, places.around, places.site
    row, start, direction, distance = cuts.row, cuts.start, cuts.direction, cuts.distance
    near, weight, difference = np.empty(6), np.empty(6), np.empty(3)
    beyond, crossing = np.empty(6, np.int64), np.empty(6, np.int64)
    for m in range(first, last):
        if region[m] != 1:
            continue
        on_floor = (site[m] & 7) == 0 and around[site[m] >> 9, FLOOR] == 1
        for d in range(6):
            beyond[d] = beside(node, around, site[m], d)
            near[d], weight[d], crossing[d] = 1.0, 1.0, -1
        r = row[m]
        if r >= 0:
            for k in range(start[r], start[r + 1]):
                near[direction[k]], crossing[direction[k]] = distance[k], k
            for d in range(6):
                both = near[d] * (near[d] + near[d ^ 1])
                weight[d] = 2.0 / both if min(near[d], near[d ^ 1]) >= SMALL else 0.0
        xx = yy = zz = xy = xz = yz = 0.0
        for q in range(LANES):
            for axis in range(3):
                total = 0.0
                for d in range(2 * axis, 2 * axis + 2):
                    k = crossing[d]
                    end = cut_values[k, q] if k >= 0 else u[beyond[d], q]
                    total += weight[d] * (end - u[m, q])
                difference[axis] = lane_scale[q] * total
            if on_floor and normal_lanes[q]:
                difference[2] = 0.0
            dx, dy, dz = difference[0], difference[1], difference[2]
            xx += dx * dx
            yy += dy * dy
            zz += dz * dz
            xy += dx * dy
            xz += dx * dz
            yz += dy * dz
        two = max(xx + yy + 2.0 * xy, xx + zz + 2.0 * xz, yy + zz + 2.0 * yz)
        three = xx + yy + zz + 2.0 * (xy + xz + yz)
        value[m] = np.sqrt(max(max(xx, yy, zz), max(two, three))) / 8.0


@njit(cache=True, nogil=True)
def _gather_octants(first, last, places, has_cells, value, octants):
    node, around = places.node, places.around
    for b in range(first, last):
        if not has_cells[b]:
            continue
        for octant in range(8):
            x0, y0, z0 = 4 * (octant >> 2), 4 * (octant >> 1 & 1), 4 * (octant & 1)
            greatest = np.float32(0.0)
            for i in range(125):
                m = node_at(node, around, b, x0 + i // 25, y0 + i // 5 % 5, z0 + i % 5)
                if 0 <= m < len(value):
                    greatest = max(greatest, value[m])
            octants[b, octant] = greatest


def octant_coordinates(stage: Stage, marked: NDArray[np.bool_]) -> NDArray[np.int64]:
    """(k, 3) of the marked octants (b, 8): also the coordinates of the finer level's bricks."""
    brick, octant = np.nonzero(marked & stage.level.has_cells[:, None])
    corner = np.stack([octant // 4, octant // 2 % 2, octant % 2], axis=1)
    return 2 * stage.level.bricks[brick].astype(np.int64) + corner


def widened(stage: Stage, octants: NDArray[np.int64], margin: int) -> NDArray[np.int64]:
    """The octants (k, 3) and all within `margin` octants of them, inside the grid."""
    shape = stage.level.cells // 4
    for _ in range(margin):
        octants = (octants[:, None] + OFFSETS).reshape(-1, 3)
        octants = octants[((octants >= 0) & (octants < shape)).all(axis=1)]
        octants = unique_rows(octants, shape)
    return octants


def unique_rows(rows: NDArray[np.int64], shape: NDArray[np.int64]) -> NDArray[np.int64]:
    """Distinct rows (k, 3) of coordinates below `shape`, sorted."""
    keys = np.unique((rows[:, 0] * shape[1] + rows[:, 1]) * shape[2] + rows[:, 2])
    return np.stack(
        [keys // (shape[1] * shape[2]), keys // shape[2] % shape[1], keys % shape[2]], axis=1
    )


def surrounded(stage: Stage, octants: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which octants (k, 3) have all octants around them on their level, or beyond the grid."""
    level = stage.level
    shape = level.cells // 4
    there = octants[:, None] + OFFSETS
    inside = ((there >= 0) & (there < shape)).all(axis=2)
    brick = level.index_of((there // 2).reshape(-1, 3)).reshape(inside.shape)
    return np.asarray((~inside | ((brick >= 0) & level.has_cells[brick])).all(axis=1))


def octant_of(local: NDArray[np.integer]) -> NDArray[np.int64]:
    """Octants, 4x + 2y + z, of local node or cell numbers 64x + 8y + z."""
    return np.asarray(4 * (local // 256) + 2 * (local // 32 % 2) + local // 4 % 2)
