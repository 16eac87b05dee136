"""How a scene says what its goals are; the goals room makes them.

One dataclass per kind of goal. To add a kind: write its dataclass in a module of its own, enter it
in `GOAL_SPECS`, and give the goals room the function that makes it.
"""

from __future__ import annotations

from typing import Any, ClassVar, Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from touchwarp.scene.map_goals import AreaPreservingGoal, MatchGoal
from touchwarp.scene.projection_goals import DirectionGoal, PlaneProjectionGoal
from touchwarp.scene.surface_reader import SurfaceReader
from touchwarp.scene.table import Table
from touchwarp.scene.texture_goal import TextureGoal
from touchwarp.scene.transform_goal import TransformGoal
from touchwarp.scene.vertices_goal import VerticesGoal


@runtime_checkable
class GoalSpec(Protocol):
    """A goal as the scene file writes it: `kind`, and the keys of that kind."""

    kind: ClassVar[str]
    keys: ClassVar[tuple[str, ...]]

    @classmethod
    def read(cls, table: Table, surfaces: SurfaceReader) -> Self:
        """From the table [prop.goal], whose keys are already known to be of this kind."""
        ...

    def entries(self) -> dict[str, Any]:
        """The keys and values that `read` would need, without `kind`."""
        ...


@runtime_checkable
class ReadyGoal(Protocol):
    """A goal already made, as arrays in metres in the scene's frame (`touchwarp.Goal`)."""

    prop_points: NDArray[np.float64]
    virtual_points: NDArray[np.float64]
    faces: NDArray[np.int64]


GOAL_SPECS: dict[str, type[GoalSpec]] = {
    spec.kind: spec
    for spec in (
        TransformGoal,
        PlaneProjectionGoal,
        DirectionGoal,
        AreaPreservingGoal,
        MatchGoal,
        TextureGoal,
        VerticesGoal,
    )
}


def read_goal(entries: Any, where: str, surfaces: SurfaceReader) -> GoalSpec:
    """The table [prop.goal] as the spec of its kind."""
    # The kind first: with an unknown kind there is no saying which keys are known.
    kind = Table(entries, where, entries if isinstance(entries, dict) else ()).choice(
        "kind", GOAL_SPECS
    )
    spec = GOAL_SPECS[kind]
    return spec.read(Table(entries, where, ("kind", *spec.keys)), surfaces)
