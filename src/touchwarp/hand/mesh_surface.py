"""Nearest points of a prop's mesh, for `contact="skin"`."""

from __future__ import annotations

from functools import cached_property

import igl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from touchwarp.scene.surface import Surface
from touchwarp.warp.posed import rigid

Float = NDArray[np.float64]


class MeshSurface:
    """A prop's surface as `HandOptions.surface` wants it.

    Normals are those of the vertices, interpolated, so that they turn smoothly around edges; faces
    must be turned outwards, as closed meshes' are.

    Args:
        surface: triangles, scene frame.

    Raises:
        ValueError: the surface is of a plane scene.
    """

    def __init__(self, surface: Surface) -> None:
        if surface.dimension != 3:
            raise ValueError("The surface is of segments in a plane; triangles are needed.")
        self._surface = surface
        self._T = np.eye(4)

    def place(self, T_room_scene: ArrayLike) -> None:
        """Carry the surface along with its prop.

        Raises:
            ValueError: T_room_scene is not rigid.
        """
        self._T = rigid(T_room_scene, "T_room_scene")

    def __call__(self, points: Float) -> tuple[Float, Float]:
        """Nearest points (n, 3) m and outward unit normals there, for points (n, 3) m, room frame.

        A point with a NaN gives NaN.
        """
        R, origin = self._T[:3, :3], self._T[:3, 3]
        local = np.ascontiguousarray((points - origin) @ R)
        lost = ~np.isfinite(local).all(axis=1)
        local[lost] = 0.0
        vertices, faces = self._surface.vertices, self._surface.faces
        _, face, nearest = self._tree.squared_distance(vertices, faces, local)
        corners = faces[face]
        shares = igl.barycentric_coordinates(
            np.ascontiguousarray(nearest), *(vertices[corners[:, n]] for n in range(3))
        )
        normals = np.einsum("nk,nkd->nd", shares, self._normals[corners])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        normals[lost] = np.nan
        return nearest @ R.T + origin, normals @ R.T

    @cached_property
    def _tree(self) -> igl.AABB:
        tree = igl.AABB()
        tree.init(self._surface.vertices, self._surface.faces)
        return tree

    @cached_property
    def _normals(self) -> Float:
        return np.asarray(igl.per_vertex_normals(self._surface.vertices, self._surface.faces))
