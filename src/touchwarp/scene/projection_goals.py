"""Goals that carry points along straight lines: over planes, or out of a centre (Figure 7)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Self

from touchwarp.errors import GoalError
from touchwarp.scene import goal_numbers
from touchwarp.scene.surface import Surface
from touchwarp.scene.surface_reader import SurfaceReader
from touchwarp.scene.table import Table
from touchwarp.scene.virtual_object import (
    VIRTUAL_KEYS,
    read_virtual,
    require_surface,
    virtual_entries,
)


@dataclass(frozen=True)
class Patch:
    """A part of a surface that is a height field over a plane.

    Attributes:
        normal: (3,): the plane's normal; becomes a unit vector.
        point: (3,) m, scene frame: a point of the plane; the patch is what lies in front of it.
            None: the patch is the faces whose normals are nearer to this one than to the others'.
    """

    normal: Sequence[float]
    point: Sequence[float] | None = None

    def __post_init__(self) -> None:
        if self.point is not None:
            object.__setattr__(self, "point", goal_numbers.point("patches.point", self.point))
        object.__setattr__(self, "normal", goal_numbers.direction("patches.normal", self.normal))

    def entries(self) -> dict[str, Any]:
        """The keys of the scene file."""
        return {k: v for k, v in (("point", self.point), ("normal", self.normal)) if v is not None}


@dataclass(frozen=True, eq=False)
class PlaneProjectionGoal:
    """Prop and virtual object are height fields over a plane, and share the projected position.

    With a `normal`, the whole prop is carried along it: what faces one way to what faces that way.
    With `patches`, each point of the prop is carried along the normal of its patch, the first that
    holds it; what is in front of no patch's plane stays where it is.

    Attributes:
        virtual: the virtual object, m, scene frame.
        normal: (3,): the plane's normal; becomes a unit vector.
        patches: instead of the normal, parts of the prop with a plane each.
        gap_mm: the greatest gap to forgive where patches meet one another or what stays.
        tolerance_mm: the greatest distance of the image of the prop's triangles from the virtual
            surface; they are subdivided until it is met.
        origin: the scene-file keys that describe the virtual object; empty for one given as arrays.

    Raises:
        GoalError: a number is out of range, or both normal and patches are given.
    """

    kind: ClassVar[str] = "plane_projection"
    keys: ClassVar[tuple[str, ...]] = (
        *VIRTUAL_KEYS,
        "normal",
        "patches",
        "gap_mm",
        "tolerance_mm",
    )

    virtual: Surface
    normal: Sequence[float] | None = None
    patches: Sequence[Patch] = ()
    gap_mm: float = 0.05
    tolerance_mm: float = 0.05
    origin: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        require_surface(self.kind, self.virtual)
        object.__setattr__(self, "patches", tuple(self.patches))
        if self.normal is None and not self.patches:
            raise GoalError(
                "goal has neither normal nor patches; give the normal of the plane that prop and "
                "virtual object are height fields over, or patches with a plane each."
            )
        if self.normal is not None:
            if self.patches:
                raise GoalError("goal.normal stands beside goal.patches; give either.")
            object.__setattr__(self, "normal", goal_numbers.direction("normal", self.normal))
        if len({patch.point is None for patch in self.patches}) > 1:
            raise GoalError(
                "some of goal.patches have a point and some have none; give all of them one (what "
                "is in front of a plane) or none (what faces along a normal)."
            )
        object.__setattr__(self, "gap_mm", goal_numbers.number("gap_mm", self.gap_mm, 0.0))
        tolerance_mm = goal_numbers.number("tolerance_mm", self.tolerance_mm, 0.0, above=True)
        object.__setattr__(self, "tolerance_mm", tolerance_mm)

    @classmethod
    def read(cls, table: Table, surfaces: SurfaceReader) -> Self:
        """From the table [prop.goal] of a scene file; keys are checked by the caller."""
        patches = []
        for where, entries in table.tables("patches"):
            patch = Table(entries, where, ("point", "normal"))
            patches.append(Patch(patch.vector("normal", 3), patch.vector("point", 3, None)))
        return cls(
            **read_virtual(table, surfaces),
            normal=table.vector("normal", 3, None),
            patches=patches,
            gap_mm=table.number("gap_mm", cls.gap_mm),
            tolerance_mm=table.number("tolerance_mm", cls.tolerance_mm),
        )

    def entries(self) -> dict[str, Any]:
        """The keys of the scene file."""
        over: dict[str, Any] = {"normal": self.normal}
        if self.patches:
            over = {"patches": [patch.entries() for patch in self.patches]}
        return {
            **virtual_entries(self.virtual, self.origin),
            **over,
            "gap_mm": self.gap_mm,
            "tolerance_mm": self.tolerance_mm,
        }


@dataclass(frozen=True, eq=False)
class DirectionGoal:
    """Star-shaped bodies share azimuth and polar angle about a centre (Figure 7b).

    Attributes:
        virtual: the virtual object, m, scene frame.
        centre: (3,) m, scene frame: a point that sees the whole of both surfaces; None to find it.
        virtual_centre: (3,) m, scene frame: the centre's place in the virtual object, where that
            is another one; None for the same.
        tolerance_mm, origin: as for `PlaneProjectionGoal`.

    Raises:
        GoalError: a number is out of range, or only the virtual centre is given.
    """

    kind: ClassVar[str] = "direction"
    keys: ClassVar[tuple[str, ...]] = (*VIRTUAL_KEYS, "centre", "virtual_centre", "tolerance_mm")

    virtual: Surface
    centre: Sequence[float] | None = None
    virtual_centre: Sequence[float] | None = None
    tolerance_mm: float = 0.05
    origin: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        require_surface(self.kind, self.virtual)
        for key in ("centre", "virtual_centre"):
            if getattr(self, key) is not None:
                object.__setattr__(self, key, goal_numbers.point(key, getattr(self, key)))
        if self.virtual_centre is not None and self.centre is None:
            raise GoalError("goal.virtual_centre stands without goal.centre; give both or neither.")
        tolerance_mm = goal_numbers.number("tolerance_mm", self.tolerance_mm, 0.0, above=True)
        object.__setattr__(self, "tolerance_mm", tolerance_mm)

    @classmethod
    def read(cls, table: Table, surfaces: SurfaceReader) -> Self:
        """From the table [prop.goal] of a scene file; keys are checked by the caller."""
        return cls(
            **read_virtual(table, surfaces),
            centre=table.vector("centre", 3, None),
            virtual_centre=table.vector("virtual_centre", 3, None),
            tolerance_mm=table.number("tolerance_mm", cls.tolerance_mm),
        )

    def entries(self) -> dict[str, Any]:
        """The keys of the scene file."""
        centres = {
            key: getattr(self, key)
            for key in ("centre", "virtual_centre")
            if getattr(self, key) is not None
        }
        return {
            **virtual_entries(self.virtual, self.origin),
            **centres,
            "tolerance_mm": self.tolerance_mm,
        }
