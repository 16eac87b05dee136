"""Writing mesh files: STL, OBJ, PLY, GLB."""

from __future__ import annotations

from pathlib import Path

from touchwarp.errors import OutputError
from touchwarp.outputs import replacing
from touchwarp.scene.nearest import suggest
from touchwarp.scene.surface import Surface
from touchwarp.scene.units import up_rotation

FORMATS = ("stl", "obj", "ply", "glb")


def mesh_format(path: Path) -> str:
    """The format that a file's name asks for; raises OutputError where it is none of `FORMATS`."""
    ending = path.suffix.lower().lstrip(".")
    if ending not in FORMATS:
        raise OutputError(
            f"{path.name} has the ending '{path.suffix}', in which no mesh can be written. "
            f"{suggest(ending, FORMATS)}"
        )
    return ending


def write_mesh(path: Path, surface: Surface, metres: float = 1.0) -> None:
    """Write a surface (m, z up) in a unit of so many metres; a GLB in metres, y up, as glTF asks.

    Raises:
        OutputError: the ending is none of `FORMATS`, or the file cannot be written.
    """
    import trimesh

    ending = mesh_format(path)
    vertices = surface.vertices / metres
    if ending == "glb":
        vertices = surface.vertices @ up_rotation("y")
    mesh = trimesh.Trimesh(vertices, surface.faces, process=False)
    with replacing(path) as temporary:
        mesh.export(str(temporary), file_type=ending)
