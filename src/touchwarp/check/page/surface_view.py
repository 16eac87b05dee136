"""The props' surfaces as numbers for the page's 3-D view."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.check.case import Case
from touchwarp.check.page.display_mesh import display_mesh, field, packed, sixteen
from touchwarp.check.page.map_view import map_fields, square_side, virtual_triangles
from touchwarp.check.page.palette import ERROR, MISMATCH, error_norm
from touchwarp.check.perception import normal_turn
from touchwarp.check.thresholds import FINGERTIP_OFFSET, FORCE_DIRECTION, Threshold

Float = NDArray[np.float64]

MOST_FACES = 40_000


def _mark(threshold: Threshold, mode: str) -> tuple[float, str] | None:
    """What people notice, where there is a number for the interaction mode."""
    if mode in threshold.modes and isinstance(threshold.limit, float):
        return threshold.limit, threshold.kind
    return None


def view_data(case: Case) -> dict[str, Any]:
    """Positions, fields and colours for viewer.js, numbers in base64.

    Positions are 16-bit between the corners of the box around props and virtual objects, fields
    8-bit between their ends. Triangles share no corners: each has its own three.
    """
    parts = [display_mesh(p, MOST_FACES // len(case.props)) for p in case.props]
    felt = np.concatenate([part[0] for part in parts])
    seen = np.concatenate([part[1] for part in parts])
    own = virtual_triangles(case)
    low = np.min([corners.min(axis=0) for corners in (felt, seen, own) if len(corners)], axis=0)
    high = np.max([corners.max(axis=0) for corners in (felt, seen, own) if len(corners)], axis=0)
    mismatch = 1e3 * np.linalg.norm(seen - felt, axis=1)
    error = 1e3 * case.contact_error(felt, seen)
    turn = np.concatenate([normal_turn(p)[q[2]] for p, q in zip(case.props, parts, strict=True)])
    norm = error_norm(1e3 * case.tolerance)
    ends = float(norm.vmin or 0.0), float(norm.vmax or 1.0)
    mode = case.scene.interaction.mode
    fields = [
        field(
            "error",
            "contact error",
            "mm",
            error,
            ends,
            ERROR,
            log=True,
            mark=(1e3 * case.tolerance, "tolerance"),
            note="How far the warp shows a touching finger from where the goal puts it.",
        ),
        field(
            "mismatch",
            "mismatch |u|",
            "mm",
            mismatch,
            (0.0, max(mismatch.max(), 1e-3)),
            MISMATCH,
            mark=_mark(FINGERTIP_OFFSET, mode),
            note="How far a touching finger is shown from where it is.",
        ),
        field(
            "turn",
            "turn of the normal",
            "°",
            turn,
            (0.0, max(turn.max(), 1.0)),
            MISMATCH,
            mark=_mark(FORCE_DIRECTION, mode),
            note="The angle between the surface that is felt and the one that is seen.",
        ),
    ]
    return {
        "low": (1e3 * low).round(3).tolist(),
        "high": (1e3 * high).round(3).tolist(),
        "count": len(felt),
        "felt": packed(sixteen(felt, low, high)),
        "seen": packed(sixteen(seen, low, high)),
        "virtual": packed(sixteen(own, low, high)),
        "fields": fields,
        "map_fields": map_fields(case, parts, fields[1:]) if case.maps else [],
        "square": 1e3 * square_side(case),
    }
