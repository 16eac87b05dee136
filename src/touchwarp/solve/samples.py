"""Where the table must meet the goal: samples of the surfaces, spread evenly over each cell.

A triangle is sampled on a fixed lattice, finer than the cells, in the plane of the two axes that it
faces most; so samples are even whatever the triangles' sizes, and each stands for its own area.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.solve.blend import Blend, Terms, Yielding
from touchwarp.solve.boundary import Boundary
from touchwarp.solve.level import LOCAL, node_at
from touchwarp.solve.multigrid import Lanes, Stage
from touchwarp.solve.stencil import LANES
from touchwarp.solve.threads import share

PER_CELL = 3
"""Samples along a cell's side, for the fit."""


@dataclass(eq=False)
class Samples:
    """Surface samples in the cells of one level that no finer level covers, sorted by cell.

    Attributes:
        cell: (s,) int32, 512 · brick + 64x + 8y + z.
        place: (s, 3) float32, position in the cell, 0..1.
        weight: (s,) float32, area in units of a cell's face.
        triangle: (s,) int32; barycentric: (s, 2) float32, weights of its first two corners.
    """

    cell: NDArray[np.int32]
    place: NDArray[np.float32]
    weight: NDArray[np.float32]
    triangle: NDArray[np.int32]
    barycentric: NDArray[np.float32]

    @classmethod
    def empty(cls, count: int) -> Samples:
        """Room for so many."""
        return cls(
            np.empty(count, np.int32),
            np.empty((count, 3), np.float32),
            np.empty(count, np.float32),
            np.empty(count, np.int32),
            np.empty((count, 2), np.float32),
        )


def sample_surfaces(
    stage: Stage, boundary: Boundary, leaf: NDArray[np.bool_], per_cell: int = PER_CELL
) -> Samples:
    """Samples of all surfaces in the cells of the octants (b, 8) that are chosen.

    There are `per_cell` along a cell's side.
    """
    level, lists = stage.level, stage.triangles
    bricks = np.flatnonzero((np.diff(lists.start) > 0) & leaf.any(axis=1)).astype(np.int32)
    scale = 2.0**level.depth
    surfaces = boundary.corners, boundary.faces, scale, lists.start, lists.index
    start = np.zeros(LOCAL * len(bricks) + 1, np.int64)

    def fill(s: Samples) -> None:
        out = s.cell, s.place, s.weight, s.triangle, s.barycentric
        share(
            _sample,
            len(bricks),
            bricks,
            level.bricks,
            leaf,
            *surfaces,
            per_cell,
            start,
            *out,
            work=LOCAL,
        )

    fill(Samples.empty(0))
    np.cumsum(start, out=start)
    samples = Samples.empty(int(start[-1]))
    if len(samples.cell):
        fill(samples)
    return samples


def goal_at_samples(samples: Samples, boundary: Boundary, data: NDArray[np.float64]) -> Lanes:
    """(s, 4): boundary data (v, 4) at samples."""
    values = np.empty((len(samples.cell), LANES), np.float32)
    given = samples.triangle, samples.barycentric, boundary.faces, data
    share(_goal, len(values), *given, values, even=True)
    return values


def sample_points(
    stage: Stage, samples: Samples, which: NDArray[np.bool_] | slice = slice(None)
) -> NDArray[np.float64]:
    """(k, 3) root-grid coordinates of samples (all without `which`)."""
    cell = samples.cell[which]
    where = stage.level.bricks[cell >> 9] * 8.0 + samples.place[which]
    for axis, shift in enumerate((6, 3, 0)):
        where[:, axis] += (cell >> shift) & 7
    return np.asarray(where / 2.0**stage.level.depth)


def yielding_samples(stage: Stage, samples: Samples, blend: Blend) -> Yielding:
    """What gives way at samples."""

    def find() -> list[Terms]:
        owner = blend.boundary.owner[samples.triangle]
        return blend.terms(sample_points(stage, samples), owner)

    return Yielding(blend, find)


def misfit(
    stage: Stage, samples: Samples, goal: Lanes, values: Lanes, lane_scale: NDArray[np.float32]
) -> NDArray[np.float32]:
    """(s,) m: |trilinear interpolant of the node values (n, 4) - goal (s, 4)|, lanes weighted."""
    result = np.empty(len(samples.cell), np.float32)
    given = samples.cell, samples.place, stage.level.places, goal, values, lane_scale
    share(_misfit, len(result), *given, result, work=8, even=True)
    return result


@njit(cache=True, nogil=True)
def _sample(
    first,
    last,
    bricks,
    corner_of,
    leaf,
    corners,
    faces,
    scale,
    tri_start,
    tri_index,
    per_cell,
    start,
    out_cell,
    out_place,
    out_weight,
    out_triangle,
    out_barycentric,
):
    """Count the samples in each cell of bricks first..last, or write them where there is room.

    `start` (512 · bricks + 1,) has the counts, one place on, and then where each cell's samples go.
    """
    counting = out_cell.shape[0] == 0
    pitch = 1.0 / per_cell
    lowest, highest, at = np.empty(3, np.int64), np.empty(3, np.int64), np.empty(3)
    p, normal, written = np.empty((3, 3)), np.empty(3), np.empty(LOCAL, np.int64)
    for own in range(first, last):
        brick = bricks[own]
        written[:] = 0
        for t in range(tri_start[brick], tri_start[brick + 1]):
            triangle = tri_index[t]
            for d in range(3):
                for v in range(3):
                    p[v, d] = corners[faces[triangle, v], d] * scale - 8.0 * corner_of[brick, d]
                least = min(p[0, d], p[1, d], p[2, d]) * per_cell - 0.5
                most = max(p[0, d], p[1, d], p[2, d]) * per_cell - 0.5
                lowest[d] = max(int(np.ceil(least)), 0)
                highest[d] = min(int(np.floor(most)), 8 * per_cell - 1)
            axis, square = 0, 0.0
            for d in range(3):
                i, j = (d + 1) % 3, (d + 2) % 3
                normal[d] = (p[1, i] - p[0, i]) * (p[2, j] - p[0, j])
                normal[d] -= (p[1, j] - p[0, j]) * (p[2, i] - p[0, i])
                square += normal[d] * normal[d]
                if abs(normal[d]) > abs(normal[axis]):
                    axis = d
            area = normal[axis]
            if abs(area) < 1e-14:
                continue
            weight = pitch * pitch * np.sqrt(square) / abs(area)
            b, c = (axis + 1) % 3, (axis + 2) % 3
            for i in range(lowest[b], highest[b] + 1):
                for j in range(lowest[c], highest[c] + 1):
                    at[b], at[c] = (i + 0.5) * pitch, (j + 0.5) * pitch
                    b0, b1, b2 = p[0, b] - at[b], p[1, b] - at[b], p[2, b] - at[b]
                    c0, c1, c2 = p[0, c] - at[c], p[1, c] - at[c], p[2, c] - at[c]
                    w0 = (b1 * c2 - b2 * c1) / area
                    w1 = (b2 * c0 - b0 * c2) / area
                    w2 = 1.0 - w0 - w1
                    if w0 < 0.0 or w1 < 0.0 or w2 < 0.0:
                        continue
                    at[axis] = w0 * p[0, axis] + w1 * p[1, axis] + w2 * p[2, axis]
                    if at[axis] < 0.0 or at[axis] >= 8.0:
                        continue
                    x, y, z = int(at[0]), int(at[1]), int(at[2])
                    if not leaf[brick, 4 * (x // 4) + 2 * (y // 4) + z // 4]:
                        continue
                    local = 64 * x + 8 * y + z
                    if counting:
                        start[512 * own + local + 1] += 1
                        continue
                    s = start[512 * own + local] + written[local]
                    written[local] += 1
                    out_cell[s] = 512 * brick + local
                    out_place[s, 0], out_place[s, 1] = at[0] - x, at[1] - y
                    out_place[s, 2] = at[2] - z
                    out_weight[s] = weight
                    out_triangle[s] = triangle
                    out_barycentric[s, 0], out_barycentric[s, 1] = w0, w1


@njit(cache=True, nogil=True)
def _goal(first, last, triangle, barycentric, faces, data, values):
    for s in range(first, last):
        t = triangle[s]
        for q in range(LANES):
            rest = data[faces[t, 2], q]
            values[s, q] = (
                rest
                + barycentric[s, 0] * (data[faces[t, 0], q] - rest)
                + barycentric[s, 1] * (data[faces[t, 1], q] - rest)
            )


@njit(cache=True, nogil=True)
def _misfit(first, last, cell, place, places, goal, values, lane_scale, result):
    node, around = places.node, places.around
    gap = np.empty(LANES)
    for s in range(first, last):
        b, local = np.int64(cell[s] >> 9), cell[s] & 511
        x, y, z = local >> 6, (local >> 3) & 7, local & 7
        for q in range(LANES):
            gap[q] = goal[s, q]
        for c in range(8):
            i, j, k = c >> 2, (c >> 1) & 1, c & 1
            weight = place[s, 0] if i else 1.0 - place[s, 0]
            weight *= place[s, 1] if j else 1.0 - place[s, 1]
            weight *= place[s, 2] if k else 1.0 - place[s, 2]
            m = node_at(node, around, b, x + i, y + j, z + k)
            if m >= 0:
                for q in range(LANES):
                    gap[q] -= weight * values[m, q]
        square = 0.0
        for q in range(LANES):
            square += (lane_scale[q] * gap[q]) ** 2
        result[s] = np.sqrt(square)
