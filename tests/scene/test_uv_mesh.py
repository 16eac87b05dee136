"""Meshes with texture coordinates are read as the file has them, seams kept."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from touchwarp.errors import SceneError
from touchwarp.scene import UvMesh, read_uv_mesh

VERTICES = np.array([[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0], [1, 0, 0], [1, 2, 0]], float)
FACES = np.array([[0, 1, 3], [4, 5, 3]])
UV = np.array([[0.1, 0.1], [0.4, 0.1], [0.4, 0.9], [0.1, 0.9], [0.6, 0.2], [0.6, 0.7]])


def written(path: Path, uv: np.ndarray | None = UV) -> Path:
    mesh = trimesh.Trimesh(VERTICES, FACES, process=False)
    if uv is not None:
        mesh.visual = trimesh.visual.TextureVisuals(uv=uv)
    mesh.export(path)
    return path


@pytest.mark.parametrize("ending", ["glb", "obj"])
def test_a_mesh_keeps_its_seams_and_coordinates(tmp_path: Path, ending: str) -> None:
    path = written(tmp_path / f"sheet.{ending}")
    mesh = read_uv_mesh(path, unit="m", up="z")
    corners = mesh.faces.ravel()
    np.testing.assert_allclose(mesh.uv[corners], UV[FACES.ravel()], atol=1e-7)
    np.testing.assert_allclose(mesh.vertices[corners], VERTICES[FACES.ravel()], atol=1e-7)


def test_unit_axis_and_pose(tmp_path: Path) -> None:
    path = written(tmp_path / "sheet.obj")
    mesh = read_uv_mesh(path, unit="mm", up="y")
    np.testing.assert_allclose(mesh.vertices.max(axis=0), [1e-3, 0, 2e-3], atol=1e-12)
    T = np.eye(4)
    T[:3, 3] = 1, 2, 3
    np.testing.assert_allclose(mesh.transformed(T).vertices, mesh.vertices + T[:3, 3])
    np.testing.assert_array_equal(mesh.transformed(T).uv, mesh.uv)


def test_what_is_wrong_is_told(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"sheet.obj: the unit is missing, and OBJ files carry"):
        read_uv_mesh(written(tmp_path / "sheet.obj"))
    with pytest.raises(SceneError, match=r"bare.obj: the mesh has no texture coordinates; unwrap"):
        read_uv_mesh(written(tmp_path / "bare.obj", None), unit="m")
    scene = trimesh.Scene([trimesh.creation.box(), trimesh.creation.icosphere(1)])
    scene.export(tmp_path / "two.glb")
    with pytest.raises(SceneError, match=r"two.glb: the file has 2 objects with faces; .* be one"):
        read_uv_mesh(tmp_path / "two.glb")
    with pytest.raises(SceneError, match=r"texture coordinates have the shape \(2, 2\); finite"):
        UvMesh(VERTICES, FACES, UV[:2])
    with pytest.raises(SceneError, match="texture coordinates have the shape"):
        UvMesh(VERTICES, FACES, UV * np.nan)
