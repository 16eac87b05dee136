"""The goal of star-shaped bodies: points keep azimuth and polar angle about a centre (Fig. 7b)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.goal import Goal
from touchwarp.goals.line_crossings import RadialLines
from touchwarp.goals.places import spell_direction, spell_point
from touchwarp.goals.star_centre import blocked_rays, star_kernel
from touchwarp.goals.subdivision import subdivide
from touchwarp.scene.projection_goals import DirectionGoal
from touchwarp.scene.scene import Prop
from touchwarp.scene.surface import Surface

Float = NDArray[np.float64]


def direction_goal(prop: Prop, spec: DirectionGoal) -> Goal:
    """Points show where the ray from the centre through them crosses the virtual surface.

    Raises:
        GoalError: prop or virtual object is not star-shaped from its centre; the message gives the
            share of rays that fail.
    """
    surface = prop.surface
    centre, centre_virtual = _centres(surface, spec)
    lines = {}
    for what, seen, c in (
        ("prop", surface, centre),
        ("virtual object", spec.virtual, centre_virtual),
    ):
        lines[what] = _checked_lines(what, seen, c, found=spec.centre is None)

    def image_of(faces: NDArray[np.int64], places: Float) -> Float:
        arms = np.einsum("kc,kcd->kd", places, surface.vertices[surface.faces[faces]]) - centre
        directions = arms / np.linalg.norm(arms, axis=1)[:, None]
        found = lines["virtual object"].crossings(directions)
        lost = found.count != 1
        if lost.any():
            n = int(lost.argmax())
            raise GoalError(
                f"the ray from {spell_point(centre_virtual)} along "
                f"{spell_direction(directions[n])} crosses the virtual object {found.count[n]} "
                f"times, and so do {lost.sum()} of "
                f"{len(lost)}; once is needed. Close holes in the mesh, or choose another centre."
            )
        return np.asarray(centre_virtual + found.places[:, :1] * directions)

    fine = subdivide(
        surface.vertices, surface.faces, image_of, spec.virtual, spec.tolerance_mm * 1e-3
    )
    return Goal(
        fine.points,
        fine.virtual_points,
        fine.faces,
        kind=spec.kind,
        report={
            **fine.report,
            "centre": centre.tolist(),
            "virtual_centre": centre_virtual.tolist(),
        },
        virtual_surface=spec.virtual,
    )


def _centres(surface: Surface, spec: DirectionGoal) -> tuple[Float, Float]:
    """The centre in the prop and the one in the virtual object, (3,) m each."""
    if spec.centre is not None:
        centre = np.array(spec.centre)
        return centre, centre if spec.virtual_centre is None else np.array(spec.virtual_centre)
    both = star_kernel(surface, spec.virtual)
    if both.depth > 0:
        return both.centre, both.centre
    # No one point sees both: each about its own, as where the virtual object stands elsewhere.
    return star_kernel(surface).centre, star_kernel(spec.virtual).centre


def _checked_lines(what: str, surface: Surface, centre: Float, found: bool) -> RadialLines:
    if (np.linalg.norm(surface.vertices - centre, axis=1) < 1e-9).any():
        raise GoalError(
            f"the centre {spell_point(centre)} is a vertex of the {what}; a point inside is needed."
        )
    lines = RadialLines(surface, centre)
    share, one = blocked_rays(lines)
    if share > 0:
        advice = (
            "no centre sees all of it: choose another kind of goal, such as match"
            if found
            else "choose another centre, leave it out to have one found, or choose another kind"
        )
        raise GoalError(
            f"the {what} is not star-shaped from {spell_point(centre)}: {share:.2%} of rays do not "
            f"cross it just once, one of them along {spell_direction(one)}; {advice}."
        )
    return lines
