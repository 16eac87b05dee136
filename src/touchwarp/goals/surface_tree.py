"""Nearest points and first hits on one surface, in space."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import igl
import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]
Int = NDArray[np.int64]


_RAY_UNITS = 1e6
"""Rays are traced in µm: libigl takes triangles of less than a millionth square unit as edge-on."""


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
        self._tree = igl.AABB()
        self._tree.init(self.vertices, self.elements)

    @cached_property
    def _ray_tree(self) -> tuple[igl.AABB, Float]:
        vertices = _RAY_UNITS * self.vertices
        tree = igl.AABB()
        tree.init(vertices, self.elements)
        return tree, vertices

    def nearest(self, points: Float) -> Nearest:
        """The nearest point of the surface to each of (n, 3) m."""
        points = np.ascontiguousarray(points, dtype=np.float64)
        if len(points) == 0:
            return Nearest(np.zeros(0), np.zeros((0, 3)), np.zeros(0, np.int64))
        squared, elements, nearest = self._tree.squared_distance(
            self.vertices, self.elements, points
        )
        return Nearest(np.sqrt(squared), nearest, elements)

    def first_hit(self, starts: Float, directions: Float) -> tuple[Float, Int]:
        """How far rays go until they meet a triangle, in lengths of `directions`; inf if never.

        Args:
            starts: (n, 3) m.
            directions: (n, 3).

        Returns:
            (n,) lengths, and (n,) the triangles met, -1 for none.
        """
        tree, vertices = self._ray_tree
        face, length, _ = tree.intersect_ray_first(
            vertices,
            self.elements,
            np.ascontiguousarray(_RAY_UNITS * starts),
            np.ascontiguousarray(_RAY_UNITS * directions),
        )
        return np.nan_to_num(np.asarray(length, np.float64), nan=np.inf), face

    def weights(self, found: Nearest) -> Float:
        """(n, 3) barycentric coordinates of the nearest points in their triangles."""
        a, b, c = (
            np.ascontiguousarray(self.vertices[self.elements[found.elements, k]]) for k in range(3)
        )
        weights: Float = igl.barycentric_coordinates(np.ascontiguousarray(found.points), a, b, c)
        return np.nan_to_num(weights, nan=1.0 / 3.0)  # triangles without area
