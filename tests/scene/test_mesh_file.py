"""Mesh files are read in their own unit and axes, and bad ones are refused."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest
import trimesh

from touchwarp.errors import SceneError
from touchwarp.scene import mesh_file, read_mesh

SIZE = np.array([10.0, 20.0, 30.0])
FORMATS = ["stl", "obj", "ply", "glb", "gltf", "3mf"]
UNITLESS = ["stl", "obj", "ply"]


def write_box(folder: Path, extension: str) -> Path:
    """A box of 10 × 20 × 30 file units with a corner at the origin."""
    mesh = trimesh.creation.box(bounds=[np.zeros(3), SIZE])
    path = folder / f"box.{extension}"
    if extension == "gltf":
        for name, data in trimesh.Scene(mesh).export(file_type="gltf").items():
            (folder / name).write_bytes(data)
        (folder / "model.gltf").rename(path)
    else:
        mesh.export(path)
    return path


def declare_unit(path: Path, unit: str) -> None:
    """Change the unit that a 3MF file declares."""
    with zipfile.ZipFile(path) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in parts.items():
            archive.writestr(name, data.replace(b'"millimeter"', f'"{unit}"'.encode()))


def refused(path: Path, unit: str | float | None = "mm", up: str | None = None) -> str:
    with pytest.raises(SceneError) as error:
        read_mesh(path, unit, up)
    return str(error.value)


@pytest.mark.parametrize("extension", FORMATS)
def test_every_format_gives_the_same_welded_box(tmp_path: Path, extension: str) -> None:
    surface = read_mesh(write_box(tmp_path, extension), "mm", "z")
    assert surface.vertices.shape == (8, 3)
    assert surface.faces.shape == (12, 3)
    assert surface.bounds == pytest.approx(np.stack([0 * SIZE, SIZE * 1e-3]), abs=1e-9)


@pytest.mark.parametrize("extension", UNITLESS)
def test_a_format_without_unit_needs_one(tmp_path: Path, extension: str) -> None:
    message = refused(write_box(tmp_path, extension), None)
    assert f"the unit is missing, and {extension.upper()} files carry none" in message
    assert '"mm" if the mesh is 10 × 20 × 30 mm' in message
    assert '"m" if it is 1e+04 × 2e+04 × 3e+04 mm' in message


@pytest.mark.parametrize(
    ("unit", "metres"),
    [("mm", 1e-3), ("cm", 1e-2), ("m", 1.0), ("in", 0.0254), ("ft", 0.3048), (0.04, 0.04)],
)
def test_units_scale_the_mesh(tmp_path: Path, unit: str | float, metres: float) -> None:
    path = write_box(tmp_path, "stl")
    assert read_mesh(path, unit).bounds[1] == pytest.approx(SIZE * metres)
    other = "cm" if unit == "in" else "in"
    assert read_mesh(path, other).bounds[1] != pytest.approx(SIZE * metres)


def test_gltf_is_in_metres_and_y_up_unless_told(tmp_path: Path) -> None:
    path = write_box(tmp_path, "glb")
    assert read_mesh(path).bounds.tolist() == [[0, -30, 0], [10, 0, 20]]
    assert read_mesh(path, up="z").bounds.tolist() == [[0, 0, 0], [10, 20, 30]]
    assert read_mesh(path, "cm").bounds[1, 2] == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("word", "metres"), [("millimeter", 1e-3), ("inch", 0.0254), ("foot", 0.3048)]
)
def test_3mf_declares_its_unit(tmp_path: Path, word: str, metres: float) -> None:
    path = write_box(tmp_path, "3mf")
    declare_unit(path, word)
    assert read_mesh(path).bounds[1] == pytest.approx(SIZE * metres)
    assert read_mesh(path, "m").bounds[1] == pytest.approx(SIZE)


def test_3mf_with_a_foreign_unit_is_refused(tmp_path: Path) -> None:
    path = write_box(tmp_path, "3mf")
    declare_unit(path, "metre")
    assert "declares the unit 'metre'. Did you mean 'meter'?" in refused(path, None)


@pytest.mark.parametrize(
    ("up", "axis", "sign"),
    [("x", 0, 1), ("y", 1, 1), ("z", 2, 1), ("-x", 0, -1), ("-y", 1, -1), ("-z", 2, -1)],
)
def test_the_up_axis_becomes_z_without_mirroring(
    tmp_path: Path, up: str, axis: int, sign: int
) -> None:
    surface = read_mesh(write_box(tmp_path, "stl"), "m", up)
    low, high = surface.bounds
    assert high[2] - low[2] == SIZE[axis]
    assert (high[2] if sign > 0 else -low[2]) == SIZE[axis]
    corners = surface.vertices[surface.faces]
    volume = np.linalg.det(corners).sum() / 6
    assert volume == pytest.approx(6000.0)


def test_objects_of_an_obj_are_joined_in_place(tmp_path: Path) -> None:
    path = tmp_path / "two.obj"
    path.write_text(
        "o first\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1/1 2/1 3/1\n"
        "o second\nv 0 0 5\nv 1 0 5\nv 1 1 5\nv 0 1 5\nusemtl b\nf -4 -3 -2 -1\n"
    )
    surface = read_mesh(path, "m")
    assert surface.faces.shape == (3, 3)  # a quad is two triangles
    assert surface.vertices.shape == (7, 3)
    assert surface.bounds.tolist() == [[0, 0, 0], [1, 1, 5]]


def test_nodes_of_a_gltf_stand_where_the_file_places_them(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    ball = trimesh.creation.box((2, 2, 2))
    scene.add_geometry(ball, geom_name="ball")
    shifted = np.eye(4)
    shifted[:3, 3] = [10, 0, 0]
    mirrored = np.diag([1.0, 1.0, -1.0, 1.0])
    mirrored[:3, 3] = [20, 0, 0]
    for name, T_scene_ball in (("shifted", shifted), ("mirrored", mirrored)):
        scene.graph.update(name, matrix=T_scene_ball, geometry="ball")
    path = tmp_path / "three.glb"
    scene.export(path)
    surface = read_mesh(path, up="z")
    assert surface.bounds.tolist() == [[-1, -1, -1], [21, 1, 1]]
    volume = np.linalg.det(surface.vertices[surface.faces]).sum() / 6
    assert volume == pytest.approx(24.0)  # the mirrored box is turned outward again


def test_an_obj_may_hold_names_in_another_encoding(tmp_path: Path) -> None:
    path = tmp_path / "latin.obj"
    path.write_bytes("o Größe\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".encode("latin-1"))
    assert read_mesh(path, "m").vertices.shape == (3, 3)


def test_a_missing_file_names_the_nearest(tmp_path: Path) -> None:
    write_box(tmp_path, "stl")
    assert "box.stk does not exist. The nearest name there is 'box.stl'." in refused(
        tmp_path / "box.stk"
    )
    assert "does not exist. Check the name" in refused(tmp_path / "no" / "such.stl")


def test_a_folder_is_refused(tmp_path: Path) -> None:
    assert "is a folder; a mesh file is needed" in refused(tmp_path)


def test_an_unreadable_file_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_box(tmp_path, "stl")

    def deny(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", deny)
    assert "cannot be read: Permission denied." in refused(path)


def test_an_unknown_ending_is_refused(tmp_path: Path) -> None:
    (tmp_path / "mug.st1").write_text("solid")
    assert "the ending '.st1', which is not a mesh format read here. Did you mean 'stl'?" in (
        refused(tmp_path / "mug.st1")
    )


def test_an_empty_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "mug.ply").touch()
    assert "mug.ply is empty; export the mesh again" in refused(tmp_path / "mug.ply")


@pytest.mark.parametrize("extension", FORMATS)
def test_what_is_no_mesh_is_refused(tmp_path: Path, extension: str) -> None:
    path = tmp_path / f"letter.{extension}"
    path.write_text("Dear reader, this is a letter.")
    message = refused(path)
    assert f"letter.{extension} cannot be read as" in message or (
        f"letter.{extension} has no faces; a mesh with at least one triangle is needed" in message
    )


def test_a_truncated_stl_is_refused(tmp_path: Path) -> None:
    path = write_box(tmp_path, "stl")
    path.write_bytes(path.read_bytes()[:-20] + b"\xff")
    assert "neither a complete binary STL nor a text one; it may be truncated" in refused(path)


def test_a_missing_reader_package_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_box(tmp_path, "3mf")

    def fail(*_: object, **__: object) -> None:
        raise ImportError("No module named 'lxml'")

    monkeypatch.setattr(trimesh, "load_scene", fail)
    assert "reading 3MF needs a package that is missing (No module named 'lxml')" in refused(path)


def test_a_point_cloud_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "cloud.ply"
    trimesh.PointCloud(np.eye(3)).export(path)
    assert "cloud.ply has no faces" in refused(path)


@pytest.mark.parametrize("bad", ["nan", "inf"])
def test_vertices_that_are_not_finite_are_refused(tmp_path: Path, bad: str) -> None:
    path = tmp_path / "bad.obj"
    path.write_text(f"v 0 0 {bad}\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert "bad.obj: 1 of 3 vertices are NaN or infinite" in refused(path)


def test_faces_without_extent_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "point.obj"
    path.write_text("v 0 0 0\nv 0 0 0\nv 0 1 0\nf 1 2 3\n")
    assert "point.obj: all 1 faces have two corners at one point" in refused(path)


def test_units_and_axes_must_be_known(tmp_path: Path) -> None:
    path = write_box(tmp_path, "stl")
    assert "unknown unit 'inch'. Did you mean 'in'? Known: mm, cm, m, in, ft." in refused(
        path, "inch"
    )
    assert "a finite number of metres > 0 is needed" in refused(path, -1.0)
    assert "or a number of metres, is needed" in refused(path, [1])  # type: ignore[arg-type]
    assert "unknown up axis 'w'. Known: x, y, z, -x, -y, -z." in refused(path, "mm", "w")


def test_reading_joins_no_vertices_by_tolerance(tmp_path: Path) -> None:
    path = tmp_path / "thin.obj"
    path.write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1e-9\nv 1 0 1e-9\nv 0 1 1e-9\nf 1 2 3\nf 4 5 6\n"
    )
    assert len(read_mesh(path, "m").vertices) == 6


def test_formats_are_those_of_the_docs() -> None:
    assert set(mesh_file.FORMATS) == set(FORMATS)
