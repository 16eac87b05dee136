"""How far displayed contact is from the virtual object itself, not only from its goal.

A goal is linear on triangles, so between its vertices it may cut through, or stand off, the virtual
surface; what a person sees is the sum of that and of the warp's own error. As with the contact
error, a foot that no hand can reach counts apart: it is not on the boundary of Ω.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.check.case import Case, Finding, PropCase
from touchwarp.check.contact import MAX_FACTOR, MEAN_SHARE
from touchwarp.check.region import Body
from touchwarp.check.report import Check, measured, place

Float = NDArray[np.float64]

SAMPLES = 100_000

_SOURCE = "tolerance of the scene"


def check_virtual_contact(case: Case) -> Finding:
    """Distance of f(x) from the virtual object's own surface, for goals that have one."""
    checks: list[Check] = []
    for prop in case.props:
        if prop.goal.virtual_surface is not None:
            checks += _prop_checks(case, prop)
    return Finding(checks, {})


def _prop_checks(case: Case, prop: PropCase) -> list[Check]:
    every = max(1, len(prop.samples.points) // SAMPLES)
    points, standing = prop.samples.points[::every], case.standing[prop.name][::every]
    distance = _distance(case, prop, points)
    foot = _foot_checks(prop, points[standing], distance[standing])
    kept = ~standing & ~case.contradicted(prop, points)
    if not kept.any():
        return foot
    points, distance = points[kept], distance[kept]
    tolerance_mm = 1e3 * case.tolerance
    worst = int(distance.argmax())
    near_worst, p99 = _near_worst(distance)
    return [
        measured(
            "virtual.mean",
            "Distance of contact from the virtual surface, mean",
            1e3 * float(distance.mean()),
            "mm",
            whole="a mean over the whole surface",
            limit=MEAN_SHARE * tolerance_mm,
            subject=prop.name,
            detail=f"From f to the virtual object's own surface, over {len(points):,} samples, "
            "uniform in area: what g misses between its vertices counts too.",
            source=f"{MEAN_SHARE:g} × {_SOURCE}",
        ),
        measured(
            "virtual.p99",
            "Distance of contact from the virtual surface, 99th percentile",
            1e3 * p99,
            "mm",
            limit=tolerance_mm,
            subject=prop.name,
            where=place(points, near_worst),
            detail=f"{100 * float((distance > case.tolerance).mean()):.2g} % of the surface is "
            "displayed farther from it than the tolerance.",
            source=_SOURCE,
        ),
        measured(
            "virtual.max",
            "Distance of contact from the virtual surface, greatest",
            1e3 * float(distance[worst]),
            "mm",
            limit=MAX_FACTOR * tolerance_mm,
            group="judged",
            subject=prop.name,
            where=place(points, worst),
            detail="Triangles of g that span a sharp edge of the virtual object cut it off.",
            source=f"{MAX_FACTOR:g} × {_SOURCE}",
        ),
        *foot,
    ]


def _foot_checks(prop: PropCase, points: Float, distance: Float) -> list[Check]:
    """The distance (n,) m at those samples (n, d) m that no hand can reach."""
    if len(points) == 0:
        return []
    near_worst, p99 = _near_worst(distance)
    return [
        measured(
            "virtual.foot",
            "Distance of the foot from the virtual surface, 99th percentile",
            1e3 * p99,
            "mm",
            group="told",
            subject=prop.name,
            where=place(points, near_worst),
            detail=f"The same over the {len(points):,} samples that lie on a fixed plane: no hand "
            "comes there, and they count in no other check of this distance.",
        )
    ]


def _distance(case: Case, prop: PropCase, points: Float) -> Float:
    """(n,) m: from f at points (n, d) to the virtual surface; inf where f is not finite."""
    virtual = prop.goal.virtual_surface
    assert virtual is not None
    displayed = case.warp(points)
    body = Body(prop.name, virtual.vertices, virtual.faces)
    distance, _, _ = body.nearest(np.nan_to_num(displayed))
    return np.where(np.isfinite(displayed).all(axis=1), distance, np.inf)


def _near_worst(distance: Float) -> tuple[int, float]:
    """Which distance (n,) is the 99th percentile, and how large it is."""
    row = int(np.argsort(distance)[-(-99 * (len(distance) - 1) // 100)])
    return row, float(distance[row])
