"""Is a point inside a surface? Signed crossings along six rays, two up each axis.

For a closed, consistently oriented mesh, self-intersecting or not, each ray's sum of signed
crossings is the winding number, exactly. On a damaged mesh the rays disagree near the damage, and
there the solid angle decides (Jacobson et al. 2013), by libigl's fast winding number. Triangles are
kept in columns along each axis, so a ray meets few of them and slivers cost no more than others.
"""

from __future__ import annotations

import math

import igl
import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.check.shares import share_out

Float = NDArray[np.float64]
Int = NDArray[np.int64]


class Windings:
    """Winding numbers of many points about one surface.

    Args:
        vertices: (n, d) m.
        faces: (m, d): triangles for d = 3, segments for d = 2.
    """

    def __init__(self, vertices: Float, faces: Int) -> None:
        self.vertices = np.ascontiguousarray(vertices, dtype=np.float64).view()
        self.faces = np.ascontiguousarray(faces, dtype=np.int64).view()
        # numba compiles anew for arrays that may be written to
        self.vertices.flags.writeable = self.faces.flags.writeable = False
        self._columns: list[tuple[Int, Int, Float, int]] = []

    def at(self, points: Float) -> Float:
        """Winding numbers: (n,) for (n, d) m; near 1 inside a surface whose normals look out."""
        points = np.ascontiguousarray(points, dtype=np.float64)
        if len(points) == 0:
            return np.zeros(0)
        if points.shape[1] == 2:
            turns = np.empty(len(points))
            share_out(len(points), lambda s: _turns(self.vertices, self.faces, points[s], turns[s]))
            return turns
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        near = np.flatnonzero(((points >= low) & (points <= high)).all(axis=1))
        winding = np.zeros(len(points))
        if len(near) == 0:
            return winding
        if not self._columns:
            self._columns = [_make_columns(self.vertices, self.faces, a) for a in range(3)]
        rays = np.empty((3, len(near), 2))
        asked = points[near]
        for axis, columns in enumerate(self._columns):
            self._count_along(axis, columns, asked, rays[axis])
        winding[near] = rays[0, :, 0]
        doubtful = near[(rays != rays[:1, :, :1]).any(axis=(0, 2))]
        if len(doubtful):
            winding[doubtful] = igl.fast_winding_number(
                self.vertices, self.faces, np.ascontiguousarray(points[doubtful])
            )
        return winding

    def _count_along(
        self, axis: int, columns: tuple[Int, Int, Float, int], points: Float, rays: Float
    ) -> None:
        surface = (self.vertices, self.faces, axis, *columns)
        share_out(len(points), lambda s: _crossings(*surface, points[s], rays[s]))


def _make_columns(vertices: Float, faces: Int, axis: int) -> tuple[Int, Int, Float, int]:
    """Faces by column along `axis`: column c holds members[start[c]:start[c + 1]].

    `grid` holds the columns' lowest corner and width in the two other axes.
    """
    count = int(np.clip(math.sqrt(len(faces)), 16, 1024))
    others = [a for a in range(3) if a != axis]
    flat = vertices[:, others]
    low = flat.min(axis=0)
    width = np.maximum((flat.max(axis=0) - low) / count, 1e-300)
    corners = flat[faces]
    first = np.clip(((corners.min(axis=1) - low) / width).astype(np.int64), 0, count - 1)
    last = np.clip(((corners.max(axis=1) - low) / width).astype(np.int64), 0, count - 1)
    start, members = _sort_into_columns(first, last, count)
    return start, members, np.concatenate([low, width]), count


@njit(cache=True)
def _sort_into_columns(first, last, count):
    start = np.zeros(count * count + 1, np.int64)
    for f in range(first.shape[0]):
        for i in range(first[f, 0], last[f, 0] + 1):
            for j in range(first[f, 1], last[f, 1] + 1):
                start[i * count + j + 1] += 1
    for c in range(count * count):
        start[c + 1] += start[c]
    members = np.empty(start[-1], np.int64)
    filled = start[:-1].copy()
    for f in range(first.shape[0]):
        for i in range(first[f, 0], last[f, 0] + 1):
            for j in range(first[f, 1], last[f, 1] + 1):
                members[filled[i * count + j]] = f
                filled[i * count + j] += 1
    return start, members


@njit(cache=True, nogil=True)
def _crossings(vertices, faces, axis, start, members, grid, count, points, rays):
    """Signed crossings above and (turned) below each point along `axis`, into rays (n, 2)."""
    a1, a2 = (axis + 1) % 3, (axis + 2) % 3
    low_first = min(a1, a2)
    for n in range(points.shape[0]):
        p, q = points[n, a1], points[n, a2]
        first, second = (p, q) if a1 == low_first else (q, p)
        i = min(max(int((first - grid[0]) / grid[2]), 0), count - 1)
        j = min(max(int((second - grid[1]) / grid[3]), 0), count - 1)
        above = 0
        below = 0
        for k in range(start[i * count + j], start[i * count + j + 1]):
            f = members[k]
            A, B, C = faces[f, 0], faces[f, 1], faces[f, 2]
            ap, aq = vertices[A, a1] - p, vertices[A, a2] - q
            bp, bq = vertices[B, a1] - p, vertices[B, a2] - q
            cp, cq = vertices[C, a1] - p, vertices[C, a2] - q
            # half-open rule by edge, the same sign from both neighbours of an edge
            wc = _side(ap, aq, bp, bq)
            wa = _side(bp, bq, cp, cq)
            wb = _side(cp, cq, ap, aq)
            if not ((wa > 0 and wb > 0 and wc > 0) or (wa < 0 and wb < 0 and wc < 0)):
                continue
            na, nb, nc = bp * cq - bq * cp, cp * aq - cq * ap, ap * bq - aq * bp
            total = na + nb + nc
            if total == 0.0:
                continue
            height = (
                na * vertices[A, axis] + nb * vertices[B, axis] + nc * vertices[C, axis]
            ) / total
            sign = 1 if total > 0.0 else -1
            if height > points[n, axis]:
                above += sign
            else:
                below -= sign
        rays[n, 0] = above
        rays[n, 1] = below


@njit(cache=True, inline="always")
def _side(ap, aq, bp, bq):
    """On which side of the line a → b the origin lies, never undecided."""
    swap = (ap > bp) or (ap == bp and aq > bq)
    if swap:
        ap, aq, bp, bq = bp, bq, ap, aq
    cross = ap * bq - aq * bp
    side = 1 if cross >= 0.0 else -1
    return -side if swap else side


@njit(cache=True, nogil=True)
def _turns(vertices, segments, points, winding):
    """Winding numbers in the plane: the angle under which the segments are seen, over 2π."""
    for n in range(points.shape[0]):
        angle = 0.0
        for s in range(segments.shape[0]):
            ax = vertices[segments[s, 0], 0] - points[n, 0]
            ay = vertices[segments[s, 0], 1] - points[n, 1]
            bx = vertices[segments[s, 1], 0] - points[n, 0]
            by = vertices[segments[s, 1], 1] - points[n, 1]
            angle += math.atan2(ax * by - ay * bx, ax * bx + ay * by)
        winding[n] = angle / (2.0 * math.pi)
