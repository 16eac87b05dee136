"""Cut edges: where grid edges cross surfaces.

Cutting is scan conversion: for each axis, a triangle is projected along it and every grid line
through it is hit once. No inside or outside is needed, so surfaces may be open, overlapping or
non-manifold. Each brick keeps the triangles that reach into it, sieved from its parent's list.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.solve.level import FLOOR, LOCAL, Level
from touchwarp.solve.threads import share

NEAREST = 1e-3
"""The least crossing distance, in cells: a nearer surface is taken to be this far. The node's value
is then g to a thousandth of the difference across a cell, far below the discretisation error."""


ON_NODE = 1e-7
"""A crossing nearer than this, in cells, goes through the node."""


@dataclass(eq=False)
class BrickTriangles:
    """The triangles that reach into each brick of a level: `index[start[b]:start[b + 1]]`."""

    start: NDArray[np.int64]
    index: NDArray[np.int32]


class Cuts(NamedTuple):
    """The cut edges of a level, seen from their nodes.

    Attributes:
        row: (n,) int32, a node's row below, or -1 where none of its edges is cut.
        node: (k,) int32, the nodes with a cut edge.
        start: (k + 1,) int64, each one's cuts in the arrays below.
        direction: (c,) int8, 0..5 for x-, x+, y-, y+, z-, z+.
        distance: (c,) float32, from the node to the nearest crossing, in cells, at most 1.
        triangle: (c,) int32.
        weights: (c, 2) float32, barycentric weights of the triangle's first two corners.
    """

    row: NDArray[np.int32]
    node: NDArray[np.int32]
    start: NDArray[np.int64]
    direction: NDArray[np.int8]
    distance: NDArray[np.float32]
    triangle: NDArray[np.int32]
    weights: NDArray[np.float32]


def sieve_triangles(
    level: Level,
    corners: NDArray[np.float64],
    faces: NDArray[np.int32],
    coarser: BrickTriangles | None,
) -> BrickTriangles:
    """The triangles near each brick of a level.

    Args:
        level: the level.
        corners: (v, 3) vertices in root-grid coordinates.
        faces: (f, 3) their triangles.
        coarser: the coarser level's lists, or None where every triangle is a candidate.
    """
    count = len(level.bricks)
    if coarser is None:
        parent = np.zeros(count, np.int32)
        coarser = BrickTriangles(
            np.array([0, len(faces)], np.int64), np.arange(len(faces), dtype=np.int32)
        )
    else:
        parent = level.parent
    start = np.zeros(count + 1, np.int64)
    given = level.bricks, parent, corners, faces, 2.0**level.depth, coarser.start, coarser.index
    index = np.concatenate(share(_sieve, count, *given, start, work=LOCAL))
    return BrickTriangles(np.cumsum(start), index)


def cut_edges(
    level: Level,
    corners: NDArray[np.float64],
    faces: NDArray[np.int32],
    triangles: BrickTriangles,
) -> Cuts:
    """Every edge of a level that a triangle crosses, from both its ends."""
    # Only bricks with triangles, so that parts of them take about as long as one another.
    bricks = np.flatnonzero(np.diff(triangles.start)).astype(np.int32)
    lists = triangles.start, triangles.index
    given = bricks, level.places, corners, faces, 2.0**level.depth, *lists
    parts = zip(*share(_scan, len(bricks), *given, work=LOCAL), strict=True)
    node, count, *cuts = (np.concatenate(part) for part in parts)
    row = np.full(level.n, -1, np.int32)
    row[node] = np.arange(len(node), dtype=np.int32)
    return Cuts(row, node, np.concatenate([[0], np.cumsum(count)]), *cuts)


@njit(cache=True, nogil=True)
def cut_along(row, start, direction, node, wanted):
    """The cut of a node's edge in one direction, or -1."""
    r = row[node]
    if r >= 0:
        for k in range(start[r], start[r + 1]):
            if direction[k] == wanted:
                return k
    return -1


@njit(cache=True, nogil=True)
def _reaches(corners, faces, t, scale, low, high):
    """Whether a triangle may meet a box: by its bounding box, then by its plane."""
    a, b, c = faces[t, 0], faces[t, 1], faces[t, 2]
    for d in range(3):
        p, q, r = corners[a, d] * scale, corners[b, d] * scale, corners[c, d] * scale
        if min(p, q, r) > high[d] or max(p, q, r) < low[d]:
            return False
    ux = corners[b, 0] - corners[a, 0]
    uy = corners[b, 1] - corners[a, 1]
    uz = corners[b, 2] - corners[a, 2]
    vx = corners[c, 0] - corners[a, 0]
    vy = corners[c, 1] - corners[a, 1]
    vz = corners[c, 2] - corners[a, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    offset = (
        nx * (0.5 * (low[0] + high[0]) - corners[a, 0] * scale)
        + ny * (0.5 * (low[1] + high[1]) - corners[a, 1] * scale)
        + nz * (0.5 * (low[2] + high[2]) - corners[a, 2] * scale)
    )
    reach = 0.5 * (
        abs(nx) * (high[0] - low[0]) + abs(ny) * (high[1] - low[1]) + abs(nz) * (high[2] - low[2])
    )
    return abs(offset) <= reach * (1.0 + 1e-9)


@njit(cache=True, nogil=True)
def _sieve(first, last, bricks, parent, corners, faces, scale, parent_start, parent_index, start):
    """The triangles near bricks first..last; `start` receives, one place on, how many each has."""
    most = 0
    for b in range(first, last):
        most += parent_start[parent[b] + 1] - parent_start[parent[b]]
    index = np.empty(most, np.int32)
    end = 0
    low, high = np.empty(3), np.empty(3)
    for b in range(first, last):
        for d in range(3):
            low[d] = 8.0 * bricks[b, d] - 1.001
            high[d] = 8.0 * bricks[b, d] + 8.001
        begun = end
        for i in range(parent_start[parent[b]], parent_start[parent[b] + 1]):
            t = parent_index[i]
            if _reaches(corners, faces, t, scale, low, high):
                index[end] = t
                end += 1
        start[b + 1] = end - begun
    return index[:end].copy()


@njit(cache=True, nogil=True)
def _hit_lines(corners, faces, t, scale, origin, axis, near, hit, weight):
    """Record a triangle's crossings of the grid lines along an axis through a brick's nodes."""
    b, c = (axis + 1) % 3, (axis + 2) % 3
    i0, i1, i2 = faces[t, 0], faces[t, 1], faces[t, 2]
    p0 = corners[i0, b] * scale - origin[b]
    p1 = corners[i1, b] * scale - origin[b]
    p2 = corners[i2, b] * scale - origin[b]
    q0 = corners[i0, c] * scale - origin[c]
    q1 = corners[i1, c] * scale - origin[c]
    q2 = corners[i2, c] * scale - origin[c]
    area = (p1 - p0) * (q2 - q0) - (p2 - p0) * (q1 - q0)
    if abs(area) < 1e-14:
        return
    s0 = corners[i0, axis] * scale - origin[axis]
    s1 = corners[i1, axis] * scale - origin[axis]
    s2 = corners[i2, axis] * scale - origin[axis]
    slack = 1e-9
    first_p = max(int(np.ceil(min(p0, p1, p2) - slack)), 0)
    last_p = min(int(np.floor(max(p0, p1, p2) + slack)), 7)
    first_q = max(int(np.ceil(min(q0, q1, q2) - slack)), 0)
    last_q = min(int(np.floor(max(q0, q1, q2) + slack)), 7)
    for p in range(first_p, last_p + 1):
        for q in range(first_q, last_q + 1):
            w0 = ((p1 - p) * (q2 - q) - (p2 - p) * (q1 - q)) / area
            w1 = ((p2 - p) * (q0 - q) - (p0 - p) * (q2 - q)) / area
            w2 = 1.0 - w0 - w1
            if w0 < -slack or w1 < -slack or w2 < -slack:
                continue
            s = w0 * s0 + w1 * s1 + w2 * s2
            i = int(np.floor(s))
            for side in range(2):
                j = i + side
                if j < 0 or j > 7:
                    continue
                distance = s - i if side == 0 else 1.0 - (s - i)
                if axis == 0:
                    local = 64 * j + 8 * p + q
                elif axis == 1:
                    local = 64 * q + 8 * j + p
                else:
                    local = 64 * p + 8 * q + j
                direction = 2 * axis + 1 - side
                for way in range(2 if distance < ON_NODE else 1):
                    # A node on the surface is cut off on both sides, or paths would pass it.
                    d = direction if way == 0 else direction ^ 1
                    if distance < near[local, d]:
                        near[local, d] = distance
                        hit[local, d] = t
                        weight[local, d, 0] = w0
                        weight[local, d, 1] = w1


@njit(cache=True, nogil=True)
def _scan(first, last, bricks, places, corners, faces, scale, tri_start, tri_index):
    """The nodes of bricks first..last that have cut edges, how many, and what `Cuts` has of each.

    There is room for every edge to be cut; what is not written takes no memory.
    """
    bricks_at, around, node = places.bricks, places.around, places.node
    rows, most = 0, 512 * (last - first)
    cut_node, count = np.empty(most, np.int32), np.empty(most, np.int64)
    cuts, most = 0, 6 * most
    direction, distance = np.empty(most, np.int8), np.empty(most, np.float32)
    triangle, weights = np.empty(most, np.int32), np.empty((most, 2), np.float32)
    near = np.empty((512, 6))
    hit = np.empty((512, 6), np.int32)
    weight = np.empty((512, 6, 2), np.float32)
    origin = np.empty(3)
    for i in range(first, last):
        b = bricks[i]
        for local in range(512):
            for d in range(6):
                near[local, d], hit[local, d] = 2.0, -1
        for d in range(3):
            origin[d] = 8.0 * bricks_at[b, d]
        for t in range(tri_start[b], tri_start[b + 1]):
            for axis in range(3):
                _hit_lines(corners, faces, tri_index[t], scale, origin, axis, near, hit, weight)
        for local in range(512):
            m = node[512 * b + local]
            if m < 0:
                continue
            if around[b, FLOOR] == 1 and local % 8 == 0:
                # What lies under the plane is the mirror image of what lies above.
                own, image = (5, 4) if near[local, 5] <= near[local, 4] else (4, 5)
                hit[local, image], near[local, image] = hit[local, own], near[local, own]
                weight[local, image, 0] = weight[local, own, 0]
                weight[local, image, 1] = weight[local, own, 1]
            begun = cuts
            for d in range(6):
                if hit[local, d] < 0:
                    continue
                direction[cuts] = d
                distance[cuts] = max(near[local, d], NEAREST)
                triangle[cuts] = hit[local, d]
                weights[cuts, 0] = weight[local, d, 0]
                weights[cuts, 1] = weight[local, d, 1]
                cuts += 1
            if cuts > begun:
                cut_node[rows], count[rows] = m, cuts - begun
                rows += 1
    return (
        cut_node[:rows].copy(),
        count[:rows].copy(),
        direction[:cuts].copy(),
        distance[:cuts].copy(),
        triangle[:cuts].copy(),
        weights[:cuts].copy(),
    )
