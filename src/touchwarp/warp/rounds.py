"""Rounds of solving and fitting, until the table meets its tolerance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.solve.adaptive import AdaptiveSolver, Progress
from touchwarp.solve.solution import Solution
from touchwarp.warp.from_solution import Fitted, TableMaker
from touchwarp.warp.table_error import TableError, estimate_error, interpolation_error
from touchwarp.warp.table_grid import TableGrid

MOST_ROUNDS = 5
"""Grids built at most: the first, and finer ones where its table missed the tolerance."""


@dataclass(frozen=True, eq=False)
class Round:
    """A solution, the table fitted from it, and what that table is estimated to miss."""

    solution: Solution
    maker: TableMaker
    fitted: Fitted
    error: TableError


def fit_round(
    solver: AdaptiveSolver,
    maker: TableMaker | None,
    data: NDArray[np.float64],
    normal_lanes: NDArray[np.bool_],
    lane_scale: NDArray[np.float32],
    *,
    refine: Callable[[TableError], bool] | None = None,
    slack: float = 1.0,
) -> Round | None:
    """Fit a table to what `solver` has found for boundary data (v, 4).

    Args:
        solver: it has solved for the data.
        maker: of an earlier round; it is used again if the grid is the same.
        data, normal_lanes, lane_scale: as for the solver.
        refine: asks the solver for finer cells where the tolerance is missed. Where it will give
            them the result is None, and it has to build again. The field is looked at before the
            fit, which takes as long as a solve.
        slack: errors up to this many times the solver's tolerance will do.
    """
    problem = solver.problem
    solution = solver.solution(problem.blend.contradiction(data, normal_lanes))
    known = maker if maker is not None and maker.fits(solution) else None
    grid = known.grid if known is not None else TableGrid.of(solution)
    interpolation = interpolation_error(solution, lane_scale, normal_lanes)

    def estimate(fitted: Fitted | None) -> TableError:
        tolerance = slack * solver.tolerance
        return estimate_error(
            problem, solution, grid, solver.tube, lane_scale, tolerance, interpolation, fitted
        )

    # a fit that only has to be applied takes little more than this look
    if refine is not None and known is None and refine(estimate(None)):
        return None
    maker = known or TableMaker(problem, solution, grid, solver.tube)
    fitted = maker.fitted(solution, data, normal_lanes, lane_scale)
    error = estimate(fitted)
    if refine is not None and refine(error):
        return None
    return Round(solution, maker, fitted, error)


def refine_rounds(
    solver: AdaptiveSolver,
    maker: TableMaker | None,
    data: NDArray[np.float64],
    normal_lanes: NDArray[np.bool_],
    lane_scale: NDArray[np.float32],
    tell: Progress,
) -> Round:
    """Rounds until the tolerance is met, or the solver gives no finer cells."""
    rounds_left = MOST_ROUNDS - 1

    def refine(error: TableError) -> bool:
        nonlocal rounds_left
        if error.outside_tube_max > solver.tolerance and solver.sharpen():
            return True
        demanded = solver.demand(error.poor_points, error.poor_depths)
        rounds_left -= demanded
        return demanded

    while rounds_left:
        tell("fitting the table to the goal", 0.92)
        result = fit_round(solver, maker, data, normal_lanes, lane_scale, refine=refine)
        if result is not None:
            return result
        solver.build(data, normal_lanes, lane_scale)
    last = fit_round(solver, maker, data, normal_lanes, lane_scale)
    assert last is not None
    return last
