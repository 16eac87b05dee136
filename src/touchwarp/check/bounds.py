"""The maximum principle: nowhere in Ω is the mismatch greater than on its boundary."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.check.brick_faces import nodes_beyond
from touchwarp.check.case import Case, Finding
from touchwarp.check.report import measured, place
from touchwarp.warp.bricks import Bricks

Float = NDArray[np.float64]

SLACK = 1e-6
"""m: what storage in float32 and the fit's least squares may add away from the surfaces."""

SHELL_DEPTHS_MM = (0.02, 5.0)
SHELL_SAMPLES = 100_000
RANKED = 3000
"""Points of a layer with the greatest |u|, whose distance from the props is looked at."""


def check_bounds(case: Case) -> Finding:
    """|u| in Ω against the greatest |u| asked for on its boundary.

    |u|² is subharmonic for every λ ≥ 0, so the exact warp has its greatest mismatch on ∂Ω. In the
    table it may go beyond that by a micrometre, and by the contact error (that on sharp edges too)
    beside the surface, where nodes are fitted.
    """
    parts = (case.probes.points, shell_points(case, SHELL_SAMPLES), _suspect_nodes(case))
    points = np.concatenate(parts)
    length = np.linalg.norm(case.warp.displacement(points), axis=1)
    length = np.where(np.isfinite(length), length, np.inf)
    allowed = max(case.tolerance, case.greatest_contact_error)
    excess = length - case.boundary_maximum
    # only the greatest need their distance; by size of cube, so that not all are at the surface
    layer = np.concatenate(
        [case.probes.side, np.zeros(len(parts[1])), np.full(len(parts[2]), -1.0)]
    )
    ranked = np.concatenate([_greatest(excess, layer == side) for side in np.unique(layer)])
    beside = 1.5 * case.surface_cell
    away = ranked[case.region.distance_to_props(points[ranked]) > beside]
    worst = int(away[excess[away].argmax()]) if len(away) else int(ranked[-1])
    away_value = float(excess[worst])
    worst_near = int(excess.argmax())
    boundary_mm = 1e3 * case.boundary_maximum
    return Finding(
        [
            measured(
                "bounds.excess",
                "|u| in Ω beyond its boundary maximum",
                max(0.0, 1e3 * away_value),
                "mm",
                limit=1e3 * SLACK,
                where=place(points, worst),
                detail=f"{len(points):,} points of Ω; greatest |u| {1e3 * float(length.max()):.4g} "
                f"mm, on the boundary {boundary_mm:.4g} mm. Farther than {1e3 * beside:.2g} mm "
                "from the props.",
                source="maximum principle of eq. 5",
            ),
            measured(
                "bounds.excess_at_surface",
                "|u| beside the props beyond its boundary maximum",
                max(0.0, 1e3 * float(excess[worst_near])),
                "mm",
                limit=1e3 * (allowed + SLACK),
                where=place(points, worst_near),
                detail="In cells that the surface crosses, up to the greatest contact error.",
                source="maximum principle of eq. 5, contact error",
            ),
        ],
        {},
    )


def _greatest(excess: Float, among: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Indices of the greatest few values among those marked."""
    marked = np.flatnonzero(among)
    if len(marked) > RANKED:
        marked = marked[np.argpartition(-excess[marked], RANKED)[:RANKED]]
    return marked


def _suspect_nodes(case: Case) -> Float:
    """(n, d) m: nodes of the table in Ω with a |u| beyond the boundary maximum.

    u is linear between nodes, so |u| has its maxima there: this makes the check exact for a table.
    """
    bricks = getattr(case.warp, "bricks", None)
    if not isinstance(bricks, Bricks) or bricks.values.shape[-1] != 3:
        return np.empty((0, case.dimension))
    points = nodes_beyond(bricks, case.boundary_maximum + SLACK)
    return points[case.region.contains(points)]


def shell_points(case: Case, count: int) -> Float:
    """(n, d) m: points of Ω close to the props, log-uniform in distance, seeded; n ≤ `count`."""
    rng = case.random("shell")
    low, high = (np.log(1e-3 * depth) for depth in SHELL_DEPTHS_MM)
    found = []
    for prop in case.props:
        taken = rng.choice(len(prop.samples.points), min(count // len(case.props), 10**6))
        depth = np.exp(rng.uniform(low, high, len(taken)))[:, None]
        normals = prop.body.outward * prop.samples.normals[taken]
        found.append(prop.samples.points[taken] + depth * normals)
    points = np.concatenate(found)
    return points[case.region.contains(points)]
