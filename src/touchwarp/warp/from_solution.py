"""From the solution on the grid to the table: continue, hang, fit and round."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.solve.ghosts import extended_inwards
from touchwarp.solve.memory import give_back
from touchwarp.solve.multigrid import Lanes
from touchwarp.solve.problem import Problem
from touchwarp.solve.samples import (
    Samples,
    goal_at_samples,
    misfit,
    sample_surfaces,
    yielding_samples,
)
from touchwarp.solve.solution import Solution
from touchwarp.solve.tube import Tube
from touchwarp.warp.bricks import Bricks
from touchwarp.warp.build import bricks_of, hang, round_and_hang
from touchwarp.warp.fit import Fit, make_fit
from touchwarp.warp.table_grid import TableGrid


@dataclass(frozen=True, eq=False)
class Fitted:
    """A table's node values, before they are rounded and stored.

    Attributes:
        values: for each stage, (n, 4) m.
        moved: for each, (k,) the nodes in Ω that may have been moved from the solution: those that
            hang, and those that were fitted.
        samples: for each stage, points of the surfaces, and residuals: (s,) m, |table − g| there.
    """

    values: list[Lanes]
    moved: list[NDArray[np.int64]]
    samples: list[Samples]
    residuals: list[NDArray[np.float32]]


class TableMaker:
    """The way from node values to bricks for one grid; goals may change."""

    def __init__(self, problem: Problem, solution: Solution, grid: TableGrid, tube: Tube) -> None:
        """Sample the surfaces and set up the fit."""
        self.problem = problem
        self.grid = grid
        self._stages = stages = solution.stages
        self.samples = [
            sample_surfaces(stage, problem.boundary, leaf)
            for stage, leaf in zip(stages, self.grid.leaf, strict=True)
        ]
        self.fit: Fit = make_fit(self.grid, solution.regions, self.samples, problem.frame, tube)
        self._moved = []
        for rim, free, region in zip(grid.rim, self.fit.free, solution.regions, strict=True):
            moved = np.zeros(len(region), bool)
            moved[rim], moved[free] = True, True
            self._moved.append(np.flatnonzero(moved & (region == 1)))
        self._yielding = [
            yielding_samples(stage, sample, problem.blend)
            for stage, sample in zip(stages, self.samples, strict=True)
        ]

    def fits(self, solution: Solution) -> bool:
        """Whether a solution is on the grid that this was made for."""
        return [s.level for s in solution.stages] == [s.level for s in self._stages]

    def goals_at_samples(
        self, data: NDArray[np.float64], normal_lanes: NDArray[np.bool_]
    ) -> list[Lanes]:
        """For each stage, (s, 4): boundary data (v, 4) at its samples."""
        boundary = self.problem.boundary
        result = []
        for sample, yielding in zip(self.samples, self._yielding, strict=True):
            values = goal_at_samples(sample, boundary, data)
            yielding.apply(values, data, normal_lanes)
            result.append(values)
        return result

    def fitted(
        self,
        solution: Solution,
        data: NDArray[np.float64],
        normal_lanes: NDArray[np.bool_],
        lane_scale: NDArray[np.float32],
    ) -> Fitted:
        """The table of a solution, fitted to boundary data (v, 4).

        `lane_scale` (4,) weighs the lanes, to metres.
        """
        stages = solution.stages
        values = [
            extended_inwards(stage, region, normal_lanes)
            for stage, region in zip(stages, solution.regions, strict=True)
        ]
        for i in range(len(stages)):
            hang(self.grid, i, values)
        goals = self.goals_at_samples(data, normal_lanes)
        self.fit.apply(values, goals, normal_lanes)
        residuals = [
            misfit(*level, lane_scale)
            for level in zip(stages, self.samples, goals, values, strict=True)
        ]
        return Fitted(values, self._moved, self.samples, residuals)

    def bricks(self, fields: list[list[Lanes]], lanes: int) -> Bricks:
        """The table of fields' node values (n, 4), of each as many lanes; they are rounded in
        place."""
        give_back()
        round_and_hang(self.grid, fields)
        depth = self.problem.mirror_depth
        return bricks_of(self.problem.frame, self.grid, fields, lanes, depth)
