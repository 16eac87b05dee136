"""Where nothing may be displaced: on and beyond ∂Ω1, and on what is fixed."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.check.case import Case, Finding
from touchwarp.check.report import Check, measured, place
from touchwarp.goals.goal import Goal
from touchwarp.goals.surface_samples import sample_surface
from touchwarp.scene.scene import Fixed
from touchwarp.scene.surface import Surface

Float = NDArray[np.float64]

SLACK = 1e-6
"""m: allowed on flat boundaries, where the table's nodes lie on the boundary itself."""

SAMPLES = 60_000


def check_identity(case: Case) -> Finding:
    """|u| on ∂Ω1, beyond it, and on fixed surfaces; on a sliding plane, u along its normal."""
    checks = [*_outer_checks(case)]
    for fixed in case.scene.fixed:
        checks += _fixed_checks(case, fixed)
    return Finding(checks, {})


def _outer_checks(case: Case) -> list[Check]:
    rng = case.random("outer")
    low, high = case.region.box
    reach = high - low
    if case.region.outer is None:
        on = _box_points(low, high, rng, SAMPLES)
        limit, source = SLACK, "eq. 2"
    else:
        body = case.region.outer
        on = _surface_points(Surface(body.vertices, body.faces), rng)
        limit, source = case.tolerance, "eq. 2; the table's tolerance on a curved ∂Ω1"
    beyond = rng.uniform(low - 0.5 * reach, high + 0.5 * reach, (SAMPLES, case.dimension))
    beside = np.zeros(len(beyond), dtype=np.bool_)
    if case.region.outer is None:
        outside = ~((beyond >= low) & (beyond <= high)).all(axis=1)
    else:
        outside = ~case.region.outer.inside(beyond)
        beside = case.region.outer.nearest(beyond)[0] <= 2.0 * case.cell_at(on)
    # under a sliding plane nobody's hand can be; the table fades out there
    table = case.scene.slide_plane
    if table is not None and table.plane is not None:
        point, normal = (np.asarray(v, float) for v in table.plane)
        on = on[(on - point) @ normal >= 0]
        outside &= (beyond - point) @ normal >= 0
    beside, beyond = beyond[outside & beside], beyond[outside & ~beside]
    checks = [
        _greatest(
            "identity.outer",
            "|u| on the outer boundary ∂Ω1",
            on,
            _length(case, on),
            limit=1e3 * limit,
            detail=f"{len(on):,} points of ∂Ω1.",
            source=source,
        ),
        _greatest(
            "identity.beyond",
            "|u| beyond ∂Ω1",
            beyond,
            _length(case, beyond),
            limit=1e3 * SLACK,
            detail=f"{len(beyond):,} points outside ∂Ω1"
            + (", farther than two cells from it." if len(beside) else "."),
            source="eq. 2",
        ),
    ]
    if len(beside):
        # a cell that ∂Ω1 crosses is one piece: to be 0 on it, u goes on to the nodes beyond it,
        # and falls to 0 in the cells behind these
        checks.append(
            _greatest(
                "identity.beside",
                "|u| just beyond ∂Ω1",
                beside,
                _length(case, beside),
                group="judged",
                limit=1e3 * case.tolerance,
                detail=f"{len(beside):,} points outside ∂Ω1, within two cells of it.",
                source="eq. 2; the table's tolerance",
            )
        )
    return checks


def _fixed_checks(case: Case, fixed: Fixed) -> list[Check]:
    """Away from the contact line nothing may move; within `blend_mm` of it the residual is told."""
    points = _points_on(case, fixed)
    if len(points) == 0:
        return []
    slides = fixed.contact == "slide"
    # the grid lies along a sliding plane; to what is held the table is fitted, as to props
    limit = SLACK if slides else case.tolerance
    if slides:
        assert fixed.plane is not None, "only planes slide"
        size = np.abs(case.warp.displacement(points) @ np.asarray(fixed.plane[1], float))
        size = np.where(np.isfinite(size), size, np.inf)
    else:
        size = _length(case, points)
    near = case.region.distance_to_props(points) <= 1e-3 * fixed.blend_mm + case.surface_cell
    title = "u along the normal of the sliding plane" if slides else "|u| on the held surface"
    checks = []
    if not near.all():
        checks.append(
            _greatest(
                "identity.slide" if slides else "identity.hold",
                title,
                points,
                np.where(near, -1.0, size),
                limit=1e3 * limit,
                subject=fixed.name,
                detail=f"{int((~near).sum()):,} points, farther than {fixed.blend_mm:g} mm "
                "from the props.",
                source="the scene's fixed surfaces",
            )
        )
    if near.any():
        checks.append(
            _greatest(
                "identity.contact_line",
                title + ", beside the props",
                points,
                np.where(near, size, -1.0),
                group="told",
                subject=fixed.name,
                detail="Where a goal contradicts the fixed surface, one is blended into the other "
                f"over {fixed.blend_mm:g} mm; this is what remains.",
            )
        )
    return checks


def _greatest(name: str, title: str, points: Float, size: Float, **more: Any) -> Check:
    """The greatest of (n,) sizes, m, told in mm with its place among (n, d) points."""
    worst = int(size.argmax())
    return measured(name, title, 1e3 * float(size[worst]), "mm", where=place(points, worst), **more)


def _points_on(case: Case, fixed: Fixed) -> Float:
    """Points (n, 3) m of a fixed surface, scene frame: those in Ω, within ∂Ω1 and outside props."""
    rng = case.random("fixed " + fixed.name)
    low, high = case.region.box
    if fixed.plane is not None:
        point, normal = (np.asarray(v, float) for v in fixed.plane)
        points = rng.uniform(low, high, (SAMPLES, case.dimension))
        points -= ((points - point) @ normal)[:, None] * normal
    else:
        assert fixed.surface is not None
        points = _surface_points(fixed.surface, rng)
    inside = ((points > low) & (points < high)).all(axis=1)
    if case.region.outer is not None:
        inside[inside] = case.region.outer.inside(points[inside])
    for body in case.region.props:
        inside[inside] = ~body.inside(points[inside])
    return np.asarray(points[inside])


def _length(case: Case, points: Float) -> Float:
    size: Float = np.linalg.norm(case.warp.displacement(points), axis=1)
    return np.where(np.isfinite(size), size, np.inf)


def _box_points(low: Float, high: Float, rng: np.random.Generator, count: int) -> Float:
    """Points on all faces of a box, as many on each."""
    d = len(low)
    points = rng.uniform(low, high, (2 * d, count // (2 * d), d))
    for axis in range(d):
        points[2 * axis, :, axis] = low[axis]
        points[2 * axis + 1, :, axis] = high[axis]
    return points.reshape(-1, d)


def _surface_points(surface: Surface, rng: np.random.Generator) -> Float:
    still = Goal(surface.vertices, surface.vertices, surface.faces)
    return sample_surface(still, SAMPLES, rng).points
