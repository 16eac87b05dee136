"""Nearest points and first hits on one surface, in space."""

from __future__ import annotations

from typing import NamedTuple

import igl
import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]
Int = NDArray[np.int64]


_UNITS = 2.0**20
"""Of the tree in a metre: about a µm, since libigl takes triangles of less than a millionth square
unit as edge-on to rays; and a power of two, which takes no bit from a number."""


class Nearest(NamedTuple):
    """The nearest points of a surface to n points.

    Attributes:
        distance: (n,) m.
        points: (n, 3) m.
        elements: (n,) the face, or segment, that each lies on.
    """

    distance: Float
    points: Float
    elements: Int


class SurfaceTree:
    """A surface, or a set of segments, that answers many queries.

    Args:
        vertices: (n, 3) m.
        elements: (m, 3) triangles or (m, 2) segments.
    """

    def __init__(self, vertices: Float, elements: Int) -> None:
        self.vertices = np.ascontiguousarray(vertices, dtype=np.float64)
        self.elements = np.ascontiguousarray(elements, dtype=np.int64)
        self._vertices = _UNITS * self.vertices
        self._tree = igl.AABB()
        self._tree.init(self._vertices, self.elements)

    def nearest(self, points: Float) -> Nearest:
        """The nearest point of the surface to each of (n, 3) m."""
        if len(points) == 0:
            return Nearest(np.zeros(0), np.zeros((0, 3)), np.zeros(0, np.int64))
        squared, elements, nearest = self._tree.squared_distance(
            self._vertices, self.elements, np.ascontiguousarray(_UNITS * points)
        )
        return Nearest(np.sqrt(squared) / _UNITS, nearest / _UNITS, elements)

    def first_hit(self, starts: Float, directions: Float) -> tuple[Float, Int]:
        """How far rays go until they meet a triangle, in lengths of `directions`; inf if never.

        Args:
            starts: (n, 3) m.
            directions: (n, 3).

        Returns:
            (n,) lengths, and (n,) the triangles met, -1 for none.
        """
        face, length, _ = self._tree.intersect_ray_first(
            self._vertices,
            self.elements,
            np.ascontiguousarray(_UNITS * starts),
            np.ascontiguousarray(_UNITS * directions),
        )
        return np.nan_to_num(np.asarray(length, np.float64), nan=np.inf), face

    def weights(self, found: Nearest) -> Float:
        """(n, 3) barycentric coordinates of the nearest points in their triangles."""
        a, b, c = (
            np.ascontiguousarray(self.vertices[self.elements[found.elements, k]]) for k in range(3)
        )
        weights: Float = igl.barycentric_coordinates(np.ascontiguousarray(found.points), a, b, c)
        return np.nan_to_num(weights, nan=1.0 / 3.0)  # triangles without area
