"""Triangle (or, in the plane, segment) surfaces as plain frozen arrays."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import SceneError


@dataclass(frozen=True, eq=False)
class Surface:
    """A surface: triangles in space, or segments in the plane.

    Nothing is asked of its topology: it may be open, self-intersecting, non-manifold or in pieces.

    Attributes:
        vertices: (n, d) float64 m, scene frame; d = 3, or 2 in a plane scene.
        faces: (m, d) int64, rows of vertex indices: triangles for d = 3, segments for d = 2.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]

    def __post_init__(self) -> None:
        vertices = np.ascontiguousarray(self.vertices, dtype=np.float64)
        faces = np.ascontiguousarray(self.faces, dtype=np.int64)
        if vertices.ndim != 2 or vertices.shape[1] not in (2, 3):
            raise SceneError(
                f"A surface's vertices have shape {vertices.shape}; (n, 3) or (n, 2) is needed."
            )
        if faces.ndim != 2 or faces.shape[1] != vertices.shape[1]:
            raise SceneError(
                f"A surface's faces have shape {faces.shape}; (m, {vertices.shape[1]}) is needed "
                f"with vertices of shape {vertices.shape}."
            )
        if len(faces) == 0:
            raise SceneError("A surface has no faces; a mesh with at least one face is needed.")
        if not np.isfinite(vertices).all():
            bad = int((~np.isfinite(vertices).all(axis=1)).sum())
            raise SceneError(
                f"{bad} of {len(vertices)} vertices are NaN or infinite; "
                "finite coordinates are needed: export the mesh again or remove those vertices."
            )
        if faces.min() < 0 or faces.max() >= len(vertices):
            raise SceneError(
                f"Faces refer to vertices {faces.min()} to {faces.max()}, but there are "
                f"{len(vertices)} vertices: the mesh is damaged; export it again."
            )
        vertices.setflags(write=False)
        faces.setflags(write=False)
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "faces", faces)

    @property
    def dimension(self) -> int:
        """3 for triangles in space, 2 for segments in the plane."""
        return int(self.vertices.shape[1])

    @cached_property
    def bounds(self) -> NDArray[np.float64]:
        """(2, d) m, scene frame: least and greatest coordinates of the vertices that faces use."""
        used = self.used_vertices
        bounds = np.stack([used.min(axis=0), used.max(axis=0)])
        bounds.setflags(write=False)
        return bounds

    @property
    def used_vertices(self) -> NDArray[np.float64]:
        """(k, d) m, scene frame: the vertices that faces use."""
        used = np.zeros(len(self.vertices), dtype=np.bool_)
        used[self.faces] = True
        return self.vertices if used.all() else np.asarray(self.vertices[used])

    def transformed(self, T_new_old: NDArray[np.float64]) -> Surface:
        """The surface mapped by an affine (d+1, d+1) matrix."""
        d = self.dimension
        return Surface(self.vertices @ T_new_old[:d, :d].T + T_new_old[:d, d], self.faces)


def surface_digest(surface: Surface) -> str:
    """SHA-256 of faces and vertices; vertices are rounded to 0.1 µm.

    Without rounding, the last bit of a posed vertex would differ from one machine to the next.
    """
    digest = hashlib.sha256(np.rint(surface.vertices * 1e7).astype("<i8").tobytes())
    digest.update(surface.faces.astype("<i8").tobytes())
    return digest.hexdigest()
