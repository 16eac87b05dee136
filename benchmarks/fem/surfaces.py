"""Triangle meshes made ready for tetrahedral meshers."""

from __future__ import annotations

from pathlib import Path

import manifold3d
import numpy as np
import trimesh


def split_triangles(prop: trimesh.Trimesh, longest: float, beside: Path) -> Path:
    """A watertight mesh with its edges split to a length; written to split.stl in a folder.

    Args:
        prop: its slivers of less than a tenth of a unit are merged away.
        longest: length of edge left, in the mesh's unit.
        beside: a file in that folder.
    """
    prop.merge_vertices(digits_vertex=1)
    prop.update_faces(prop.nondegenerate_faces())
    prop.remove_unreferenced_vertices()
    solid = manifold3d.Manifold(
        manifold3d.Mesh(prop.vertices.astype(np.float32), prop.faces.astype(np.uint32))
    )
    fine = solid.refine_to_length(longest).to_mesh()
    path = beside.with_name("split.stl")
    vertices = np.asarray(fine.vert_properties)[:, :3]
    trimesh.Trimesh(vertices, np.asarray(fine.tri_verts), process=False).export(path)
    return path
