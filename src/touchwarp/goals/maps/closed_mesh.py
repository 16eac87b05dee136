"""Closed, oriented, connected triangle meshes: what a surface map starts from."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.scene.surface import Surface
from touchwarp.scene.topology import bodies, edge_counts, loop_count, opposite_halfedges
from touchwarp.scene.weld import weld

MENDING = (
    "`touchwarp repair` closes and mends such meshes; the kinds transform, plane_projection and "
    "direction take the mesh as it is"
)


@dataclass(frozen=True, eq=False)
class ClosedMesh:
    """A connected triangle mesh without border, each edge on two faces that are turned alike.

    Attributes:
        vertices: (n, 3) m, scene frame; all are used.
        faces: (m, 3) int64, turned outward.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]

    @property
    def genus(self) -> int:
        """How many handles: (2 − V + E − F) / 2."""
        return (2 - len(self.vertices) + len(self.faces) // 2) // 2

    @cached_property
    def neighbours(self) -> NDArray[np.int64]:
        """(m, 3): the face across the edge that lies opposite corner k."""
        opposite = opposite_halfedges(self.faces, len(self.vertices))
        across = (opposite % len(self.faces)).reshape(3, -1).T
        return np.ascontiguousarray(across[:, [1, 2, 0]])  # half-edge k goes from corner k to k + 1

    @cached_property
    def face_areas(self) -> NDArray[np.float64]:
        """(m,) m²."""
        return np.asarray(np.linalg.norm(self._crossed, axis=1) / 2)

    @cached_property
    def face_normals(self) -> NDArray[np.float64]:
        """(m, 3) unit vectors, outward; zero for a triangle without area."""
        length = np.linalg.norm(self._crossed, axis=1, keepdims=True)
        return np.asarray(self._crossed / np.maximum(length, np.finfo(float).tiny))

    @cached_property
    def vertex_areas(self) -> NDArray[np.float64]:
        """(n,) m²: a third of each face around; they sum up to the surface's area."""
        return self.sum_at_vertices(np.repeat(self.face_areas[:, None] / 3, 3, axis=1))

    @cached_property
    def vertex_normals(self) -> NDArray[np.float64]:
        """(n, 3) unit vectors, outward: face normals weighted by their angles."""
        angles = self.corner_angles
        total = np.stack(
            [self.sum_at_vertices(angles * self.face_normals[:, d, None]) for d in range(3)], axis=1
        )
        length = np.linalg.norm(total, axis=1, keepdims=True)
        return np.asarray(total / np.maximum(length, np.finfo(float).tiny))

    @cached_property
    def corner_angles(self) -> NDArray[np.float64]:
        """(m, 3) rad."""
        corners = self.vertices[self.faces]
        ahead = np.roll(corners, -1, axis=1) - corners
        back = np.roll(corners, 1, axis=1) - corners
        crossed = np.linalg.norm(np.cross(ahead, back), axis=2)
        return np.asarray(np.arctan2(crossed, (ahead * back).sum(axis=2)))

    @cached_property
    def centre(self) -> NDArray[np.float64]:
        """(3,) m: the surface's centre of area."""
        return np.asarray(self.vertex_areas @ self.vertices / self.vertex_areas.sum())

    @property
    def area(self) -> float:
        """m²."""
        return float(self.face_areas.sum())

    @property
    def diagonal(self) -> float:
        """m, of the bounding box."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))

    def sum_at_vertices(self, of_corners: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n,): the sum of (m, 3) values of corners over the corners at each vertex."""
        return np.bincount(
            self.faces.ravel(), of_corners.ravel(), minlength=len(self.vertices)
        ).astype(np.float64)

    @cached_property
    def _crossed(self) -> NDArray[np.float64]:
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        return np.asarray(np.cross(b - a, c - a))


def closed_mesh(surface: Surface, what: str) -> ClosedMesh:
    """The surface as a closed mesh, welded and turned outward.

    Args:
        surface: triangles in space.
        what: its name in messages, such as "the prop".

    Raises:
        GoalError: it is flat, open, in several pieces, not manifold, or its faces are not turned
            alike.
    """
    if surface.dimension != 3:
        raise GoalError(f"{what} is a plane curve; surface maps need triangles in space.")
    vertices, faces = weld(surface.vertices, surface.faces)
    edges, counts = edge_counts(faces)
    if (counts == 1).any():
        holes = loop_count(edges[counts == 1])
        raise GoalError(
            f"{what} is not closed: {int((counts == 1).sum())} open edges, in {holes} "
            f"hole{'s' * (holes != 1)}, where a closed surface is needed. {MENDING}."
        )
    if (counts > 2).any():
        raise GoalError(
            f"{what} is not manifold: {int((counts > 2).sum())} edges have more than two faces, "
            f"where a surface needs two. {MENDING}."
        )
    pieces = int(bodies(faces).max()) + 1
    if pieces > 1:
        raise GoalError(
            f"{what} is in {pieces} pieces, where one is needed: keep the largest, or join them "
            f"in a modelling tool. {MENDING}."
        )
    start, end = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    if len(np.unique(start * len(vertices) + end)) < 3 * len(faces):
        raise GoalError(
            f"{what} has neighbouring faces that are turned opposite ways, where all must be "
            f"turned outward. {MENDING}."
        )
    pinched = len(vertices) - _fan_count(faces, len(vertices))
    if pinched:
        raise GoalError(
            f"{what} is not manifold: at {-pinched} vertices separate parts of it touch in a "
            f"point. {MENDING}."
        )
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    if float((a * np.cross(b, c)).sum()) < 0:
        faces = np.ascontiguousarray(faces[:, ::-1])
    return ClosedMesh(vertices, faces)


def _fan_count(faces: NDArray[np.int64], vertices: int) -> int:
    """How many closed fans of corners there are; on a manifold one a vertex."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    m = len(faces)
    opposite = opposite_halfedges(faces, vertices)
    halfedge = np.arange(3 * m)
    corner = halfedge  # of the half-edge's start; across the edge, the same vertex is at its end
    across = opposite % m + (opposite // m + 1) % 3 * m
    graph = coo_matrix((np.ones(3 * m, dtype=np.bool_), (corner, across)), shape=(3 * m, 3 * m))
    return int(connected_components(graph, directed=False)[0])
