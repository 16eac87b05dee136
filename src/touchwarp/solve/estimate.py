"""How far the solution on the grid is from the exact one, by τ-extrapolation.

FAS gives each coarser level the defect correction τ, the difference between the two levels'
discretisations. For a second-order scheme a third of it is what the finer level itself still
misses. Adding that third where the finer level is the finest there is, and solving the coarser
levels once more, moves the solution towards the exact one by about its own error.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.solve.multigrid import COARSEST_SWEEPS, SWEEPS, Multigrid, Stage

SHARE = np.float32(1.0 / 3.0)


def discretisation_error(multigrid: Multigrid) -> list[NDArray[np.float32]]:
    """For each stage, (n, 4) m: how much τ-extrapolation changes a converged solution.

    The solution is left as it was.
    """
    stages = multigrid.stages
    last = len(stages) - 1
    kept = [stage.u.copy() for stage in stages]
    increments: dict[int, tuple[NDArray[np.int32], NDArray[np.float32]]] = {}
    for i in range(last, multigrid.root, -1):
        multigrid.coarsen_equation(i)
        under, over = stages[i].covered
        finest = _finest(under, stages[i + 1] if i < last else None)
        increments[i - 1] = over[finest], SHARE * stages[i - 1].f[over[finest]]

    def cycle(i: int) -> None:
        if i == 0:
            multigrid.smooth(0, COARSEST_SWEEPS)
            return
        multigrid.smooth(i, SWEEPS)
        descend(i)
        multigrid.smooth(i, SWEEPS)

    def descend(i: int) -> None:
        multigrid.coarsen_equation(i)
        if i - 1 in increments:
            nodes, change = increments[i - 1]
            stages[i - 1].f[nodes] += change
        cycle(i - 1)
        multigrid.correct(i)

    descend(last)
    errors = []
    for stage, u in zip(stages, kept, strict=True):
        errors.append(np.abs(stage.u - u))
        stage.u[:] = u
    return errors


def _finest(nodes: NDArray[np.int32], finer: Stage | None) -> NDArray[np.bool_]:
    """Which of a level's nodes no finer level covers."""
    if finer is None:
        return np.ones(len(nodes), bool)
    covered = np.zeros(int(nodes.max(initial=-1)) + 1, bool)
    over = finer.covered[1]
    covered[over[over < len(covered)]] = True
    return ~covered[nodes]
