"""Where a point of the domain lies in a layout: the triangle, and its barycentric coordinates.

A walk from triangle to triangle, across an edge that has the point on its other side. On the torus
the point takes on the lattice vector of each cut that it crosses. Walks that start from nowhere in
particular start from the triangle at the middle of the point's cell of the domain, of which there
are some thousands of equal area.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit
from numpy.typing import NDArray

if TYPE_CHECKING:
    from touchwarp.goals.maps.layout import Layout

OUTSIDE = -1e-14
CELLS = 64
"""Of the domain in each direction."""


class Locator:
    """Finds points of the domain in a layout; walks start where the last call's points were.

    Attributes:
        layout: the layout.
        face: (q,) the triangle of each point last located.
        weights: (q, 3) its barycentric coordinates there, all ≥ 0.
    """

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self.face = np.zeros(0, np.int64)
        self.weights = np.zeros((0, 3))
        self._cells: NDArray[np.int64] | None = None

    def find(
        self, points: NDArray[np.float64], start: NDArray[np.int64] | None = None
    ) -> NDArray[np.int64]:
        """The triangle (q,) of each point (q, 3); `weights` holds where in it.

        Args:
            points: (q, 3) points of the domain, anywhere on the covering plane of a torus.
            start: (q,) triangles to walk from; else those of the last call, if as many; else those
                of the points' cells.
        """
        layout = self.layout
        if start is None:
            start = self.face if len(self.face) == len(points) else self._beside(points)
        self.face, self.weights = _locate(
            np.ascontiguousarray(points),
            start,
            layout.corners,
            layout.mesh.neighbours,
            layout.jumps,
            layout.flat,
        )
        return self.face

    def _beside(self, points: NDArray[np.float64]) -> NDArray[np.int64]:
        """(q,): triangles near the points."""
        layout = self.layout
        if self._cells is None:
            virtual = (layout.corners, layout.mesh.neighbours, layout.jumps)
            self._cells = np.asarray(_triangles_of_cells(virtual, layout.flat))
        return np.asarray(_look_up(points, self._cells, layout.flat))

    def values(self, fields: NDArray[np.float64]) -> NDArray[np.float64]:
        """(q, c): fields (n, c) on the layout's vertices, linear in each triangle."""
        return np.asarray(_interpolate(fields, self.layout.mesh.faces, self.face, self.weights))


@njit(cache=True, error_model="numpy", nogil=True)
def _locate(points, start, corners, neighbours, jumps, flat):
    q = len(points)
    found = np.empty(q, np.int64)
    weights = np.empty((q, 3))
    most = 4 * len(corners)
    best, side = np.empty(3), np.empty(3)
    for i in range(q):
        x, y, z = points[i]
        face = start[i]
        if flat:  # near the triangle that the walk starts from
            x += np.rint(corners[face, 0, 0] - x)
            y += np.rint(corners[face, 0, 1] - y)
        came = -1
        for turn in range(most):
            for k in range(3):
                a, b = corners[face, (k + 1) % 3], corners[face, (k + 2) % 3]
                side[k] = (
                    x * (a[1] * b[2] - a[2] * b[1])
                    + y * (a[2] * b[0] - a[0] * b[2])
                    + z * (a[0] * b[1] - a[1] * b[0])
                )
            best[:] = side
            # Across any edge that has the point beyond it, in turn, lest the walk go in circles.
            across = -1
            for k in range(3):
                e = (k + turn) % 3
                if side[e] < OUTSIDE and neighbours[face, e] != came:
                    across = e
                    break
            if across < 0:
                for e in range(3):
                    if side[e] < OUTSIDE:
                        across = e
            if across < 0:
                break
            x += jumps[face, across, 0]
            y += jumps[face, across, 1]
            came = face
            face = neighbours[face, across]
        total = 0.0
        for k in range(3):
            best[k] = max(best[k], 0.0)
            total += best[k]
        found[i] = face
        for k in range(3):
            weights[i, k] = best[k] / total
    return found, weights


@njit(cache=True, error_model="numpy")
def _triangles_of_cells(virtual, flat):
    """(CELLS, CELLS): the triangle at the middle of each cell, found in rows to and fro."""
    triangles, place = np.empty((CELLS, CELLS), np.int64), np.empty(3)
    near = 0
    for i in range(CELLS):
        for step in range(CELLS):
            j = step if i % 2 == 0 else CELLS - 1 - step
            across, along = (i + 0.5) / CELLS, (j + 0.5) / CELLS
            if flat:
                place[0], place[1], place[2] = across, along, 1.0
            else:
                height, turn = 2.0 * across - 1.0, 2.0 * np.pi * along
                radius = np.sqrt(1.0 - height * height)
                place[0], place[1] = radius * np.cos(turn), radius * np.sin(turn)
                place[2] = height
            near = walk_to(place, near, virtual, flat)
            triangles[i, j] = near
    return triangles


@njit(cache=True, error_model="numpy")
def _look_up(points, triangles, flat):
    """(q,): the triangle of the cell that each point lies in."""
    found = np.empty(len(points), np.int64)
    for q in range(len(points)):
        x, y, z = points[q]
        if flat:
            across, along = x - np.floor(x), y - np.floor(y)
        else:  # height and turn: cells of equal area (Lambert)
            across, along = 0.5 * (z + 1.0), np.arctan2(y, x) / (2.0 * np.pi) % 1.0
        i, j = min(int(across * CELLS), CELLS - 1), min(int(along * CELLS), CELLS - 1)
        found[q] = triangles[max(i, 0), j]
    return found


@njit(cache=True, error_model="numpy")
def walk_to(place, start, virtual, flat):
    """The triangle of one point (3,), walking from a triangle near it.

    Args:
        place: (3,).
        start: a triangle.
        virtual: (corners, neighbours, jumps, …) of the layout.
        flat: whether the domain is the torus.
    """
    corners, neighbours, jumps = virtual[0], virtual[1], virtual[2]
    x, y, z = place
    f, came = start, -1
    if flat:
        x += np.rint(corners[f, 0, 0] - x)
        y += np.rint(corners[f, 0, 1] - y)
    for turn in range(4 * len(corners)):
        across = -1
        for k in range(3):
            e = (k + turn) % 3
            a, b = corners[f, (e + 1) % 3], corners[f, (e + 2) % 3]
            side = (
                x * (a[1] * b[2] - a[2] * b[1])
                + y * (a[2] * b[0] - a[0] * b[2])
                + z * (a[0] * b[1] - a[1] * b[0])
            )
            if side < OUTSIDE:
                across = e
                if neighbours[f, e] != came:
                    break
        if across < 0:
            return f
        x += jumps[f, across, 0]
        y += jumps[f, across, 1]
        came, f = f, neighbours[f, across]
    return f


@njit(cache=True, error_model="numpy")
def value_and_slopes(place, f, virtual, frame, value, slopes, flat):
    """Fields at one point of triangle f, and how they change along a frame of the domain there.

    Args:
        place: (3,).
        f: the triangle.
        virtual: (corners, …, …, faces, fields), fields (n, c) on the layout's vertices.
        frame: two tangents, six numbers.
        value: (c,) to fill; slopes: (c, 2) to fill.
        flat: whether the domain is the torus.
    """
    own, faces, fields = virtual[0][f], virtual[3], virtual[4]
    x, y, z = place
    if flat:
        x += np.rint(own[0, 0] - x)
        y += np.rint(own[0, 1] - y)
    value[:] = 0.0
    slopes[:] = 0.0
    sides, total, inside, along, across = np.empty((3, 3)), 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        a, b = own[(k + 1) % 3], own[(k + 2) % 3]
        nx, ny, nz = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
        sides[k, 0] = x * nx + y * ny + z * nz
        sides[k, 1] = frame[0] * nx + frame[1] * ny + frame[2] * nz
        sides[k, 2] = frame[3] * nx + frame[4] * ny + frame[5] * nz
        total += sides[k, 0]
        inside += max(sides[k, 0], 0.0)
        along += sides[k, 1]
        across += sides[k, 2]
    for k in range(3):
        part = sides[k, 0] / total
        a, b = (sides[k, 1] - part * along) / total, (sides[k, 2] - part * across) / total
        part = max(sides[k, 0], 0.0) / inside
        for c in range(len(value)):
            field = fields[faces[f, k], c]
            value[c] += part * field
            slopes[c, 0] += a * field
            slopes[c, 1] += b * field


@njit(cache=True, error_model="numpy")
def _interpolate(fields, faces, face, weights):
    values = np.zeros((len(face), fields.shape[1]))
    for i in range(len(face)):
        for k in range(3):
            v = faces[face[i], k]
            for c in range(fields.shape[1]):
                values[i, c] += weights[i, k] * fields[v, c]
    return values
