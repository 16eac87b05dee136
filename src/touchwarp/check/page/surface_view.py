"""The props' surfaces as numbers for the page's 3-D view, and as a still picture for paper.

The view shows a thinned or refined copy of each mesh: small faces are merged, large ones divided,
so that values per vertex show what happens between the mesh's own vertices.
"""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.check.case import Case, PropCase
from touchwarp.check.page.palette import ERROR, MISMATCH, colour_bytes, css_gradient, error_norm
from touchwarp.check.perception import normal_turn

Float = NDArray[np.float64]
Int = NDArray[np.int64]

MOST_FACES = 40_000
DIVISIONS_ALONG = 70
"""Faces longer than the object over this are divided."""


def view_data(case: Case) -> dict[str, Any]:
    """Positions, fields and colours for viewer.js, numbers in base64.

    Positions are 16-bit between the corners of the box around props and virtual objects, fields
    8-bit between their ends. Triangles share no corners: each has its own three.
    """
    parts = [_display_mesh(p, MOST_FACES // len(case.props)) for p in case.props]
    felt = np.concatenate([part[0] for part in parts])
    seen = np.concatenate([part[1] for part in parts])
    low = np.minimum(felt.min(axis=0), seen.min(axis=0))
    high = np.maximum(felt.max(axis=0), seen.max(axis=0))
    mismatch = 1e3 * np.linalg.norm(seen - felt, axis=1)
    error = 1e3 * case.contact_error(felt, seen)
    turn = np.concatenate([part[2] for part in parts])
    norm = error_norm(1e3 * case.tolerance)
    top = max(float(mismatch.max()), 1e-3)
    steepest = max(float(turn.max()), 1.0)
    return {
        "low": (1e3 * low).round(3).tolist(),
        "high": (1e3 * high).round(3).tolist(),
        "count": len(felt),
        "felt": _packed(_sixteen(felt, low, high)),
        "seen": _packed(_sixteen(seen, low, high)),
        "fields": [
            {
                "key": "error",
                "name": "contact error",
                "unit": "mm",
                "values": _packed(_eight(np.asarray(norm(error)))),
                "low": float(norm.vmin or 0.0),
                "high": float(norm.vmax or 1.0),
                "log": True,
                "colours": _packed(colour_bytes(ERROR)),
                "gradient": css_gradient(ERROR),
                "mark": 1e3 * case.tolerance,
            },
            {
                "key": "mismatch",
                "name": "mismatch |u|",
                "unit": "mm",
                "values": _packed(_eight(mismatch / top)),
                "low": 0.0,
                "high": top,
                "log": False,
                "colours": _packed(colour_bytes(MISMATCH)),
                "gradient": css_gradient(MISMATCH),
                "mark": None,
            },
            {
                "key": "turn",
                "name": "turn of the normal",
                "unit": "°",
                "values": _packed(_eight(turn / steepest)),
                "low": 0.0,
                "high": steepest,
                "log": False,
                "colours": _packed(colour_bytes(MISMATCH)),
                "gradient": css_gradient(MISMATCH),
                "mark": None,
            },
        ],
    }


def _display_mesh(prop: PropCase, most: int) -> tuple[Float, Float, Float]:
    """Corners of triangles (3 t, 3) m on the prop and on the virtual object, and normal turns."""
    goal = prop.goal
    turn = normal_turn(prop)
    faces, turn = _thinned(goal.prop_points, goal.faces, turn, most)
    felt, seen = goal.prop_points[faces], goal.virtual_points[faces]
    extent = float(np.ptp(felt, axis=(0, 1)).max())
    return _divided(felt, seen, turn, extent / DIVISIONS_ALONG, most)


def _divided(
    felt: Float, seen: Float, turn: Float, longest: float, most: int
) -> tuple[Float, Float, Float]:
    """Triangles (t, 3, 3) halved across their longest edges until none is longer than `longest`.

    Returns:
        Corners (3 t, 3) m on the prop and on the virtual object, and normal turns (3 t,).
    """
    while len(felt) < most:
        length = np.linalg.norm(felt - np.roll(felt, -1, axis=1), axis=2)
        long = np.flatnonzero(length.max(axis=1) > longest)
        long = long[np.argsort(-length[long].max(axis=1))][: most - len(felt)]
        if len(long) == 0:
            break
        first = length[long].argmax(axis=1)
        halves = []
        for corners in (felt, seen):
            rows = np.arange(len(long))
            a, b, c = (corners[long][rows, (first + k) % 3] for k in range(3))
            middle = 0.5 * (a + b)
            one, two = np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)
            halves.append(np.concatenate([np.delete(corners, long, axis=0), one, two]))
        turn = np.concatenate([np.delete(turn, long), turn[long], turn[long]])
        felt, seen = halves
    return felt.reshape(-1, 3), seen.reshape(-1, 3), np.repeat(turn, 3)


def _thinned(points: Float, faces: Int, turn: Float, most: int) -> tuple[Int, Float]:
    """Faces with their vertices merged on ever coarser cubes, until there are few enough."""
    cells = 160
    kept = np.arange(len(faces))
    thinned = faces
    while len(thinned) > most:
        low = points.min(axis=0)
        side = float(np.ptp(points, axis=0).max()) / cells
        key = np.floor((points - low) / side).astype(np.int64)
        flat = (key[:, 0] << 40) + (key[:, 1] << 20) + key[:, 2]
        _, first, same = np.unique(flat, return_index=True, return_inverse=True)
        merged = first[same][faces]
        proper = (merged != np.roll(merged, 1, axis=1)).all(axis=1)
        kept = np.flatnonzero(proper)
        _, once = np.unique(np.sort(merged[kept], axis=1), axis=0, return_index=True)
        kept = kept[once]
        thinned = merged[kept]
        cells = int(cells * 0.8)
    return thinned, turn[kept]


def _sixteen(points: Float, low: Float, high: Float) -> NDArray[np.uint16]:
    span = np.maximum(high - low, 1e-12)
    return np.round(65535.0 * (points - low) / span).astype("<u2")


def _eight(values: Float) -> NDArray[np.uint8]:
    return np.round(255.0 * np.clip(np.nan_to_num(values, nan=1.0), 0.0, 1.0)).astype(np.uint8)


def _packed(array: NDArray[Any]) -> str:
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode("ascii")
