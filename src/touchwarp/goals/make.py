"""From a scene to its goals: one maker per kind."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.goal import Goal
from touchwarp.goals.goal_cache import keep_goal, load_goal
from touchwarp.scene.goal_spec import GoalSpec, ReadyGoal
from touchwarp.scene.nearest import suggest
from touchwarp.scene.scene import Prop, Scene
from touchwarp.scene.surface import Surface
from touchwarp.scene.table import within

Progress = Callable[[str, float], None]
Maker = Callable[[Prop, Any, Progress | None], Goal]


def _quick(module: str, name: str) -> Maker:
    """The maker of that name in a module of this room, whose libraries are loaded at first use."""

    def make(prop: Prop, spec: Any, progress: Progress | None) -> Goal:
        goal: Goal = getattr(import_module(f"touchwarp.goals.{module}"), name)(prop, spec)
        return goal

    return make


def _long(module: str, name: str) -> Maker:
    """The same for a maker that tells how far it is, and whose goals are kept on disk."""

    def make(prop: Prop, spec: Any, progress: Progress | None) -> Goal:
        kept = load_goal(prop, spec)
        if kept is not None:
            return kept
        maker = getattr(import_module(f"touchwarp.goals.{module}"), name)
        goal: Goal = maker(prop, spec, progress)
        keep_goal(prop, spec, goal)
        return goal

    return make


# One entry per kind of `touchwarp.scene.goal_spec.GOAL_SPECS`: the function that turns a prop and
# its spec into a Goal.
MAKERS: dict[str, Maker] = {
    "transform": _quick("transform", "transform_goal"),
    "plane_projection": _quick("plane_projection", "plane_projection_goal"),
    "direction": _quick("direction", "direction_goal"),
    "area_preserving": _long("maps.make", "area_preserving_goal"),
    "match": _long("maps.make", "match_goal"),
    "texture": _quick("texture", "texture_goal"),
    "vertices": _quick("vertices", "vertices_goal"),
}

# A ready goal's points may be a remeshing of the prop, but must span the same box.
BOUNDS_TOLERANCE = 1e-3


def goals(scene: Scene, progress: Progress | None = None) -> dict[str, Goal]:
    """The retargeting goal g of every prop (eq. 1), by the prop's name.

    Args:
        scene: props with what their goals shall be.
        progress: called with the step at hand and the part of it that is done, 0 to 1.

    Raises:
        GoalError: a goal cannot be made, or a ready goal does not lie on its prop. The message
            begins with the prop's name.
    """
    return {prop.name: _goal(prop, progress) for prop in scene.props}


def _goal(prop: Prop, progress: Progress | None) -> Goal:
    with within(f"prop '{prop.name}'"):
        if isinstance(prop.goal, GoalSpec):
            if prop.goal.kind not in MAKERS:
                raise GoalError(
                    f"unknown goal kind '{prop.goal.kind}'. {suggest(prop.goal.kind, MAKERS)}"
                )
            return MAKERS[prop.goal.kind](prop, prop.goal, progress)
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
