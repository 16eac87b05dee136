"""Error budget: what a person meets at real contact, by cause.

When the real finger touches the prop, the displayed one should touch the virtual object. The
tracker errs, the warp carries its error along, and a gap (or an overlap) is seen. Each cause is put
through f by itself, and all together, on the same seeded contacts; ∂f tells how much of a small
error comes through.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.check.case import Case, Finding, PropCase
from touchwarp.check.report import Check, measured, place
from touchwarp.goals.surface_samples import face_normals
from touchwarp.scene.interaction import TRACKING_PRESETS, Tracking

Float = NDArray[np.float64]

CONTACTS = 4000

JUST_OUTSIDE = 1e-4
"""m."""

HAND_SPEED = {"tap": 0.25, "slide": 0.10, "pinch": 0.05, "grasp": 0.05}
"""m/s at contact, by interaction mode: assumed. A tap moves along the normal, a slide across it,
pinch and grasp close along it."""

CAUSES = {
    "table": "the warp's table alone",
    "bias": "tracker bias",
    "noise": "tracker noise",
    "latency": "latency",
    "pose": "prop's tracked pose",
    "all": "all together",
}


def check_budget(case: Case) -> Finding:
    """The gap between displayed skin and virtual surface: median and 95th percentile, by cause."""
    tracking = case.scene.interaction.tracking
    assert isinstance(tracking, Tracking)
    other = "headset_hands" if tracking.name == "markers" else "markers"
    gaps, touched = _gaps(case, tracking)
    compared = _gaps(case, TRACKING_PRESETS[other])[0]["all"]
    speed = HAND_SPEED[case.scene.interaction.mode]
    total = gaps["all"]
    checks: list[Check] = [
        measured(
            "budget.gap",
            "Felt error: gap at real contact, 95th percentile",
            1e3 * float(np.quantile(total, 0.95)),
            "mm",
            group="told",
            where=_where(touched, total, 0.95),
            detail=f"Tracking “{tracking.name}”: bias {tracking.bias_mm:g} mm, noise "
            f"{tracking.noise_mm:g} mm, latency {tracking.latency_ms:g} ms at {speed:g} m/s, pose "
            f"{tracking.pose_mm:g} mm and {tracking.pose_deg:g}°. The median is "
            f"{1e3 * float(np.median(total)):.2g} mm; with “{other}” it would be "
            f"{1e3 * float(np.median(compared)):.2g} mm, 95th percentile "
            f"{1e3 * float(np.quantile(compared, 0.95)):.2g} mm.",
            source="Monte Carlo through f; tracking values of the scene",
        )
    ]
    for cause, words in CAUSES.items():
        if cause == "all":
            continue
        checks.append(
            measured(
                f"budget.{cause}",
                f"Felt error by {words}, 95th percentile",
                1e3 * float(np.quantile(gaps[cause], 0.95)),
                "mm",
                group="told",
                where=_where(touched, gaps[cause], 0.95),
                detail=f"The median is {1e3 * float(np.median(gaps[cause])):.2g} mm.",
            )
        )
    through, looked_at = _comes_through(case)
    checks.append(
        measured(
            "budget.gain",
            "Felt error for 1 mm of tracking error, median",
            float(np.median(through)),
            "mm",
            group="told",
            where=_where(looked_at, through, 0.5),
            detail="|∂fᵀ n| just outside the surface, n the virtual surface's normal; the 95th "
            f"percentile is {float(np.quantile(through, 0.95)):.2g} mm.",
        )
    )
    return Finding(checks, {"gaps": gaps, "compared": compared, "other": other})


def _where(points: Float, values: Float, share: float) -> tuple[float, ...]:
    """A place where the value is about that of the quantile."""
    return place(points, np.abs(values - np.quantile(values, share)).argmin())


def _gaps(case: Case, tracking: Tracking) -> tuple[dict[str, Float], Float]:
    """By cause, (n,) m: distances from the displayed fingertip to the virtual surface; and the
    places (n, d) m of the prop that are touched."""
    gaps: dict[str, list[Float]] = {cause: [] for cause in CAUSES}
    touched = []
    for prop in case.props:
        rng = case.random("budget " + prop.name)
        count = CONTACTS // len(case.props)
        taken = rng.integers(len(prop.samples.points), size=count)
        points = prop.samples.points[taken]
        touched.append(points)
        errors = _tracking_errors(case, prop, tracking, taken, rng)
        errors["all"] = np.sum(list(errors.values()), axis=0)
        errors["table"] = np.zeros_like(points)
        for cause in CAUSES:
            shown = case.warp(points + errors[cause])
            distance, _, _ = prop.virtual.nearest(np.nan_to_num(shown))
            gaps[cause].append(np.where(np.isfinite(shown).all(axis=1), distance, np.inf))
    by_cause = {cause: np.concatenate(parts) for cause, parts in gaps.items()}
    return by_cause, np.concatenate(touched)


def _tracking_errors(
    case: Case,
    prop: PropCase,
    tracking: Tracking,
    taken: NDArray[np.int64],
    rng: np.random.Generator,
) -> dict[str, Float]:
    """By cause, (n, d) m: tracked minus true fingertip, in the prop's tracked frame."""
    points = prop.samples.points[taken]
    n, d = points.shape
    outward = prop.body.outward * prop.samples.normals[taken]
    mode = case.scene.interaction.mode
    if mode == "slide":
        across = rng.standard_normal((n, d))
        across -= np.einsum("ij,ij->i", across, outward)[:, None] * outward
        lag = _unit(across)
    else:
        lag = outward
    travel = 1e-3 * tracking.latency_ms * HAND_SPEED[mode]
    centre = points.mean(axis=0)
    shift = 1e-3 * tracking.pose_mm * rng.standard_normal((n, d))
    if d == 3:
        angle = np.radians(tracking.pose_deg) * rng.standard_normal((n, 3))
        turned = np.cross(angle, points - centre)
    else:
        angle = np.radians(tracking.pose_deg) * rng.standard_normal((n, 1))
        arm = points - centre
        turned = angle * np.stack([-arm[:, 1], arm[:, 0]], axis=1)
    return {
        "bias": 1e-3 * tracking.bias_mm * _unit(rng.standard_normal((n, d))),
        "noise": 1e-3 * tracking.noise_mm * rng.standard_normal((n, d)),
        "latency": travel * lag,
        "pose": -(shift + turned),
    }


def _comes_through(case: Case) -> tuple[Float, Float]:
    """(n,) |∂fᵀ n|: how much of an error of any direction moves the displayed skin off; and where,
    (n, d) m."""
    parts, places = [], []
    for prop in case.props:
        step = max(1, len(prop.samples.points) // CONTACTS)
        outward = prop.body.outward * prop.samples.normals[::step]
        slopes = case.warp.jacobian(prop.samples.points[::step] + JUST_OUTSIDE * outward)
        faces = prop.goal.faces[prop.samples.face[::step]]
        normal = face_normals(prop.goal.virtual_points, faces)
        parts.append(np.linalg.norm(np.einsum("nij,ni->nj", slopes, normal), axis=1))
        places.append(prop.samples.points[::step])
    return np.concatenate(parts), np.concatenate(places)


def _unit(v: Float) -> Float:
    unit: Float = v / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-300)
    return unit
