"""Contact error: how far f(x) lies from g(x) where the prop is touched (eq. 1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from touchwarp.check.case import Case, Finding, PropCase
from touchwarp.check.report import Check, measured, place, unmeasured

Float = NDArray[np.float64]

MEAN_SHARE = 0.5
"""The mean may be this share of the tolerance."""

MAX_FACTOR = 5.0
"""The greatest error away from sharp edges may be this many times the tolerance."""

_SOURCE = "tolerance of the scene"


def check_contact(case: Case) -> Finding:
    """Mean, 99th percentile and greatest contact error of every prop, sharp edges apart.

    The error is the length of f(x) − g(x): it counts what slides along the virtual surface as well
    as what stands off it. Samples within `edge_radius` of a sharp edge count in the mean and the
    percentile; the greatest error is held against its limit outside that tube, where the exact
    warp is smooth, and told inside it. Samples of a foot that no hand can reach, and those where a
    fixed surface forbids the goal, count apart.
    """
    checks: list[Check] = []
    shown = {}
    for prop in case.props:
        edge_points, edge_error = case.edge_contact[prop.name]
        tube = _in_tube(prop.samples.points, edge_points, case.edge_radius)
        standing = case.standing[prop.name]
        given = case.contradicted(prop, prop.samples.points) & ~standing
        kept = ~standing & ~given
        checks += _area_checks(case, prop, tube, kept)
        checks += _contradiction_checks(case, prop, given)
        checks += _foot_checks(case, prop, standing)
        checks += _edge_checks(case, prop, edge_points, edge_error)
        shown[prop.name] = {
            "tube": tube,
            "kept": kept,
            "edge_points": edge_points,
            "edge_error": edge_error,
        }
    return Finding(checks, shown)


def _in_tube(points: Float, edge_points: Float, radius: float) -> NDArray[np.bool_]:
    """Which points are within `radius` of a sharp edge."""
    if len(edge_points) == 0 or radius == 0.0:
        return np.zeros(len(points), bool)
    # samples closer together than a tenth of the radius add nothing
    cells = np.floor(edge_points / (0.1 * radius)).astype(np.int64)
    _, first = np.unique(cells, axis=0, return_index=True)
    tree = cKDTree(edge_points[first])
    distance, _ = tree.query(points, distance_upper_bound=radius, workers=-1)
    near: NDArray[np.bool_] = np.isfinite(distance)
    return near


def _area_checks(
    case: Case, prop: PropCase, tube: NDArray[np.bool_], kept: NDArray[np.bool_]
) -> list[Check]:
    """Of the samples (n,) that are kept, which of them are in the tube around edges told apart."""
    tolerance_mm = 1e3 * case.tolerance
    if not kept.any():
        nowhere = "A fixed surface forbids the goal everywhere on this prop."
        return [
            unmeasured(name, f"Contact error, {what}", "mm", subject=prop.name, detail=nowhere)
            for name, what in (("contact.mean", "mean"), ("contact.p99", "99th percentile"))
        ]
    points, error = prop.samples.points[kept], case.contact_errors[prop.name][kept]
    p99 = float(np.quantile(error, 0.99))
    beyond = float((error > case.tolerance).mean())
    return [
        measured(
            "contact.mean",
            "Contact error, mean",
            1e3 * float(error.mean()),
            "mm",
            limit=MEAN_SHARE * tolerance_mm,
            subject=prop.name,
            whole="a mean over the whole surface",
            detail=f"|f − g| over {len(error):,} samples of the surface, uniform in area.",
            source=f"{MEAN_SHARE:g} × {_SOURCE}",
        ),
        measured(
            "contact.p99",
            "Contact error, 99th percentile",
            1e3 * p99,
            "mm",
            limit=tolerance_mm,
            subject=prop.name,
            where=place(points, np.abs(error - p99).argmin()),
            detail=f"{100 * beyond:.2g} % of the surface is beyond the tolerance.",
            source=_SOURCE,
        ),
        *_greatest_checks(case, prop, points, error, tube[kept]),
    ]


def _foot_checks(case: Case, prop: PropCase, standing: NDArray[np.bool_]) -> list[Check]:
    """The contact error at those samples (n,) that no hand can reach."""
    if not standing.any():
        return []
    foot = case.contact_errors[prop.name][standing]
    p99 = float(np.quantile(foot, 0.99))
    return [
        measured(
            "contact.foot",
            "Contact error on the foot, 99th percentile",
            1e3 * p99,
            "mm",
            group="told",
            subject=prop.name,
            where=place(prop.samples.points[standing], np.abs(foot - p99).argmin()),
            detail=f"{100 * standing.mean():.2g} % of the surface lies on a fixed plane: no hand "
            "comes there, and it counts in no other contact check.",
        )
    ]


def _contradiction_checks(case: Case, prop: PropCase, given: NDArray[np.bool_]) -> list[Check]:
    """The contact error at those samples (n,) where a fixed surface forbids the goal."""
    if not given.any():
        return []
    error = np.where(given, case.contact_errors[prop.name], -1.0)
    worst = int(error.argmax())
    by = "; ".join(
        f"{c.fixed.name} forbids up to {1e3 * c.forbidden:.3g} mm of it where they touch, which "
        f"is blended in over {c.fixed.blend_mm:g} mm"
        for c in case.contradictions[prop.name]
    )
    return [
        measured(
            "contact.contradicted",
            "Contact error where a fixed surface forbids the goal",
            1e3 * float(error[worst]),
            "mm",
            limit=MAX_FACTOR * 1e3 * case.tolerance,
            group="judged",
            subject=prop.name,
            where=place(prop.samples.points, worst),
            detail=f"{100 * float(given.mean()):.2g} % of the surface: {by}. No warp can meet "
            "both there; the other contact checks leave it out.",
            source=f"{MAX_FACTOR:g} × {_SOURCE}",
        )
    ]


def _greatest_checks(
    case: Case, prop: PropCase, points: Float, error: Float, tube: NDArray[np.bool_]
) -> list[Check]:
    """The greatest error (n,) outside the tube (n,) around sharp edges, and anywhere."""
    tolerance_mm, edge_mm = 1e3 * case.tolerance, 1e3 * case.edge_radius
    checks = []
    if tube.all():
        checks.append(
            unmeasured(
                "contact.max",
                "Contact error, greatest away from sharp edges",
                "mm",
                group="judged",
                subject=prop.name,
                detail=f"Every sample is within {edge_mm:g} mm of a sharp edge.",
            )
        )
    else:
        away = np.where(tube, -1.0, error)
        worst_away = int(away.argmax())
        checks.append(
            measured(
                "contact.max",
                "Contact error, greatest away from sharp edges",
                1e3 * float(away[worst_away]),
                "mm",
                limit=MAX_FACTOR * tolerance_mm,
                subject=prop.name,
                where=place(points, worst_away),
                detail=f"Outside the tube of {edge_mm:g} mm around sharp edges and rims, "
                f"{100 * (1 - tube.mean()):.0f} % of the surface.",
                source=f"{MAX_FACTOR:g} × {_SOURCE}",
            )
        )
    if tube.any():
        worst = int(error.argmax())
        checks.append(
            measured(
                "contact.max_anywhere",
                "Contact error, greatest anywhere",
                1e3 * float(error[worst]),
                "mm",
                group="told",
                subject=prop.name,
                where=place(points, worst),
                detail="At sharp edges the exact warp is singular; no limit is set there.",
            )
        )
    return checks


def _edge_checks(case: Case, prop: PropCase, points: Float, error: Float) -> list[Check]:
    if len(error) == 0:
        return []
    rims = int(prop.edges.rim.sum())
    worst = int(error.argmax())
    p99 = float(np.quantile(error, 0.99))
    length = 1e3 * float(prop.edges.length.sum())
    what = f"{len(prop.edges.ends):,} edges that turn by more than 30°"
    if case.dimension == 3:
        what += f", {length:,.0f} mm of them, {rims:,} of them open rims"
    return [
        measured(
            "edges.p99",
            "Contact error on sharp edges, 99th percentile",
            1e3 * p99,
            "mm",
            limit=MAX_FACTOR * 1e3 * case.tolerance,
            group="judged",
            subject=prop.name,
            where=place(points, np.abs(error - p99).argmin()),
            detail=f"{len(error):,} samples, uniform in length, of {what}.",
            source=f"{MAX_FACTOR:g} × {_SOURCE}",
        ),
        measured(
            "edges.max",
            "Contact error on sharp edges, greatest",
            1e3 * float(error[worst]),
            "mm",
            group="told",
            subject=prop.name,
            where=place(points, worst),
            detail=f"The mean is {1e3 * float(error.mean()):.3g} mm.",
        ),
    ]
