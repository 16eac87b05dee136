"""The virtual object of a goal: what `virtual_mesh` or `virtual_shape` in [prop.goal] say."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from touchwarp.errors import GoalError
from touchwarp.scene.surface import Surface, surface_digest
from touchwarp.scene.surface_reader import SurfaceReader, origin_of
from touchwarp.scene.table import Table

VIRTUAL_KEYS = ("virtual_mesh", "virtual_shape", "unit", "up", "pose")


def read_virtual(table: Table, surfaces: SurfaceReader) -> dict[str, Any]:
    """The virtual object's `virtual` surface, posed, and its `origin`: the keys that say it.

    Raises:
        GoalError: the scene is a plane one.
        SceneError: the surface is missing, given twice, or cannot be read.
    """
    if surfaces.dimension != 3:
        raise GoalError(
            f"{table.path('kind')} is '{table.raw('kind')}', which maps surfaces in space, but the "
            "scene is 2-D; there write a transform, or give a Goal from code."
        )
    return {
        "virtual": surfaces.surface(table, prefix="virtual_"),
        "origin": origin_of(table, VIRTUAL_KEYS),
    }


def virtual_entries(virtual: Surface, origin: Mapping[str, Any]) -> dict[str, Any]:
    """The keys that say what the virtual object is; for one made in code, its digest and counts."""
    if origin:
        return dict(origin)
    return {
        "virtual_mesh": {
            "digest": surface_digest(virtual),
            "vertices": len(virtual.vertices),
            "faces": len(virtual.faces),
        }
    }


def require_surface(kind: str, virtual: object) -> None:
    """Raise GoalError unless `virtual` is a surface in space."""
    if not isinstance(virtual, Surface):
        raise GoalError(
            f"the virtual object of a {kind} goal is a {type(virtual).__name__}; a Surface "
            "(vertices in m, faces) is needed; read_mesh makes one from a file."
        )
    if virtual.dimension != 3:
        raise GoalError(
            f"the virtual object of a {kind} goal is {virtual.dimension}-D; a surface in space "
            "is needed."
        )
