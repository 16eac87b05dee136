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
from numba import njit, prange
from numpy.typing import NDArray

from touchwarp.solve.level import OFFSETS, node_at
from touchwarp.solve.multigrid import Stage
from touchwarp.solve.region import Region

SMALL = 0.2
"""Second differences over crossings nearer than this are left to the other axes: they amplify the
discretisation error of the node itself."""


def indicate(
    stage: Stage,
    region: Region,
    lane_scale: NDArray[np.float32],
    normal_lanes: NDArray[np.bool_],
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """The indicator of each inner node in Ω, 0 elsewhere, and the greatest of each octant's.

    Args:
        stage, region: the level.
        lane_scale: (4,) weight of each lane, to metres; 0 leaves one out.
        normal_lanes: (4,) lanes that vanish on the sliding plane, and are odd across it.

    Returns:
        (n_inner,) and (b, 8) float32 m. Nodes on the face of two octants count for both.
    """
    level, cuts = stage.level, stage.cuts
    value = np.zeros(level.n_inner, np.float32)
    on_floor = np.zeros(level.n_inner, np.bool_)
    on_floor[stage.floor[stage.floor < level.n_inner]] = True
    _indicate_nodes(
        level.neighbours,
        cuts.row,
        cuts.start,
        cuts.direction,
        cuts.distance,
        stage.cut_values,
        stage.u,
        region,
        lane_scale,
        on_floor,
        normal_lanes,
        value,
    )
    octants = np.zeros((len(level.bricks), 8), np.float32)
    _gather_octants(level.node, level.around, level.has_cells, value, octants)
    return value, octants


@njit(cache=True)
def _cut_difference(m, axis, neighbours, cuts, u, q):
    """h² ∂²u along an axis at a node with crossings; 0 where one is too near."""
    first, end, direction, distance, cut_values = cuts
    near_minus, near_plus = 1.0, 1.0
    minus, plus = u[neighbours[m, 2 * axis], q], u[neighbours[m, 2 * axis + 1], q]
    for k in range(first, end):
        if direction[k] == 2 * axis:
            near_minus, minus = distance[k], cut_values[k, q]
        elif direction[k] == 2 * axis + 1:
            near_plus, plus = distance[k], cut_values[k, q]
    if near_minus < SMALL or near_plus < SMALL:
        return 0.0
    both = near_minus + near_plus
    return 2.0 * ((minus - u[m, q]) / (near_minus * both) + (plus - u[m, q]) / (near_plus * both))


@njit(cache=True, parallel=True)
def _indicate_nodes(
    neighbours,
    row,
    start,
    direction,
    distance,
    cut_values,
    u,
    region,
    lane_scale,
    on_floor,
    normal_lanes,
    value,
):
    for m in prange(len(value)):
        if region[m] != 1:
            continue
        xx = yy = zz = xy = xz = yz = 0.0
        for q in range(4):
            if row[m] < 0:
                twice = 2.0 * u[m, q]
                x = u[neighbours[m, 0], q] + u[neighbours[m, 1], q] - twice
                y = u[neighbours[m, 2], q] + u[neighbours[m, 3], q] - twice
                z = u[neighbours[m, 4], q] + u[neighbours[m, 5], q] - twice
            else:
                cuts = start[row[m]], start[row[m] + 1], direction, distance, cut_values
                x = _cut_difference(m, 0, neighbours, cuts, u, q)
                y = _cut_difference(m, 1, neighbours, cuts, u, q)
                z = _cut_difference(m, 2, neighbours, cuts, u, q)
            if on_floor[m] and normal_lanes[q]:
                z = 0.0
            weight = lane_scale[q] * lane_scale[q]
            xx += weight * x * x
            yy += weight * y * y
            zz += weight * z * z
            xy += weight * x * y
            xz += weight * x * z
            yz += weight * y * z
        two = max(xx + yy + 2.0 * xy, xx + zz + 2.0 * xz, yy + zz + 2.0 * yz)
        three = xx + yy + zz + 2.0 * (xy + xz + yz)
        value[m] = np.sqrt(max(xx, yy, zz, two, three)) / 8.0


@njit(cache=True, parallel=True)
def _gather_octants(node, around, has_cells, value, octants):
    for b in prange(len(node)):
        if not has_cells[b]:
            continue
        for x in range(9):
            for y in range(9):
                for z in range(9):
                    m = node_at(node, around, False, b, x, y, z)
                    if m < 0 or m >= len(value):
                        continue
                    for side in range(8):
                        i, j, k = side >> 2, side >> 1 & 1, side & 1
                        if 0 <= x - 4 * i <= 4 and 0 <= y - 4 * j <= 4 and 0 <= z - 4 * k <= 4:
                            octants[b, side] = max(octants[b, side], value[m])


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
