"""A closed mesh on its domain: the unit sphere (genus 0) or the flat torus of area 1 (genus 1)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.goals.maps.closed_mesh import ClosedMesh


@dataclass(frozen=True, eq=False)
class Layout:
    """One point of the domain for each vertex, with every triangle turned outward.

    Attributes:
        mesh: of genus 0 or 1.
        points: (n, 3) unit vectors, or (x, y, 1) on the torus, whose lattice is that of integers.
        corner_shift: (m, 3, 2) lattice vectors: a corner's vertex, so shifted, stands beside the
            face's other corners; zero on the sphere.
    """

    mesh: ClosedMesh
    points: NDArray[np.float64]
    corner_shift: NDArray[np.float64]

    @property
    def flat(self) -> bool:
        """Whether the domain is the torus."""
        return self.mesh.genus == 1

    @property
    def domain_area(self) -> float:
        """4π or 1."""
        return 1.0 if self.flat else 4 * np.pi

    @property
    def shares(self) -> NDArray[np.float64]:
        """(m,): each triangle's share of the domain's area; negative where turned over."""
        areas = triangle_areas(self.points, self.mesh.faces, self.corner_shift, self.flat)
        return np.asarray(areas / self.domain_area)

    @cached_property
    def corners(self) -> NDArray[np.float64]:
        """(m, 3, 3): the corners of each triangle, on one side of the cuts."""
        corners = self.points[self.mesh.faces]
        corners[:, :, :2] += self.corner_shift
        return corners

    @cached_property
    def jumps(self) -> NDArray[np.float64]:
        """(m, 3, 2): what to add to a point when going across the edge opposite corner k."""
        faces, neighbours = self.mesh.faces, self.mesh.neighbours
        jumps = np.empty((len(faces), 3, 2))
        for k in range(3):
            shared = faces[:, (k + 1) % 3]
            there = faces[neighbours[:, k]] == shared[:, None]
            jumps[:, k] = self.corner_shift[neighbours[:, k]][there]
            jumps[:, k] -= self.corner_shift[:, (k + 1) % 3]
        return jumps

    def moved(self, points: NDArray[np.float64]) -> Layout:
        """The same mesh with other points."""
        return Layout(self.mesh, points, self.corner_shift)


@njit(cache=True, error_model="numpy")
def triangle_areas(points, faces, corner_shift, flat):
    """Oriented areas on the domain: (m,)."""
    areas = np.empty(len(faces))
    gradient = np.empty((3, 3))
    corners = np.empty((3, 3))
    for f in range(len(faces)):
        gather_corners(points, faces, corner_shift, f, corners)
        areas[f] = area_and_gradient(corners, flat, gradient)
    return areas


@njit(cache=True, error_model="numpy")
def gather_corners(points, faces, corner_shift, f, corners):
    for k in range(3):
        v = faces[f, k]
        corners[k, 0] = points[v, 0] + corner_shift[f, k, 0]
        corners[k, 1] = points[v, 1] + corner_shift[f, k, 1]
        corners[k, 2] = points[v, 2]


@njit(cache=True, error_model="numpy")
def area_and_gradient(corners, flat, gradient):
    """A triangle's oriented area; fills its gradient (3, 3) with respect to the corners.

    On the sphere Ω = 2 atan2(det, 1 + a·b + b·c + c·a) (van Oosterom and Strackee 1983).
    """
    det = 0.0
    for k in range(3):
        a, b = corners[(k + 1) % 3], corners[(k + 2) % 3]
        for d in range(3):
            e, g = (d + 1) % 3, (d + 2) % 3
            gradient[k, d] = a[e] * b[g] - a[g] * b[e]
    for d in range(3):
        det += corners[0, d] * gradient[0, d]
    if flat:
        gradient *= 0.5
        return 0.5 * det
    rest = 1.0
    for k in range(3):
        for d in range(3):
            rest += corners[k, d] * corners[(k + 1) % 3, d]
    scale = 2.0 / (det * det + rest * rest)
    for k in range(3):
        for d in range(3):
            others = corners[(k + 1) % 3, d] + corners[(k + 2) % 3, d]
            gradient[k, d] = scale * (rest * gradient[k, d] - det * others)
    return 2.0 * np.arctan2(det, rest)
