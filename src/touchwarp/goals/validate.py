"""Geometric checks that need the goals: what fits where."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import SceneError
from touchwarp.goals.goal import Goal
from touchwarp.scene.distance import body_points, closest_props, inside, surface_gap
from touchwarp.scene.scene import Fixed, Outer, Prop, Scene
from touchwarp.scene.surface import Surface

# Surfaces nearer than this touch.
TOUCH = 1e-6
# How deep a prop may reach into the plane that it stands on: the noise of a scan's foot.
PLANE_DEPTH = 1e-4


def outer_box(scene: Scene, goals: Mapping[str, Goal]) -> NDArray[np.float64]:
    """The outer box, or the bounding box of the outer surface: (2, d) m, scene frame.

    By `box_scale` it is a cube around the box of all props and virtual objects, with its centre.
    """
    outer = scene.outer
    if outer.surface is not None:
        return outer.surface.bounds
    if outer.box is not None:
        return np.array(outer.box, dtype=np.float64)
    assert outer.box_scale is not None
    boxes = np.concatenate(
        [prop.surface.bounds for prop in scene.props]
        + [surface.bounds for goal in goals.values() for surface in _virtual(goal)]
    )
    low, high = boxes.min(axis=0), boxes.max(axis=0)
    half = outer.box_scale * (high - low).max() / 2
    centre = (low + high) / 2
    return np.stack([centre - half, centre + half])


def validate(scene: Scene, goals: Mapping[str, Goal]) -> None:
    """Check that the scene's parts fit together.

    Raises:
        SceneError: a prop touches ∂Ω1 or lies outside; a virtual object reaches outside; a plane
            cuts through a prop by more than 0.1 mm, or a sliding plane has a prop behind it; two
            props overlap or touch (within 1 µm).
    """
    box = outer_box(scene, goals)
    for prop in scene.props:
        _check_inside(prop.surface, f"prop '{prop.name}'", scene.outer, box, TOUCH)
        what = f"the virtual object of prop '{prop.name}'"
        for virtual in _virtual(goals[prop.name]):
            _check_inside(virtual, what, scene.outer, box, 0.0)
    for fixed in scene.fixed:
        if fixed.plane is not None:
            for prop in scene.props:
                _check_plane(prop, fixed)
    closest = closest_props(scene, limit=TOUCH)
    if closest is not None:
        raise SceneError(
            f"props '{closest[0]}' and '{closest[1]}' overlap or touch; retargeted props need a "
            "gap between them: move one by its pose, join them to one mesh, or make one [[fixed]]."
        )


def _virtual(goal: Goal) -> list[Surface]:
    """What must lie inside the outer boundary: the prop's image, and the virtual object itself."""
    return [goal.image] if goal.virtual_surface is None else [goal.image, goal.virtual_surface]


def _check_inside(
    surface: Surface, what: str, outer: Outer, box: NDArray[np.float64], margin: float
) -> None:
    bounds = surface.bounds
    excess = np.concatenate([box[0] - bounds[0], bounds[1] - box[1]]) + margin
    sides = [f"{sign}{axis}" for sign in "-+" for axis in "xyz"[: box.shape[1]]]
    worst = int(excess.argmax())
    if excess[worst] > 0:
        beyond = excess[worst] - margin
        how = "touches it" if beyond <= 0 else f"reaches {beyond * 1e3:.4g} mm beyond it"
        raise SceneError(
            f"{what} must lie inside the outer boundary, but {how} in {sides[worst]}; enlarge "
            "[outer], or move or shrink the object."
        )
    if outer.surface is None:
        return
    if not inside(body_points(surface), outer.surface).all():
        raise SceneError(
            f"{what} lies outside the outer surface, wholly or with one of its bodies; enlarge "
            "[outer], or move the object."
        )
    if surface_gap(surface, outer.surface, TOUCH) <= TOUCH:
        raise SceneError(
            f"{what} touches or crosses the outer surface; enlarge [outer], or move or shrink the "
            "object."
        )


def _check_plane(prop: Prop, fixed: Fixed) -> None:
    assert fixed.plane is not None
    point, normal = (np.asarray(v) for v in fixed.plane)
    height = (prop.surface.used_vertices - point) @ normal
    depth = max(0.0, -float(height.min()))
    if depth <= PLANE_DEPTH:
        return
    if height.max() <= PLANE_DEPTH:
        if fixed.contact == "hold":
            return
        raise SceneError(
            f"prop '{prop.name}' lies behind the sliding plane '{fixed.name}'; its normal must "
            'point to the side of the props: turn the normal round, or write contact = "hold".'
        )
    raise SceneError(
        f"the plane '{fixed.name}' cuts through prop '{prop.name}', which reaches "
        f"{depth * 1e3:.4g} mm behind it (up to {PLANE_DEPTH * 1e3:g} mm counts as standing on "
        f"it); raise the prop by that much along the plane's normal."
    )
