"""Where the table must meet the goal: samples of the surfaces, spread evenly over each cell.

A triangle is sampled on a fixed lattice, finer than the cells, in the plane of the two axes that it
faces most; so samples are even whatever the triangles' sizes, and each stands for its own area.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from touchwarp.solve.boundary import Boundary
from touchwarp.solve.level import node_at
from touchwarp.solve.multigrid import Stage

PER_CELL = 3
"""Samples along a cell's side, for the fit."""


@dataclass(eq=False)
class Samples:
    """Surface samples in the cells of one level that no finer level covers, sorted by cell.

    Attributes:
        cell: (s,) int64, 512 · brick + 64x + 8y + z.
        place: (s, 3) float32, position in the cell, 0..1.
        weight: (s,) float32, area in units of a cell's face.
        triangle: (s,) int32; barycentric: (s, 2) float32, weights of its first two corners.
    """

    cell: NDArray[np.int64]
    place: NDArray[np.float32]
    weight: NDArray[np.float32]
    triangle: NDArray[np.int32]
    barycentric: NDArray[np.float32]


def sample_surfaces(
    stage: Stage, boundary: Boundary, leaf: NDArray[np.bool_], per_cell: int = PER_CELL
) -> Samples:
    """Samples of all surfaces in the cells of the octants (b, 8) that are chosen.

    There are `per_cell` along a cell's side.
    """
    level = stage.level
    start = np.zeros(len(level.bricks) + 1, np.int64)
    scale = 2.0**level.depth
    fixed = (
        level.bricks,
        leaf,
        boundary.corners,
        boundary.faces,
        scale,
        per_cell,
        stage.triangles.start,
        stage.triangles.index,
    )
    empty = Samples(
        np.empty(0, np.int64),
        np.empty((0, 3), np.float32),
        np.empty(0, np.float32),
        np.empty(0, np.int32),
        np.empty((0, 2), np.float32),
    )
    _sample(*fixed, start, empty.cell, empty.place, empty.weight, empty.triangle, empty.barycentric)
    np.cumsum(start, out=start)
    n = int(start[-1])
    if n == 0:
        return empty
    s = Samples(
        np.empty(n, np.int64),
        np.empty((n, 3), np.float32),
        np.empty(n, np.float32),
        np.empty(n, np.int32),
        np.empty((n, 2), np.float32),
    )
    _sample(*fixed, start, s.cell, s.place, s.weight, s.triangle, s.barycentric)
    order = np.argsort(s.cell, kind="stable")
    return Samples(
        s.cell[order], s.place[order], s.weight[order], s.triangle[order], s.barycentric[order]
    )


def goal_at_samples(
    samples: Samples, boundary: Boundary, data: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(s, C): boundary data (v, C) at samples."""
    corner = boundary.faces[samples.triangle]
    weight = samples.barycentric.astype(np.float64)
    last = data[corner[:, 2]]
    values = last + weight[:, :1] * (data[corner[:, 0]] - last)
    values += weight[:, 1:] * (data[corner[:, 1]] - last)
    return np.asarray(values)


def sample_points(stage: Stage, samples: Samples) -> NDArray[np.float64]:
    """(s, 3) root-grid coordinates of samples."""
    brick, local = np.divmod(samples.cell, 512)
    corner = np.stack([local // 64, local // 8 % 8, local % 8], axis=1)
    where = stage.level.bricks[brick] * 8.0 + corner + samples.place
    return np.asarray(where / 2.0**stage.level.depth)


def misfit(
    stage: Stage,
    samples: Samples,
    goal: NDArray[np.float64],
    values: NDArray[np.float64],
    lane_scale: NDArray[np.float32],
) -> NDArray[np.float64]:
    """(s,) m: |trilinear interpolant of the node values (n, 4) - goal (s, 4)|, lanes weighted."""
    level = stage.level
    result = np.empty(len(samples.cell))
    _misfit(
        samples.cell,
        samples.place,
        level.node,
        level.around,
        goal,
        values,
        lane_scale.astype(np.float64),
        result,
    )
    return result


@njit(cache=True, parallel=True)
def _sample(
    bricks,
    leaf,
    corners,
    faces,
    scale,
    per_cell,
    tri_start,
    tri_index,
    start,
    out_cell,
    out_place,
    out_weight,
    out_triangle,
    out_barycentric,
):
    counting = out_cell.shape[0] == 0
    pitch = 1.0 / per_cell
    for brick in prange(bricks.shape[0]):
        if tri_start[brick] == tri_start[brick + 1] or not leaf[brick].any():
            continue
        p = np.empty((3, 3))
        count = 0
        for t in range(tri_start[brick], tri_start[brick + 1]):
            triangle = tri_index[t]
            for v in range(3):
                for d in range(3):
                    p[v, d] = corners[faces[triangle, v], d] * scale - 8.0 * bricks[brick, d]
            normal = np.cross(p[1] - p[0], p[2] - p[0])
            axis = np.argmax(np.abs(normal))
            if abs(normal[axis]) < 1e-14:
                continue
            b, c = (axis + 1) % 3, (axis + 2) % 3
            area = normal[axis]
            weight = pitch * pitch * np.sqrt((normal * normal).sum()) / abs(area)
            first_b = max(int(np.ceil(p[:, b].min() * per_cell - 0.5)), 0)
            last_b = min(int(np.floor(p[:, b].max() * per_cell - 0.5)), 8 * per_cell - 1)
            first_c = max(int(np.ceil(p[:, c].min() * per_cell - 0.5)), 0)
            last_c = min(int(np.floor(p[:, c].max() * per_cell - 0.5)), 8 * per_cell - 1)
            at = np.empty(3)
            for i in range(first_b, last_b + 1):
                for j in range(first_c, last_c + 1):
                    at[b], at[c] = (i + 0.5) * pitch, (j + 0.5) * pitch
                    w0 = (
                        (p[1, b] - at[b]) * (p[2, c] - at[c])
                        - (p[2, b] - at[b]) * (p[1, c] - at[c])
                    ) / area
                    w1 = (
                        (p[2, b] - at[b]) * (p[0, c] - at[c])
                        - (p[0, b] - at[b]) * (p[2, c] - at[c])
                    ) / area
                    w2 = 1.0 - w0 - w1
                    if w0 < 0.0 or w1 < 0.0 or w2 < 0.0:
                        continue
                    at[axis] = w0 * p[0, axis] + w1 * p[1, axis] + w2 * p[2, axis]
                    if at[axis] < 0.0 or at[axis] >= 8.0:
                        continue
                    x, y, z = int(at[0]), int(at[1]), int(at[2])
                    if not leaf[brick, 4 * (x // 4) + 2 * (y // 4) + z // 4]:
                        continue
                    if not counting:
                        k = start[brick] + count
                        out_cell[k] = 512 * brick + 64 * x + 8 * y + z
                        out_place[k, 0], out_place[k, 1] = at[0] - x, at[1] - y
                        out_place[k, 2] = at[2] - z
                        out_weight[k] = weight
                        out_triangle[k] = triangle
                        out_barycentric[k, 0], out_barycentric[k, 1] = w0, w1
                    count += 1
        if counting:
            start[brick + 1] = count


@njit(cache=True, parallel=True)
def _misfit(cell, place, node, around, goal, values, lane_scale, result):
    for s in prange(len(cell)):
        b, local = cell[s] // 512, cell[s] % 512
        x, y, z = local // 64, local // 8 % 8, local % 8
        gap = goal[s].copy()
        for c in range(8):
            weight = (
                (place[s, 0] if c >> 2 else 1.0 - place[s, 0])
                * (place[s, 1] if c >> 1 & 1 else 1.0 - place[s, 1])
                * (place[s, 2] if c & 1 else 1.0 - place[s, 2])
            )
            m = node_at(node, around, False, b, x + (c >> 2), y + (c >> 1 & 1), z + (c & 1))
            if m >= 0:
                for q in range(len(gap)):
                    gap[q] -= weight * values[m, q]
        square = 0.0
        for q in range(len(gap)):
            square += (lane_scale[q] * gap[q]) ** 2
        result[s] = np.sqrt(square)
