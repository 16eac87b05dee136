"""A closed mesh on its domain: the unit sphere (genus 0) or the flat torus of area 1 (genus 1)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.goals.maps.closed_mesh import ClosedMesh
from touchwarp.goals.maps.locate import Locator
from touchwarp.goals.maps.star import tangents


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

    def frames(self) -> NDArray[np.float64]:
        """(n, 3, 2): two tangents of the domain at each point, as columns."""
        return frames_at(self.points, self.flat)

    def along(self, frames: NDArray[np.float64], move: NDArray[np.float64]) -> NDArray[np.float64]:
        """The points (n, 3) after moves (n, 2) along their frames."""
        return moved_along(self.points, frames, move, self.flat)

    def area_gradients(self, frames: NDArray[np.float64]) -> NDArray[np.float64]:
        """(m, 3, 2): how each triangle's area on the domain changes along its corners' frames."""
        return np.asarray(
            area_gradients(self.points, self.mesh.faces, self.corner_shift, frames, self.flat)
        )

    def cotangents(self) -> NDArray[np.float64]:
        """(m, 3) halves of the cotangents of the triangles' angles on the domain, about."""
        corners = self.corners
        sides = np.stack(
            [((corners[:, k - 2] - corners[:, k - 1]) ** 2).sum(axis=1) for k in range(3)], axis=1
        )
        areas = np.abs(self.shares)[:, None] * self.domain_area
        return np.asarray((sides.sum(axis=1, keepdims=True) - 2 * sides) / (8 * areas))

    def comparable(self, frames: NDArray[np.float64]) -> NDArray[np.float64]:
        """Frames (n, 3, 2) such that moves of neighbours can be compared in space."""
        return frames

    def locator(self) -> Locator:
        """What finds points of the domain in this layout."""
        return Locator(self)

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
    """`area_and_gradient_on` the torus or the sphere."""
    return area_and_gradient_on(corners, 0.0 if flat else 1.0, gradient)


@njit(cache=True, error_model="numpy")
def area_and_gradient_on(corners, curvature, gradient):
    """A triangle's oriented area; fills its gradient (3, 3) with respect to the corners.

    On the domain of curvature κ = ±1 it is 2 atan2(det, 1 + κ (⟨a, b⟩ + ⟨b, c⟩ + ⟨c, a⟩)), on the
    sphere that of van Oosterom and Strackee (1983); ⟨a, b⟩ is that of `star`.
    """
    det = 0.0
    for k in range(3):
        a, b = corners[(k + 1) % 3], corners[(k + 2) % 3]
        for d in range(3):
            e, g = (d + 1) % 3, (d + 2) % 3
            gradient[k, d] = a[e] * b[g] - a[g] * b[e]
    for d in range(3):
        det += corners[0, d] * gradient[0, d]
    if curvature == 0.0:
        gradient *= 0.5
        return 0.5 * det
    rest = 1.0
    for k in range(3):
        a, b = corners[k], corners[(k + 1) % 3]
        rest += curvature * (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
    scale = 2.0 / (det * det + rest * rest)
    for k in range(3):
        for d in range(3):
            others = corners[(k + 1) % 3, d] + corners[(k + 2) % 3, d]
            if d < 2:
                others *= curvature
            gradient[k, d] = scale * (rest * gradient[k, d] - det * others)
    return 2.0 * np.arctan2(det, rest)


def frames_at(points: NDArray[np.float64], flat: bool) -> NDArray[np.float64]:
    """(n, 3, 2): two tangents of the domain at each point, as columns."""
    return np.asarray(_frames(points, flat))


def moved_along(
    points: NDArray[np.float64], frames: NDArray[np.float64], move: NDArray[np.float64], flat: bool
) -> NDArray[np.float64]:
    """Points moved by (n, 2) along their tangents, and back onto the domain."""
    moved = points + np.einsum("ndi,ni->nd", frames, move)
    if not flat:
        moved /= np.linalg.norm(moved, axis=1, keepdims=True)
    return np.asarray(moved)


@njit(cache=True, error_model="numpy")
def _frames(points, flat):
    frames = np.empty((len(points), 3, 2))
    for v in range(len(points)):
        ux, uy, uz, wx, wy, wz = tangents(points[v, 0], points[v, 1], points[v, 2], flat)
        frames[v, 0, 0], frames[v, 1, 0], frames[v, 2, 0] = ux, uy, uz
        frames[v, 0, 1], frames[v, 1, 1], frames[v, 2, 1] = wx, wy, wz
    return frames


@njit(cache=True, error_model="numpy")
def area_gradients(points, faces, corner_shift, frames, flat):
    """(m, 3, 2): how each triangle's area changes with its corners' moves along their tangents."""
    result = np.zeros((len(faces), 3, 2))
    corners = np.empty((3, 3))
    gradient = np.empty((3, 3))
    for f in range(len(faces)):
        gather_corners(points, faces, corner_shift, f, corners)
        area_and_gradient(corners, flat, gradient)
        for k in range(3):
            v = faces[f, k]
            for d in range(3):
                result[f, k, 0] += gradient[k, d] * frames[v, d, 0]
                result[f, k, 1] += gradient[k, d] * frames[v, d, 1]
    return result
