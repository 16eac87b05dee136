"""Goals that a search finds: one-to-one maps between surfaces of the same topology."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Self

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

WEIGHTS = (
    "displacement_weight",
    "smoothness_weight",
    "area_weight",
    "normal_weight",
    "curvature_weight",
)
AREA_WEIGHT = 0.5
"""Where none is given, at first: it is raised where areas spread too much."""
_SEARCH_KEYS = ("seed", "starts", "tolerance_mm")


@dataclass(frozen=True)
class Landmark:
    """A point of the prop and the point of the virtual object where it shall appear.

    Attributes:
        prop, virtual: (3,) m, scene frame; the nearest points of the surfaces are taken.
    """

    prop: Sequence[float]
    virtual: Sequence[float]

    def __post_init__(self) -> None:
        for key in ("prop", "virtual"):
            checked = goal_numbers.point(f"landmarks.{key}", getattr(self, key))
            object.__setattr__(self, key, checked)


@dataclass(frozen=True, eq=False)
class AreaPreservingGoal:
    """Equal shares of the prop's area show as equal shares of the virtual object's (Figure 8).

    Attributes:
        virtual: the virtual object, m, scene frame.
        seed: of everything random in the search.
        starts: how many initial maps the search tries.
        tolerance_mm: the greatest distance of the image of the prop's triangles from the virtual
            surface; they are subdivided until it is met.
        origin: the scene-file keys that describe the virtual object; empty for one given as arrays.

    Raises:
        GoalError: a number is out of range.
    """

    kind: ClassVar[str] = "area_preserving"
    keys: ClassVar[tuple[str, ...]] = (*VIRTUAL_KEYS, *_SEARCH_KEYS)

    virtual: Surface
    seed: int = 0
    starts: int = 3
    tolerance_mm: float = 0.05
    origin: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        require_surface(self.kind, self.virtual)
        _check_search(self)

    @classmethod
    def read(cls, table: Table, surfaces: SurfaceReader) -> Self:
        """From the table [prop.goal] of a scene file; keys are checked by the caller."""
        search = {key: table.number(key) for key in _SEARCH_KEYS if key in table}
        return cls(**read_virtual(table, surfaces), **search)

    def entries(self) -> dict[str, Any]:
        """The keys of the scene file."""
        search = {key: getattr(self, key) for key in _SEARCH_KEYS}
        return {**virtual_entries(self.virtual, self.origin), **search}


@dataclass(frozen=True, eq=False)
class MatchGoal:
    """The one-to-one map of least displacement and distortion; weights say what counts how much.

    Attributes:
        virtual: the virtual object, m, scene frame.
        displacement_weight: of the mean of |g − x|².
        smoothness_weight: of the Dirichlet energy of g − x on the prop.
        area_weight: of the barrier on area ratios; None: `AREA_WEIGHT`, and more where areas
            spread by more than 0.15 then, if all other weights are those by default.
        normal_weight: of the mismatch of normals.
        curvature_weight: of the mismatch of curvature.
        landmarks: pairs of points that shall meet.
        base: the outward normal of the flat face that both stand on, which stays in its plane;
            None: no face does.
        seed, starts, tolerance_mm, origin: as for `AreaPreservingGoal`.

    Raises:
        GoalError: a number is out of range.
    """

    kind: ClassVar[str] = "match"
    keys: ClassVar[tuple[str, ...]] = (*VIRTUAL_KEYS, *WEIGHTS, "landmarks", "base", *_SEARCH_KEYS)

    virtual: Surface
    displacement_weight: float = 1.0
    smoothness_weight: float = 0.2
    area_weight: float | None = None
    normal_weight: float = 0.05
    curvature_weight: float = 0.1
    landmarks: Sequence[Landmark] = ()
    base: Sequence[float] | None = None
    seed: int = 0
    starts: int = 3
    tolerance_mm: float = 0.05
    origin: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        require_surface(self.kind, self.virtual)
        object.__setattr__(self, "landmarks", tuple(self.landmarks))
        if self.base is not None:
            object.__setattr__(self, "base", goal_numbers.direction("base", self.base))
        for key in self._weights:
            object.__setattr__(self, key, goal_numbers.number(key, getattr(self, key), 0.0))
        _check_search(self)

    @property
    def weighs_by_default(self) -> bool:
        """Whether no weight was chosen, so that the area weight may be raised."""
        return all(getattr(self, key) == getattr(type(self), key) for key in WEIGHTS)

    @property
    def _weights(self) -> dict[str, float]:
        """By key, those that are numbers."""
        weights = {key: getattr(self, key) for key in WEIGHTS}
        return {key: weight for key, weight in weights.items() if weight is not None}

    @classmethod
    def read(cls, table: Table, surfaces: SurfaceReader) -> Self:
        """From the table [prop.goal] of a scene file; keys are checked by the caller."""
        landmarks = []
        for where, entries in table.tables("landmarks"):
            pair = Table(entries, where, ("prop", "virtual"))
            landmarks.append(Landmark(pair.vector("prop", 3), pair.vector("virtual", 3)))
        numbers = {key: table.number(key) for key in (*WEIGHTS, *_SEARCH_KEYS) if key in table}
        base = table.vector("base", 3, None)
        return cls(**read_virtual(table, surfaces), landmarks=landmarks, base=base, **numbers)

    def entries(self) -> dict[str, Any]:
        """The keys of the scene file."""
        entries: dict[str, Any] = {
            **virtual_entries(self.virtual, self.origin),
            **self._weights,
        }
        if self.landmarks:
            pairs = [{"prop": p.prop, "virtual": p.virtual} for p in self.landmarks]
            entries["landmarks"] = pairs
        if self.base is not None:
            entries["base"] = self.base
        return {**entries, **{key: getattr(self, key) for key in _SEARCH_KEYS}}


def _check_search(goal: AreaPreservingGoal | MatchGoal) -> None:
    object.__setattr__(goal, "seed", goal_numbers.count("seed", goal.seed, 0))
    object.__setattr__(goal, "starts", goal_numbers.count("starts", goal.starts, 1))
    tolerance_mm = goal_numbers.number("tolerance_mm", goal.tolerance_mm, 0.0, above=True)
    object.__setattr__(goal, "tolerance_mm", tolerance_mm)
