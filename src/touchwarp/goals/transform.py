"""The goal that moves, turns and stretches a prop."""

from __future__ import annotations

from touchwarp.goals.goal import Goal
from touchwarp.scene.scene import Prop
from touchwarp.scene.transform_goal import TransformGoal


def transform_goal(prop: Prop, spec: TransformGoal) -> Goal:
    """virtual = pivot + translation + R·S·(x − pivot) at every vertex of the prop.

    Raises:
        GoalError: the spec's numbers do not fit the prop's dimension.
    """
    surface = prop.surface
    matrix = spec.affine(surface.bounds)
    return Goal(
        prop_points=surface.vertices,
        virtual_points=surface.transformed(matrix).vertices,
        faces=surface.faces,
        kind=spec.kind,
        matrix=matrix,
    )
