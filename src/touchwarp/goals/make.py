"""From a scene to its goals: one maker per kind."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.goal import Goal
from touchwarp.goals.transform import transform_goal
from touchwarp.scene.goal_spec import GoalSpec, ReadyGoal
from touchwarp.scene.nearest import suggest
from touchwarp.scene.scene import Prop, Scene
from touchwarp.scene.surface import Surface
from touchwarp.scene.table import within


def _loaded_late(module: str, name: str) -> Callable[[Prop, Any], Goal]:
    """The maker of that name in a module of this room, whose libraries are loaded at first use."""

    def make(prop: Prop, spec: Any) -> Goal:
        maker = getattr(import_module(f"touchwarp.goals.{module}"), name)
        goal: Goal = maker(prop, spec)
        return goal

    return make


# One entry per kind of `touchwarp.scene.goal_spec.GOAL_SPECS`: the function that turns a prop and
# its spec into a Goal.
MAKERS: dict[str, Callable[[Prop, Any], Goal]] = {
    "transform": transform_goal,
    "plane_projection": _loaded_late("plane_projection", "plane_projection_goal"),
    "direction": _loaded_late("direction", "direction_goal"),
    "area_preserving": _loaded_late("maps.make", "area_preserving_goal"),
    "match": _loaded_late("maps.make", "match_goal"),
    "texture": _loaded_late("texture", "texture_goal"),
    "vertices": _loaded_late("vertices", "vertices_goal"),
}

# A ready goal's points may be a remeshing of the prop, but must span the same box.
BOUNDS_TOLERANCE = 1e-3


def goals(scene: Scene) -> dict[str, Goal]:
    """The retargeting goal g of every prop (eq. 1), by the prop's name.

    Raises:
        GoalError: a goal cannot be made, or a ready goal does not lie on its prop. The message
            begins with the prop's name.
    """
    return {prop.name: _goal(prop) for prop in scene.props}


def _goal(prop: Prop) -> Goal:
    with within(f"prop '{prop.name}'"):
        if isinstance(prop.goal, GoalSpec):
            if prop.goal.kind not in MAKERS:
                raise GoalError(
                    f"unknown goal kind '{prop.goal.kind}'. {suggest(prop.goal.kind, MAKERS)}"
                )
            return MAKERS[prop.goal.kind](prop, prop.goal)
        return _ready(prop, prop.goal)


def _ready(prop: Prop, ready: ReadyGoal) -> Goal:
    """A goal given as arrays, checked to lie on its prop."""
    goal = (
        ready
        if isinstance(ready, Goal)
        else Goal(ready.prop_points, ready.virtual_points, ready.faces)
    )
    dimension = prop.surface.dimension
    if goal.prop_points.shape[1] != dimension:
        raise GoalError(
            f"the goal's points have {goal.prop_points.shape[1]} coordinates; {dimension} are "
            "needed, as on the prop."
        )
    came = Surface(goal.prop_points, goal.faces).bounds
    if np.abs(came - prop.surface.bounds).max() > BOUNDS_TOLERANCE:
        raise GoalError(
            f"the goal's prop points span {_span(came)}, but the prop's surface "
            f"{_span(prop.surface.bounds)}; they must be points of the posed prop, in metres, in "
            "the scene's frame."
        )
    return goal


def _span(bounds: NDArray[np.float64]) -> str:
    low, high = (" ".join(f"{v:.4g}" for v in corner) for corner in bounds)
    return f"({low}) to ({high})"
