"""Continuity: the bricks of a table agree wherever they meet, also across levels."""

from __future__ import annotations

import numpy as np

from touchwarp.check.brick_faces import jumps
from touchwarp.check.case import Case, Finding
from touchwarp.check.report import measured, place, unmeasured
from touchwarp.warp.bricks import Bricks
from touchwarp.warp.plane_table import PlaneTableWarp

ALLOWED_JUMP = 1e-9
"""m, in float64 evaluation."""

POINTS_PER_FACE = 2
MOST_POINTS = 600_000

STEP = 1e-11
"""m, from a plane table's line to either side: slopes add less than the allowed jump."""


def check_continuity(case: Case) -> Finding:
    """The greatest jump of f across the faces and edges of a table's bricks."""
    bricks = getattr(case.warp, "bricks", None)
    title = "Jump of f across bricks and levels"
    if isinstance(case.warp, PlaneTableWarp):
        return _across_lines(case, case.warp, title)
    if not isinstance(bricks, Bricks) or bricks.values.shape[-1] != 3:
        return Finding(
            [
                unmeasured(
                    "continuity.jump",
                    title,
                    "mm",
                    detail=f"A {type(case.warp).__name__} is not a table of bricks.",
                )
            ],
            {},
        )
    jump, points, count = jumps(bricks, POINTS_PER_FACE, MOST_POINTS, case.random("continuity"))
    worst = int(jump.argmax())
    stored = 0.0 if case.meta is None else case.meta.storage_jump
    detail = f"{len(jump):,} points on the faces and edges of {count:,} bricks, from every side."
    if stored > 0.0:
        detail += f" Storage in 16 bits may add {1e3 * stored:.2g} mm."
    return Finding(
        [
            measured(
                "continuity.jump",
                title,
                1e3 * float(jump[worst]),
                "mm",
                limit=1e3 * max(ALLOWED_JUMP, 1.01 * stored),
                where=place(points, worst),
                detail=detail,
                source="construction of the table",
            )
        ],
        {},
    )


def _across_lines(case: Case, warp: PlaneTableWarp, title: str) -> Finding:
    """The same for a plane table, on either side of its grid lines."""
    rng = case.random("continuity")
    table = warp.table
    lines = (table.x_lines, table.y_lines)
    on, aside = [], []
    for axis in (0, 1):
        points = rng.uniform([a[0] for a in lines], [a[-1] for a in lines], (MOST_POINTS // 6, 2))
        points[:, axis] = rng.choice(lines[axis], len(points))
        on.append(points)
        aside.append(np.tile(STEP * np.eye(2)[axis], (len(points), 1)))
    T = table.T_scene_table
    points = np.concatenate(on) @ T[:2, :2].T + T[:2, 2]
    step = np.concatenate(aside) @ T[:2, :2].T
    jump = np.linalg.norm(
        warp.displacement(points + step) - warp.displacement(points - step), axis=1
    )
    jump = np.where(np.isfinite(jump), jump, np.inf)
    worst = int(jump.argmax())
    return Finding(
        [
            measured(
                "continuity.jump",
                title,
                1e3 * float(jump[worst]),
                "mm",
                limit=1e3 * ALLOWED_JUMP,
                where=place(points, worst),
                detail=f"{len(jump):,} points on the lines of the grid, from both sides.",
                source="construction of the table",
            )
        ],
        {},
    )
