"""The goal of one mesh in two shapes: vertex i shows at vertex i."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.goal import Goal
from touchwarp.scene.scene import Prop
from touchwarp.scene.vertices_goal import VerticesGoal


def vertices_goal(prop: Prop, spec: VerticesGoal) -> Goal:
    """Vertex i of the prop shows at vertex i of the virtual object.

    Raises:
        GoalError: the two meshes differ in more than their vertices' places.
    """
    surface, virtual = prop.surface, spec.virtual
    counts = [
        (len(surface.vertices), len(virtual.vertices), "vertices"),
        (len(surface.faces), len(virtual.faces), "faces"),
    ]
    for ours, theirs, what in counts:
        if ours != theirs:
            raise GoalError(
                f"the prop has {ours:,} {what} and the virtual object {theirs:,} (equal vertices "
                "merged); one mesh in two shapes is needed, with its vertices in one order. Export "
                "both from the same tool without changing the mesh, or choose kind = 'match'."
            )
    others = ~_same_triangles(surface.faces, virtual.faces)
    if others.any():
        raise GoalError(
            f"{others.sum():,} of {len(others):,} faces join other vertices in the virtual object, "
            f"face {int(others.argmax()) + 1} the first: its vertices are in another order, or it "
            "is another mesh. Export both from the same tool without changing the mesh, or choose "
            "kind = 'match'."
        )
    return Goal(
        surface.vertices,
        virtual.vertices,
        surface.faces,
        kind=spec.kind,
        virtual_surface=virtual,
    )


def _same_triangles(faces: NDArray[np.int64], others: NDArray[np.int64]) -> NDArray[np.bool_]:
    """(m,) whether each face is among the others, turned either way round."""
    both = np.sort(np.concatenate([faces, others]), axis=1)
    number = np.unique(both, axis=0, return_inverse=True)[1].ravel()
    return np.isin(number[: len(faces)], number[len(faces) :])
