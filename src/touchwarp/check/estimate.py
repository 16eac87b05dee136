"""The solver's own estimate of its error, against the tolerance that was asked for."""

from __future__ import annotations

import numpy as np

from touchwarp.check.case import Case, Finding
from touchwarp.check.report import Check, measured, unmeasured

KEPT_BY_SOLVER = "the greatest that the solver found, which keeps no place of it"


def check_estimate(case: Case) -> Finding:
    """What the warp says of its own error; a warp that says nothing stays "unknown"."""
    title = "Error of the field, as the solver estimates it"
    greatest = None if case.meta is None else case.meta.estimated_error_max_mm
    if case.meta is None or greatest is None:
        return Finding(
            [
                unmeasured(
                    "estimate.max",
                    title,
                    "mm",
                    detail=f"This {type(case.warp).__name__} carries no estimate of its error.",
                )
            ],
            {},
        )
    detail = f"Farther than {case.meta.edge_radius_mm:g} mm from sharp edges and rims."
    if case.meta.estimated_error_rms_mm is not None:
        detail += f" The rms is {case.meta.estimated_error_rms_mm:.2g} mm."
    checks = [
        measured(
            "estimate.max",
            title,
            greatest,
            "mm",
            limit=1e3 * case.tolerance,
            whole=KEPT_BY_SOLVER,
            detail=detail,
            source="tolerance of the scene",
        )
    ]
    return Finding(checks + _told_by_solution(case), {})


def _told_by_solution(case: Case) -> list[Check]:
    """What only a warp that comes straight from the solver can tell."""
    solution = getattr(case.warp, "solution", None)
    checks = []
    at_edges = getattr(solution, "estimated_edge_error_mm", None)
    if at_edges is not None and len(np.concatenate([p.edges.length for p in case.props])):
        capped = getattr(solution, "capped", False)
        checks.append(
            measured(
                "estimate.edges",
                "Error of the field at sharp edges, as the solver estimates it",
                at_edges,
                "mm",
                group="told",
                whole=KEPT_BY_SOLVER,
                detail="Within the edge radius, where the exact warp is singular."
                + (" The finest level was capped there." if capped else ""),
            )
        )
    contradiction = getattr(solution, "contradiction_mm", 0.0)
    if contradiction:
        checks.append(
            measured(
                "estimate.contradiction",
                "Displacement that a goal asks for against a fixed surface",
                contradiction,
                "mm",
                group="told",
                whole=KEPT_BY_SOLVER,
                detail="Where a prop meets what is fixed; one is blended into the other there.",
            )
        )
    return checks
