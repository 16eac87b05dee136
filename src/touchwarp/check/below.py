"""Below the surface: tracking noise and soft skin put fingertips there, so f must stay sane."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.check.case import Case, Finding, PropCase
from touchwarp.check.probes import singular_values
from touchwarp.check.report import Check, measured, place, unmeasured

Float = NDArray[np.float64]

DEEPEST = 1e-2
"""m, or a wall's middle."""

SAMPLES = 20_000
MISMATCH_FACTOR = 1.1
GAIN_FACTOR = 3.0
OUTSIDE_SHARE = 1.0
"""%, of points below the surface that may be displayed outside the virtual object."""


def check_below(case: Case) -> Finding:
    """|u|, gain and the displayed place of points up to 10 mm under the surface."""
    checks: list[Check] = []
    shown = {}
    for prop in case.props:
        points, depth = points_below(prop, case.random("below " + prop.name))
        points = points[_above_planes(case, points)]
        if len(points) < 20:
            checks.append(
                unmeasured(
                    "below.outside",
                    "Below the surface, displayed outside the virtual object",
                    "%",
                    group="judged",
                    subject=prop.name,
                    detail="An open surface has no inside."
                    if not prop.body.closed
                    else "The walls are too thin to have an inside.",
                )
            )
            continue
        checks += _prop_checks(case, prop, points, float(depth.max()))
        shown[prop.name] = {"points": points}
    return Finding(checks, shown)


def points_below(prop: PropCase, rng: np.random.Generator) -> tuple[Float, Float]:
    """Points (n, d) m at depths (n,) m under the surface, no deeper than a wall's middle."""
    taken = rng.choice(len(prop.samples.points), min(SAMPLES, len(prop.samples.points)), False)
    depth = rng.uniform(0.0, DEEPEST, len(taken))
    inward = -prop.body.outward * prop.samples.normals[taken]
    points = prop.samples.points[taken] + depth[:, None] * inward
    inside = prop.body.inside(points)
    points, depth = points[inside], depth[inside]
    distance, _, _ = prop.body.nearest(points)
    # past a wall's middle, and beside edges, another part of the surface is nearer
    own = distance > 0.99 * depth
    return points[own], depth[own]


def _above_planes(case: Case, points: Float) -> NDArray[np.bool_]:
    above = np.ones(len(points), bool)
    for point, normal in case.region.planes:
        above &= (points - point) @ normal > 0
    return above


def _prop_checks(case: Case, prop: PropCase, points: Float, deepest: float) -> list[Check]:
    size = np.linalg.norm(case.warp.displacement(points), axis=1)
    size = np.where(np.isfinite(size), size, np.inf)
    gain = singular_values(np.nan_to_num(case.warp.jacobian(points), nan=1e9))[:, 0]
    shown = case.warp(points)
    distance, _, _ = prop.virtual.nearest(np.nan_to_num(shown))
    out = ~prop.virtual.inside(shown) & (distance > case.tolerance)
    stands_off = np.where(out, distance, 0.0)
    worst, steep, far = int(size.argmax()), int(gain.argmax()), int(stands_off.argmax())
    limit_gain = GAIN_FACTOR * max(1.0, _goal_gain(prop))
    what = (
        f"{len(points):,} points up to {1e3 * deepest:.3g} mm below the surface or to a "
        "wall's middle."
    )
    return [
        measured(
            "below.mismatch",
            "Below the surface, greatest |u|",
            1e3 * float(size[worst]),
            "mm",
            limit=MISMATCH_FACTOR * 1e3 * case.boundary_maximum + 1e3 * case.tolerance,
            group="judged",
            subject=prop.name,
            where=place(points, worst),
            detail=what,
            source=f"{MISMATCH_FACTOR:g} × the boundary maximum",
        ),
        measured(
            "below.gain",
            "Below the surface, gain, 99th percentile",
            float(np.quantile(gain, 0.99)),
            "×",
            limit=limit_gain,
            group="judged",
            subject=prop.name,
            where=place(points, steep),
            detail=f"The greatest is {float(gain[steep]):.3g}.",
            source=f"{GAIN_FACTOR:g} × the goal's own",
        ),
        measured(
            "below.outside",
            "Below the surface, displayed outside the virtual object",
            100.0 * float(out.mean()),
            "%",
            limit=OUTSIDE_SHARE,
            group="judged",
            subject=prop.name,
            where=place(points, far) if out.any() else None,
            detail=f"By more than the tolerance; at most by {1e3 * float(stands_off[far]):.2g} mm.",
            source="a finger in the prop must not show outside the virtual object",
        ),
    ]


def _goal_gain(prop: PropCase) -> float:
    """The greatest gain that the goal itself asks for: along its faces, or of its matrix."""
    goal = prop.goal
    d = goal.prop_points.shape[1]
    if goal.matrix is not None:
        return float(np.linalg.svd(goal.matrix[:d, :d], compute_uv=False)[0])
    before = np.linalg.norm(
        goal.prop_points[goal.faces[:, 0]] - goal.prop_points[goal.faces[:, 1]], axis=1
    )
    after = np.linalg.norm(
        goal.virtual_points[goal.faces[:, 0]] - goal.virtual_points[goal.faces[:, 1]], axis=1
    )
    return float(np.quantile(after / np.maximum(before, 1e-300), 0.99))
