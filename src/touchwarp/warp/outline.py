"""Props and virtual objects thinned out, for pictures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from touchwarp.goals import Goal
from touchwarp.scene import Surface
from touchwarp.warp.meta import Outline

MOST_FACES = 2000


def outline_of(goal: Goal) -> Outline:
    """The prop and the virtual object of a goal, with the same, few faces."""
    points, faces = goal.prop_points, goal.faces
    if len(faces) > MOST_FACES:
        chosen, faces = _thin(_between(goal), faces)
        return Outline(Surface(points[chosen], faces), Surface(goal.virtual_points[chosen], faces))
    return Outline(Surface(points, faces), Surface(goal.virtual_points, faces))


def thinned(surface: Surface) -> Surface:
    """A surface with few faces."""
    if len(surface.faces) <= MOST_FACES:
        return surface
    chosen, faces = _thin(surface.vertices, surface.faces)
    return Surface(surface.vertices[chosen], faces)


def _between(goal: Goal) -> NDArray[np.float64]:
    """(n, d) m: a shape that is curved where the prop is, or where the virtual object is.

    Halfway between the two, once the affine part of g is undone.
    """
    prop, virtual = goal.prop_points, goal.virtual_points
    if goal.matrix is not None:
        return prop
    undone = np.c_[virtual, np.ones(len(virtual))]
    return np.asarray(prop + undone @ np.linalg.lstsq(undone, prop, rcond=None)[0]) / 2


def _thin(
    points: NDArray[np.float64], faces: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows of `points` to keep, and faces between them."""
    import fast_simplification

    scale = float(np.ptp(points, axis=0).max())
    thin, few = fast_simplification.simplify(
        (points / scale).astype(np.float32), faces.astype(np.int32), target_count=MOST_FACES, agg=5
    )
    used, few = np.unique(np.asarray(few, dtype=np.int64), return_inverse=True)
    nearest = cKDTree(points).query(thin[used] * scale)[1]
    return nearest, few.reshape(-1, 3)
