"""When cycling may end: further cycles would change u by much less than the tolerance."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import SolveError
from touchwarp.solve.multigrid import Lanes, Multigrid

MOST_CYCLES = 30

SETTLED = 0.04
"""Cycling ends when further cycles would change u by less than this share of the tolerance, by what
the last one changed and how much less that was than the one before. What they would still change is
part of the error's estimate, which is a cycle itself. …"""

FIRST_RATE = 0.1
"""… In the first cycle this stands for how much less …"""

RATE_OF_RESIDUALS = 2.0
"""… or this many times the ratio of the residuals after it and before it, if that is less: changes
fall by 1.1 to 2.3 times that ratio …"""

ROUNDING = 4e-6
"""… or when the last has changed u by less than this share of the greatest |u|: float32's noise."""


def settle(
    multigrid: Multigrid, lane_scale: NDArray[np.float32], enough: float
) -> tuple[list[float], list[float]]:
    """Cycle until further cycles would change u by less than `enough` m.

    Args:
        multigrid: its finest level is looked at.
        lane_scale: (4,) weight of each lane, to metres.
        enough: m.

    Returns:
        The greatest residual before and after each cycle, and the greatest change in each, m.

    Raises:
        SolveError: u keeps changing.
    """
    finest, last = multigrid.stages[-1], len(multigrid.stages) - 1
    residuals, changes = [_greatest(multigrid.residual(last))], list[float]()
    for _ in range(MOST_CYCLES):
        before = finest.u.copy()
        multigrid.cycle()
        residuals.append(_greatest(multigrid.residual(last)))
        before -= finest.u
        before *= lane_scale
        changes.append(_greatest(before))
        if len(changes) > 1:
            rate = min(changes[-1] / max(changes[-2], 1e-300), 0.5)
        else:
            rate = min(RATE_OF_RESIDUALS * residuals[1] / max(residuals[0], 1e-300), FIRST_RATE)
        floor = ROUNDING * _greatest(finest.u * lane_scale)
        if changes[-1] * rate / (1.0 - rate) <= enough or changes[-1] <= floor:
            return residuals, changes
    history = ", ".join(f"{c * 1e3:.3g}" for c in changes)
    raise SolveError(
        f"No convergence in {MOST_CYCLES} cycles (change of u in mm: {history}; "
        f"{enough * 1e3:.3g} was needed). Give the scene's file to the developers: this should not "
        "happen."
    )


def _greatest(values: Lanes) -> float:
    return float(max(values.max(initial=0.0), -values.min(initial=0.0)))
