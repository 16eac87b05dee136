"""Folds: where det ∂f < 0 the displayed hand moves backwards, and two places show as one."""

from __future__ import annotations

import numpy as np

from touchwarp.check.bounds import shell_points
from touchwarp.check.case import Case, Finding
from touchwarp.check.probes import determinants
from touchwarp.check.report import measured, place

FINGERTIP_RADIUS_MM = 8.0
"""A fold no deeper than this is hidden by the finger that causes it."""

SHELL_SAMPLES = 150_000
MOST_DISTANCES = 20_000


def check_folds(case: Case) -> Finding:
    """Volume of Ω with det ∂f < 0, how far from the props it reaches, and the least det ∂f."""
    probes = case.probes
    det = probes.determinant
    folded = np.flatnonzero(~(det >= 0.0))
    volume = float(probes.volume[folded].sum())
    shell = shell_points(case, SHELL_SAMPLES)
    det_shell = determinants(case.warp.jacobian(shell))
    points = np.concatenate([probes.points[folded], shell[~(det_shell >= 0.0)]])
    if len(points) > MOST_DISTANCES:
        chosen = case.random("folds").choice(len(points), MOST_DISTANCES, replace=False)
        points = points[chosen]
    unit = "mm³" if case.dimension == 3 else "mm²"
    scale = 1e3**case.dimension
    share = 100.0 * volume / max(float(probes.volume.sum()), 1e-300)
    all_points = np.concatenate([probes.points, shell])
    all_det = np.concatenate([det, det_shell])
    least = int(np.where(np.isfinite(all_det), all_det, -np.inf).argmin())
    distance = case.region.distance_to_props(points) if len(points) else np.zeros(0)
    farthest = int(distance.argmax()) if len(points) else None
    checks = [
        measured(
            "folds.volume",
            "Folded volume" if case.dimension == 3 else "Folded area",
            scale * volume,
            unit,
            group="told",
            where=place(all_points, least),
            detail=f"Where det ∂f < 0, {share:.2g} % of Ω; from {len(det):,} sample points, the "
            f"densest {1e3 * float(probes.side.min()):.2g} mm apart. A fold shows two places "
            "as one. Shown is where det ∂f is least.",
        ),
        measured(
            "folds.reach",
            "Greatest distance of a fold from the prop",
            0.0 if farthest is None else 1e3 * float(distance[farthest]),
            "mm",
            limit=FINGERTIP_RADIUS_MM,
            group="judged",
            where=None if farthest is None else place(points, farthest),
            detail="Farther out than a fingertip's radius, a hand not in contact meets the fold.",
            source="one fingertip radius",
        ),
        measured(
            "folds.least_det",
            "Least det ∂f",
            float(all_det[least]),
            group="told",
            where=place(all_points, least),
            detail="At sharp edges it has no limit value: it falls as the grid is refined.",
        ),
    ]
    return Finding(checks, {"points": points})
