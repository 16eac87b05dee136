"""The goal's own certificate, for goals that map one shape to another: before any warp is made.

What a one-to-one map onto its virtual object promises is hard: no face flipped, all of the object
covered, once, with the image on it. What a person may notice is judged; curvature and sharp edges
are quantities of their own, since in Zhao & Follmer's study an edge that moved by less than a
centimetre was what people rated worst.
"""

from __future__ import annotations

import numpy as np

from touchwarp.check.case import Case, Finding
from touchwarp.check.report import Check, measured, place
from touchwarp.check.thresholds import SCALE_UP, judge
from touchwarp.goals.fingertip_curvature import FINGERTIP_RADIUS
from touchwarp.goals.measure import MapMeasures

LEAST_COVERAGE = 99.9
"""%."""

MOST_LAYERS = 1.5
"""Times: an image that winds round the virtual object twice has 2, one that does once has 1."""

ON_SURFACE_MM = 1e-6
LANDMARKS = 0.1
"""% of the virtual object's diagonal."""

AREA_STD = 1.0
"""%, promised by an area-preserving goal alone."""

PARTIAL = ("plane_projection", "texture")
"""Kinds that may leave part of the virtual object out."""

ROUNDED = ("texture", "arrays")
"""Kinds whose points are on the virtual surface only as exactly as the file that brought them."""

_FINGERTIP = f"averaged over a fingertip of {1e3 * FINGERTIP_RADIUS:g} mm radius"


def check_map(case: Case) -> Finding:
    """Quality of every goal that maps one shape to another; transforms have none to check."""
    checks: list[Check] = []
    for name, measures in case.maps.items():
        numbers = measures.summary()
        if measures.goal.virtual_surface is not None:
            checks += _promises(case, measures, numbers, name)
            checks += _landmark_checks(measures, numbers, name)
        checks += _shape_checks(measures, numbers, case.scene.interaction.mode, name)
        checks += _sharp_edge_checks(measures, name)
        checks += _told(measures, numbers, name)
    return Finding(checks, {})


def _promises(
    case: Case, measures: MapMeasures, numbers: dict[str, float], name: str
) -> list[Check]:
    goal, coverage = measures.goal, measures.coverage
    flipped = np.flatnonzero(coverage.flipped)
    missed = np.flatnonzero(~coverage.covered)
    farthest = int(measures.distance.argmax())
    partial, rounded = goal.kind in PARTIAL, goal.kind in ROUNDED
    tolerance_mm = 1e3 * case.tolerance
    return [
        measured(
            "map.flips",
            "Faces that the goal flips or flattens",
            numbers["flips"],
            limit=0.0,
            subject=name,
            where=None
            if len(flipped) == 0
            else place(goal.prop_points[goal.faces].mean(axis=1), flipped[0]),
            detail="Faces whose image is turned against the virtual surface beneath it; they make "
            f"{100 * numbers['opposing']:.2g} % of the image's area.",
        ),
        measured(
            "map.coverage",
            "Virtual surface that is covered",
            100.0 * numbers["coverage"],
            "%",
            limit=None if partial else (LEAST_COVERAGE, None),
            group="told" if partial else "hard",
            subject=name,
            where=place(coverage.points, missed[len(missed) // 2]) if len(missed) else None,
            whole="all of it, without a gap",
            detail=f"Of {len(coverage.points):,} points of the virtual surface, those whose "
            "normal meets the image within 1 % of the object's diagonal; the place is on the "
            "virtual object.",
        ),
        measured(
            "map.layers",
            "Area of the image over that of the virtual surface",
            numbers["layers"],
            "×",
            limit=MOST_LAYERS,
            subject=name,
            whole="a ratio of whole areas",
            detail="An image that covers the surface twice has 2, though no face of it may be "
            "flipped.",
        ),
        measured(
            "map.vertices",
            "Distance of the goal's points from the virtual surface, greatest",
            1e3 * numbers["distance_vertices"],
            "mm",
            limit=tolerance_mm if rounded else ON_SURFACE_MM,
            subject=name,
            where=place(goal.prop_points, measures.vertex_distance.argmax()),
            detail="Images of the vertices alone.",
            source="tolerance of the scene" if rounded else "rounding",
        ),
        measured(
            "map.distance",
            "Distance of the goal's image from the virtual surface, 99th percentile",
            1e3 * numbers["distance_p99"],
            "mm",
            limit=tolerance_mm,
            subject=name,
            where=place(measures.samples.points, farthest),
            detail="Between the vertices the image is flat; "
            f"the mean is {1e3 * numbers['distance_mean']:.2g} mm, the greatest, at the place "
            f"given, {1e3 * numbers['distance_max']:.2g} mm.",
            source="tolerance of the scene",
        ),
    ]


def _landmark_checks(measures: MapMeasures, numbers: dict[str, float], name: str) -> list[Check]:
    landmarks = measures.goal.landmarks
    if landmarks is None or len(measures.landmark_error) == 0:
        return []
    return [
        measured(
            "map.landmarks",
            "Landmark error, greatest",
            100.0 * numbers["landmark_max"],
            "%",
            limit=LANDMARKS,
            subject=name,
            where=place(landmarks[:, 0], measures.landmark_error.argmax()),
            detail=f"{len(landmarks)} landmarks; of the virtual object's diagonal, "
            f"{1e3 * measures.diagonal:.0f} mm.",
        )
    ]


def _shape_checks(
    measures: MapMeasures, numbers: dict[str, float], mode: str, name: str
) -> list[Check]:
    change = measures.curvature.change
    sharpest = int(np.abs(change).argmax())
    felt, seen = measures.curvature.felt[sharpest], measures.curvature.seen[sharpest]
    middles = measures.goal.prop_points[measures.goal.faces].mean(axis=1)
    greatest, least = np.nan_to_num(measures.stretch, nan=1.0).T
    return [
        judge(
            SCALE_UP,
            mode,
            "map.stretch_greatest",
            "Stretch by the goal, 99th percentile",
            numbers["stretch_greatest"],
            subject=name,
            where=place(middles, greatest.argmax()),
            detail="Greatest singular value of ∂g on faces.",
        ),
        measured(
            "map.stretch_least",
            "Least stretch by the goal, 1st percentile",
            numbers["stretch_least"],
            "×",
            group="judged",
            subject=name,
            where=place(middles, least.argmin()),
            detail="Least singular value of ∂g on faces; no number is known for what shrinks.",
        ),
        measured(
            "map.curvature",
            "Change of curvature by the goal, mean",
            numbers["curvature_mean"],
            "m⁻¹",
            group="judged",
            subject=name,
            where=place(measures.curvature.points, sharpest),
            detail=f"|mean curvature seen − felt|, {_FINGERTIP}; the 95th percentile is "
            f"{numbers['curvature_p95']:.3g} m⁻¹. At the place given it goes from {felt:.3g} felt "
            f"to {seen:.3g} m⁻¹ seen.",
        ),
    ]


def _sharp_edge_checks(measures: MapMeasures, name: str) -> list[Check]:
    edges = measures.edges
    beyond = f"within {1e3 * FINGERTIP_RADIUS:g} mm"
    checks = []
    if edges.felt_length > 0.0:
        checks.append(
            measured(
                "map.edges_lost",
                "Sharp edges felt where none is seen",
                100.0 * edges.lost,
                "%",
                group="judged",
                subject=name,
                where=place(edges.felt_points, edges.felt.argmax()),
                detail=f"Of {1e3 * edges.felt_length:,.0f} mm of the prop's edges that turn by "
                f"more than 30°, the part whose image has none of the virtual object's {beyond}.",
            )
        )
    if edges.seen_length > 0.0:
        checks.append(
            measured(
                "map.edges_new",
                "Sharp edges seen where none is felt",
                100.0 * edges.new,
                "%",
                group="judged",
                subject=name,
                where=place(edges.seen_points, edges.seen.argmax()),
                detail=f"Of {1e3 * edges.seen_length:,.0f} mm of the virtual object's edges, the "
                f"part with no image of the prop's {beyond}; the place is on the virtual object.",
            )
        )
    if np.isfinite(edges.offset):
        checks.append(
            measured(
                "map.edges_offset",
                "Distance of felt from seen sharp edges, mean",
                1e3 * edges.offset,
                "mm",
                group="judged",
                subject=name,
                whole="a mean over all edges",
                detail=f"Of those that have a partner {beyond}.",
            )
        )
    return checks


def _told(measures: MapMeasures, numbers: dict[str, float], name: str) -> list[Check]:
    promised = measures.goal.kind == "area_preserving"
    report, weight = measures.goal.report, ""
    if "area_weight" in report:
        weight = f" area_weight is {report['area_weight']:.3g}: {report['area_weight_reason']}."
    return [
        measured(
            "map.area_std",
            "Spread of area ratios",
            100.0 * numbers["area_std"],
            "%",
            limit=AREA_STD if promised else None,
            group="hard" if promised else "told",
            subject=name,
            whole="a spread over the whole surface",
            detail="Standard deviation, by area, of each face's ratio over that of the whole, "
            f"{numbers['area_scale']:.3g}; 98 % of the surface lies between "
            f"{numbers['area_least']:.2g} and {numbers['area_greatest']:.2g}.{weight}",
        ),
        measured(
            "map.displacement",
            "Displacement by the goal, mean",
            1e3 * numbers["displacement_mean"],
            "mm",
            group="told",
            subject=name,
            whole="a mean over the whole surface",
            detail="The greatest is judged as the offset in contact.",
        ),
        measured(
            "map.normals",
            "Turn from the prop's normal to the virtual surface's, mean",
            float(np.degrees(numbers["normal_mean"])),
            "deg",
            group="told",
            subject=name,
            where=place(measures.samples.points, measures.turn.argmax()),
            detail=f"The 95th percentile is {np.degrees(numbers['normal_p95']):.3g}°.",
        ),
        measured(
            "map.gaussian",
            "Change of Gaussian curvature by the goal, mean",
            numbers["gaussian_mean"],
            "m⁻²",
            group="told",
            subject=name,
            whole="a mean over the whole surface",
            detail=f"|seen − felt|, {_FINGERTIP}.",
        ),
        measured(
            "map.smoothness",
            "Smoothness of the goal, mean |∇(g − x)|²",
            numbers["smoothness"],
            group="told",
            subject=name,
            whole="a mean over the whole surface",
            detail="Over the prop's surface; 0 for a translation, (s − 1)² · 2 for a scale of s.",
        ),
        measured(
            "map.smoothness_inverse",
            "Smoothness of its inverse, mean |∇(g⁻¹ − y)|²",
            numbers["smoothness_inverse"],
            group="told",
            subject=name,
            whole="a mean over the whole surface",
            detail="Over the image; not finite where a face is flattened.",
        ),
    ]
