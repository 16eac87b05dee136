"""Reading mesh files: STL, OBJ, PLY, GLB, glTF and 3MF."""

from __future__ import annotations

import difflib
import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import SceneError
from touchwarp.scene.nearest import suggest
from touchwarp.scene.surface import Surface
from touchwarp.scene.table import within
from touchwarp.scene.units import METRES, metres_per_unit, up_rotation
from touchwarp.scene.weld import weld

FORMATS = ("stl", "obj", "ply", "glb", "gltf", "3mf")

# The six words that 3MF's core specification allows.
_METRES_3MF = {
    "micron": 1e-6,
    "millimeter": 1e-3,
    "centimeter": 1e-2,
    "inch": 0.0254,
    "foot": 0.3048,
    "meter": 1.0,
}


@dataclass(frozen=True, eq=False)
class RawMesh:
    """A mesh as its file has it.

    Attributes:
        vertices: (n, 3) in the file's unit and axes; corners of STL triangles are not yet welded.
        faces: (m, 3) int64.
        metres: metres in the file's unit, or None where the format has no unit.
        up: the up axis that the format defines; "z" where it defines none.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    metres: float | None
    up: str


def read_mesh(path: str | Path, unit: str | float | None = None, up: str | None = None) -> Surface:
    """Read a mesh file as one surface in metres, z up, equal vertices welded.

    All objects of the file are joined, each where the file places it.

    Args:
        path: an STL, OBJ, PLY, GLB, glTF or 3MF file.
        unit: "mm", "cm", "m", "in", "ft", or a number of metres. Needed for STL, OBJ and PLY; for
            the others it overrides what the format says.
        up: the file's up axis, "x", "y", "z", "-x", "-y" or "-z"; by default "y" for
            glTF and "z" for the others.

    Raises:
        SceneError: the file is missing, unreadable, no mesh, has no faces or NaN vertices; the
            unit is missing or unknown.
    """
    path = Path(path)
    raw = read_raw_mesh(path)
    with within(path.name):
        if unit is None and raw.metres is None:
            raise SceneError(unit_question(path, Surface(raw.vertices, raw.faces)))
        metres = raw.metres if unit is None else metres_per_unit(unit)
        rotation = up_rotation(raw.up if up is None else up)
        vertices, faces = weld(raw.vertices, raw.faces)
        if len(faces) == 0:
            raise SceneError(
                f"all {len(raw.faces)} faces have two corners at one point; a mesh with at least "
                "one proper face is needed."
            )
        assert metres is not None
        return Surface(vertices @ (metres * rotation).T, faces)


def read_raw_mesh(path: str | Path) -> RawMesh:
    """Read a mesh file without welding, unit or axes; raises SceneError as `read_mesh` does."""
    path = Path(path)
    extension = check_mesh_file(path)
    loaded = load_mesh_file(path, extension)
    parts = _parts(loaded)
    if not parts:
        raise SceneError(
            f"{path.name} has no faces; a mesh with at least one triangle is needed. Perhaps it "
            f"is a point cloud, which must be meshed first, or no {extension.upper()} file at all."
        )
    vertices, faces = parts[0]
    if len(parts) > 1:
        offsets = np.cumsum([0] + [len(v) for v, _ in parts[:-1]])
        vertices = np.concatenate([v for v, _ in parts])
        faces = np.concatenate([f + o for (_, f), o in zip(parts, offsets, strict=True)])
    with within(path.name):
        Surface(vertices, faces)
    metres = None
    if extension in ("glb", "gltf"):
        metres = 1.0
    elif extension == "3mf":
        metres = _metres_3mf(path, loaded)
    return RawMesh(vertices, faces, metres, "y" if extension in ("glb", "gltf") else "z")


def check_mesh_file(path: Path) -> str:
    """The file's ending in lower case; raises SceneError unless it is a mesh file's."""
    if path.is_dir():
        raise SceneError(f"{path} is a folder; a mesh file is needed.")
    if not path.exists():
        near = []
        if path.parent.is_dir():
            near = difflib.get_close_matches(path.name, [p.name for p in path.parent.iterdir()], 1)
        hint = f"The nearest name there is '{near[0]}'." if near else "Check the name and folder."
        raise SceneError(f"mesh file {path} does not exist. {hint}")
    extension = path.suffix.lower().lstrip(".")
    if extension not in FORMATS:
        raise SceneError(
            f"{path.name} has the ending '{path.suffix}', which is not a mesh format read here. "
            f"{suggest(extension, FORMATS)} Export the mesh in one of these."
        )
    try:
        with path.open("rb") as stream:
            empty = not stream.read(1)
    except OSError as error:
        raise SceneError(f"mesh file {path} cannot be read: {error.strerror or error}.") from error
    if empty:
        raise SceneError(f"{path.name} is empty; export the mesh again.")
    return extension


def load_mesh_file(path: Path, extension: str, with_uv: bool = False) -> Any:
    """The file as a trimesh scene, nothing merged or reordered; raises SceneError."""
    import trimesh

    # process=False: no merging by tolerance and no reordering; welding here is exact.
    options: dict[str, Any] = {"process": False, "skip_materials": not with_uv}
    try:
        if extension == "obj":
            text = path.read_bytes()
            try:
                text.decode("utf-8")
            except UnicodeDecodeError:
                # Names and comments in another encoding; the numbers are ASCII in all of them.
                text = text.decode("latin-1").encode("utf-8")
            return trimesh.load_scene(io.BytesIO(text), file_type="obj", **options)
        return trimesh.load_scene(str(path), **options)
    except Exception as error:  # trimesh's readers raise whatever their parsing meets
        if isinstance(error, ImportError) and extension == "3mf":
            raise SceneError(
                f"{path.name}: reading 3MF needs a package that is missing ({error}); install "
                "lxml and networkx, or export the mesh in another format."
            ) from error
        reason = f"{type(error).__name__}: {str(error).strip()[:200] or 'no message'}"
        if extension == "stl":
            reason = "it is neither a complete binary STL nor a text one; it may be truncated"
        raise SceneError(
            f"{path.name} cannot be read as {extension.upper()} ({reason}). Open it in a mesh "
            "viewer and export it again."
        ) from error


def _parts(loaded: Any) -> list[tuple[NDArray[np.float64], NDArray[np.int64]]]:
    """Vertices and faces of every placed mesh in a trimesh scene."""
    parts = []
    for node in loaded.graph.nodes_geometry:
        T_file_object, name = loaded.graph[node]
        mesh = loaded.geometry[name]
        faces = getattr(mesh, "faces", None)
        if faces is None or len(faces) == 0:
            continue
        vertices = np.asarray(mesh.vertices, dtype=np.float64)
        faces = np.asarray(faces, dtype=np.int64)
        if not np.array_equal(T_file_object, np.eye(4)):
            vertices = vertices @ T_file_object[:3, :3].T + T_file_object[:3, 3]
            if np.linalg.det(T_file_object[:3, :3]) < 0:
                faces = faces[:, ::-1]
        parts.append((vertices, faces))
    return parts


def _metres_3mf(path: Path, loaded: Any) -> float:
    words = {str(m.units).rstrip("s") for m in loaded.geometry.values() if m.units}
    word = words.pop() if len(words) == 1 else "millimeter"
    if word not in _METRES_3MF:
        raise SceneError(f"{path.name} declares the unit '{word}'. {suggest(word, _METRES_3MF)}")
    return _METRES_3MF[word]


def unit_question(path: Path, surface: Surface) -> str:
    """What to tell about a file without unit; its surface is in the file's."""
    extent = np.ptp(surface.bounds, axis=0)

    def size(unit: str) -> str:
        return " × ".join(f"{e * METRES[unit] * 1e3:.4g}" for e in extent) + " mm"

    return (
        f"the unit is missing, and {path.suffix.lstrip('.').upper()} files carry none. "
        f'Write unit = "mm" if the mesh is {size("mm")}, "cm" if it is {size("cm")}, '
        f'"m" if it is {size("m")} ("in" and "ft" are known too).'
    )
