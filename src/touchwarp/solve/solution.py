"""What the solver hands over: u on every level, and the record of how it was found."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.solve.multigrid import Stage
from touchwarp.solve.region import Region


@dataclass(frozen=True, eq=False)
class Solution:
    """u on the adaptive grid.

    Attributes:
        stages: the levels from the root to the finest; `u` (n, 4) m, table axes, belongs to the
            solver and changes when it solves again.
        regions: for each, (n,) 1 where a node lies in Ω.
        needed: for each, (b,) bricks that the tolerance asked for, without margins.
        error: for each, (n, 4), the estimated discretisation error of each lane.
        nodes: of all levels, the coarse ones of multigrid included.
        spacing: m, the finest grid's.
        residual_history: (rows scaled by h²) greatest residual on the finest level after each
            cycle, in m; float32 floors it near 1e-6 of |u|.
        change_history: m, the greatest change of u in each of the final cycles.
        capped: the finest level was limited near edges by `edge_radius_mm`, not by the estimate.
        contradiction: m, greatest displacement asked for at a contact with a fixed surface that
            forbids it.
    """

    stages: list[Stage]
    regions: list[Region]
    needed: list[NDArray[np.bool_]]
    error: list[NDArray[np.float32]]
    nodes: int
    spacing: float
    residual_history: tuple[float, ...]
    change_history: tuple[float, ...]
    capped: bool
    contradiction: float
