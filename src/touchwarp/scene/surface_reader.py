"""Surfaces as the scene file's tables describe them: a mesh file, a shape or a polygon, posed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import SceneError
from touchwarp.scene.mesh_file import read_mesh
from touchwarp.scene.pose import pose_matrix
from touchwarp.scene.shapes import SHAPES, make_shape, polygon, shape_keys
from touchwarp.scene.surface import Surface
from touchwarp.scene.table import Table, within
from touchwarp.scene.units import METRES, UP_AXES

SURFACE_KEYS = ("mesh", "unit", "up", "shape", "polygon", "pose")


@dataclass(frozen=True)
class SurfaceReader:
    """Reads the surfaces of one scene file.

    Attributes:
        dimension: of the scene: 2 or 3.
        directory: the folder that relative paths start from.
    """

    dimension: int
    directory: Path

    def surface(self, table: Table, prefix: str = "") -> Surface:
        """The surface that a table's keys mesh, shape or polygon describe, posed.

        Args:
            table: a table of the scene file.
            prefix: what stands before the words mesh, shape and polygon in the keys' names.

        Raises:
            SceneError: none or several of the keys are there, or the surface cannot be had.
        """
        sources: dict[str, Callable[[Table, str], Surface]] = {
            f"{prefix}mesh": self._mesh,
            f"{prefix}shape": self._shape,
            f"{prefix}polygon": self._polygon,
        }
        given = [key for key in sources if key in table]
        mesh, shape, outline = sources
        usual = outline if self.dimension == 2 else f"{mesh} or {shape}"
        if len(given) != 1:
            raise SceneError(
                f"{table.where} has {' and '.join(given) or 'no surface'}; exactly one of "
                f"{', '.join(sources)} is needed (in {self.dimension}-D: {usual})."
            )
        if (given[0] == outline) != (self.dimension == 2):
            raise SceneError(
                f"{table.path(given[0])} does not fit a {self.dimension}-D scene; {usual} is "
                "needed there."
            )
        for key in ("unit", "up"):
            if key in table and given[0] != mesh:
                raise SceneError(
                    f"{table.path(key)} goes with {mesh} only; a {given[0]} is in metres, z up."
                )
        surface = sources[given[0]](table, given[0])
        T_scene_file = self.pose(table)
        return surface if T_scene_file is None else surface.transformed(T_scene_file)

    def pose(self, table: Table) -> NDArray[np.float64] | None:
        """The table's pose as a (d+1, d+1) matrix, or None where it has none."""
        pose = table.table("pose", ("position", "rotation_deg"))
        if not pose.entries:
            return None
        d = self.dimension
        position = pose.vector("position", d, (0.0,) * d)
        rotation = pose.rotation("rotation_deg", d, 0.0 if d == 2 else (0.0, 0.0, 0.0))
        return pose_matrix(position, rotation)

    def _mesh(self, table: Table, key: str) -> Surface:
        if isinstance(table.raw(key), dict):
            given = table.table(key, ("digest", "vertices", "faces"))
            raise SceneError(
                f"{table.path(key)} was given as arrays (SHA-256 {given.text('digest')}), which "
                "no scene file holds; build the scene in code, or name a mesh file."
            )
        unit = table.raw("unit", None)
        if isinstance(unit, str):
            unit = table.choice("unit", METRES)
        elif unit is not None:
            unit = table.number("unit")
        up = table.choice("up", UP_AXES, None)
        with within(table.where):
            return read_mesh(self.directory / table.text(key), unit, up)

    def _shape(self, table: Table, key: str) -> Surface:
        raw = table.raw(key)
        where = table.path(key)
        kind = Table(raw, where, raw if isinstance(raw, dict) else ()).choice("kind", SHAPES)
        shape = Table(raw, where, ("kind", *shape_keys(kind)))
        values = {
            key: shape.vector(key, 3) if key == "size" else shape.number(key)
            for key in shape.entries
            if key != "kind"
        }
        with within(where):
            return make_shape(kind, values)

    def _polygon(self, table: Table, key: str) -> Surface:
        corners = table.rows(key, 2)
        with within(table.path(key)):
            return polygon(corners)


def origin_of(table: Table, keys: Sequence[str] = SURFACE_KEYS) -> dict[str, Any]:
    """Those of the table's keys that describe a surface, as the file has them."""
    return {key: table.entries[key] for key in keys if key in table}
