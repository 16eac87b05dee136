"""The goal of a displacement texture: the paper's Shape Changing Texture Map."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.scene import goal_numbers
from touchwarp.scene.surface import Surface, surface_digest
from touchwarp.scene.surface_reader import SurfaceReader, origin_of
from touchwarp.scene.table import Table, within
from touchwarp.scene.texture_file import read_texture
from touchwarp.scene.uv_mesh import UvMesh, read_uv_mesh

_ATLAS_KEYS = ("texture", "texture_scale", "uv_mesh", "unit", "up", "pose")


@dataclass(frozen=True, eq=False)
class TextureGoal:
    """A point shows where the texture's colour at its texture coordinates displaces it to.

    Attributes:
        displacement: (h, w, 3) m, scene axes: x, y, z in red, green, blue; the first row is the
            top one, v = 1.
        atlas: the prop's surface with texture coordinates, m, scene frame.
        tolerance_mm: how far the texture may stray from its linear interpolation on the atlas's
            triangles; they are subdivided until it is met.
        origin: the scene-file keys that describe both; empty for those given as arrays.

    Raises:
        GoalError: the texture's shape is another, or it has NaN; no UvMesh is given.
    """

    kind: ClassVar[str] = "texture"
    keys: ClassVar[tuple[str, ...]] = (*_ATLAS_KEYS, "tolerance_mm")

    displacement: NDArray[np.float64]
    atlas: UvMesh
    tolerance_mm: float = 0.05
    origin: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        displacement = np.array(self.displacement, dtype=np.float64)
        if displacement.ndim != 3 or displacement.shape[2] != 3 or 0 in displacement.shape:
            raise GoalError(
                f"the texture has the shape {displacement.shape}; (height, width, 3) is needed: "
                "the displacement's x, y and z."
            )
        bad = int((~np.isfinite(displacement)).any(axis=2).sum())
        if bad:
            raise GoalError(
                f"{bad} of the texture's {displacement[..., 0].size} pixels are NaN or infinite; "
                "finite displacements are needed."
            )
        if not isinstance(self.atlas, UvMesh):
            raise GoalError(
                f"the texture's atlas is a {type(self.atlas).__name__}; a UvMesh is needed."
            )
        displacement.setflags(write=False)
        object.__setattr__(self, "displacement", displacement)
        tolerance_mm = goal_numbers.number("tolerance_mm", self.tolerance_mm, 0.0, above=True)
        object.__setattr__(self, "tolerance_mm", tolerance_mm)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the texture, the atlas and its coordinates, rounded to 0.1 µm and 10⁻⁷."""
        digest = hashlib.sha256(np.rint(self.displacement * 1e7).astype("<i8").tobytes())
        digest.update(np.rint(self.atlas.uv * 1e7).astype("<i8").tobytes())
        atlas = surface_digest(Surface(self.atlas.vertices, self.atlas.faces))
        digest.update(atlas.encode())
        return digest.hexdigest()

    @classmethod
    def read(cls, table: Table, surfaces: SurfaceReader) -> Self:
        """From the table [prop.goal] of a scene file; keys are checked by the caller."""
        if surfaces.dimension != 3:
            raise GoalError("a texture displaces surfaces in space, but the scene is 2-D.")
        for key in ("texture", "uv_mesh"):
            if isinstance(table.raw(key), dict):
                raise GoalError(
                    f"{table.path(key)} was given as arrays, which no scene file holds; build the "
                    "scene in code, or name a file."
                )
        scale = table.number("texture_scale", None)
        with within(table.where):
            displacement = read_texture(surfaces.directory / table.text("texture"), scale)
            atlas = read_uv_mesh(
                surfaces.directory / table.text("uv_mesh"),
                table.raw("unit", None),
                table.raw("up", None),
            )
        T_scene_file = surfaces.pose(table)
        if T_scene_file is not None:
            displacement = displacement @ T_scene_file[:3, :3].T
            atlas = atlas.transformed(T_scene_file)
        return cls(
            displacement,
            atlas,
            table.number("tolerance_mm", cls.tolerance_mm),
            origin_of(table, _ATLAS_KEYS),
        )

    def entries(self) -> dict[str, Any]:
        """The keys of the scene file."""
        h, w, _ = self.displacement.shape
        made: Mapping[str, Any] = {
            "texture": {"width": w, "height": h},
            "uv_mesh": {"vertices": len(self.atlas.vertices), "faces": len(self.atlas.faces)},
        }
        return {**(self.origin or made), "tolerance_mm": self.tolerance_mm}
