"""Meshes with texture coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import SceneError
from touchwarp.scene.mesh_file import check_mesh_file, load_mesh_file, unit_question
from touchwarp.scene.surface import Surface
from touchwarp.scene.table import within
from touchwarp.scene.units import metres_per_unit, up_rotation


@dataclass(frozen=True, eq=False)
class UvMesh:
    """Triangles with texture coordinates; a vertex on a seam is there once for each side.

    Attributes:
        vertices: (n, 3) m, scene frame.
        faces: (m, 3) int64.
        uv: (n, 2): (0, 0) is the texture's lower left corner, (1, 1) its upper right one.

    Raises:
        SceneError: the arrays do not fit together, or coordinates are not finite.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    uv: NDArray[np.float64]

    def __post_init__(self) -> None:
        surface = Surface(self.vertices, self.faces)
        uv = np.array(self.uv, dtype=np.float64)
        if uv.shape != (len(surface.vertices), 2) or not np.isfinite(uv).all():
            raise SceneError(
                f"texture coordinates have the shape {uv.shape}; finite ones of "
                f"({len(surface.vertices)}, 2) are needed, one for each vertex."
            )
        uv.setflags(write=False)
        for name, value in (("vertices", surface.vertices), ("faces", surface.faces), ("uv", uv)):
            object.__setattr__(self, name, value)

    def transformed(self, T_new_old: NDArray[np.float64]) -> UvMesh:
        """The mesh mapped by an affine (4, 4) matrix."""
        moved = Surface(self.vertices, self.faces).transformed(T_new_old)
        return UvMesh(moved.vertices, self.faces, self.uv)


def read_uv_mesh(
    path: str | Path, unit: str | float | None = None, up: str | None = None
) -> UvMesh:
    """Read a mesh file with texture coordinates: OBJ, PLY, GLB or glTF.

    Args:
        path, unit, up: as for `read_mesh`.

    Raises:
        SceneError: as `read_mesh`; the file has no texture coordinates, or several objects.
    """
    path = Path(path)
    extension = check_mesh_file(path)
    meshes = [
        m for m in load_mesh_file(path, extension, with_uv=True).dump() if hasattr(m, "faces")
    ]
    with within(path.name):
        if len(meshes) != 1:
            raise SceneError(
                f"the file has {len(meshes)} objects with faces; the texture's mesh must be one: "
                "join them."
            )
        (mesh,) = meshes
        vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
        uv = getattr(mesh.visual, "uv", None)
        if uv is None or len(uv) != len(vertices):
            raise SceneError(
                "the mesh has no texture coordinates; unwrap it, and export it with them "
                "(OBJ, PLY, GLB and glTF can hold them)."
            )
        is_gltf = extension in ("glb", "gltf")
        if unit is None and not is_gltf:
            raise SceneError(unit_question(path, Surface(vertices, faces)))
        metres = 1.0 if unit is None else metres_per_unit(unit)
        rotation = up_rotation(up or ("y" if is_gltf else "z"))
        return UvMesh(vertices @ (metres * rotation).T, faces, uv)
