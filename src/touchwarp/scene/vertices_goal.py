"""The goal of a mesh that was deformed in a modelling tool: vertex i shows at vertex i."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Self

from touchwarp.scene.surface import Surface
from touchwarp.scene.surface_reader import SurfaceReader
from touchwarp.scene.table import Table
from touchwarp.scene.virtual_object import (
    VIRTUAL_KEYS,
    read_virtual,
    require_surface,
    virtual_entries,
)


@dataclass(frozen=True, eq=False)
class VerticesGoal:
    """Vertex i of the prop shows at vertex i of the virtual object: the same mesh, deformed.

    Attributes:
        virtual: the virtual object, m, scene frame.
        origin: the scene-file keys that describe it; empty for one given as arrays.
    """

    kind: ClassVar[str] = "vertices"
    keys: ClassVar[tuple[str, ...]] = VIRTUAL_KEYS

    virtual: Surface
    origin: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        require_surface(self.kind, self.virtual)

    @classmethod
    def read(cls, table: Table, surfaces: SurfaceReader) -> Self:
        """From the table [prop.goal] of a scene file; keys are checked by the caller."""
        return cls(**read_virtual(table, surfaces))

    def entries(self) -> dict[str, Any]:
        """The keys of the scene file."""
        return virtual_entries(self.virtual, self.origin)
