"""How far the solution on the grid is from the exact one, by τ-extrapolation.

FAS gives each coarser level the defect correction τ, the difference between the two levels'
discretisations. For a second-order scheme a third of it is what the finer level itself still
misses. Adding that third where the finer level is the finest there is, and solving the coarser
levels once more, moves the solution towards the exact one by about its own error.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.solve.multigrid import COARSEST_SWEEPS, SWEEPS, Multigrid

GROWTH = np.float32(4.0 / 3.0)
"""τ, and the third of it that is added."""


def discretisation_error(
    multigrid: Multigrid, lane_scale: NDArray[np.float32]
) -> list[NDArray[np.float32]]:
    """For each stage, (n,) m: how much τ-extrapolation changes a converged solution.

    `lane_scale` (4,) weighs the lanes, to metres. The solution is left as it was.
    """
    stages = multigrid.stages
    last = len(stages) - 1
    kept = [stage.u.copy() for stage in stages]

    def cycle(i: int) -> None:
        if i == 0:
            multigrid.smooth(0, COARSEST_SWEEPS)
            return
        multigrid.smooth(i, SWEEPS)
        descend(i)
        multigrid.smooth(i, SWEEPS)

    def descend(i: int) -> None:
        multigrid.coarsen_equation(i)
        if i > multigrid.root:
            multigrid.amplify_equation(i, GROWTH)
        cycle(i - 1)
        multigrid.correct(i)

    descend(last)
    errors = []
    for stage, u in zip(stages, kept, strict=True):
        stage.u -= u
        stage.u *= lane_scale
        errors.append(np.sqrt(np.einsum("ij,ij->i", stage.u, stage.u)))
        stage.u[:] = u
    return errors
