"""From the solution on the grid to the table: continue, hang, fit and round."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.solve.ghosts import extend_inwards
from touchwarp.solve.problem import Problem
from touchwarp.solve.samples import Samples, goal_at_samples, sample_points, sample_surfaces
from touchwarp.solve.solution import Solution
from touchwarp.solve.tube import Tube
from touchwarp.warp.bricks import Bricks
from touchwarp.warp.build import bricks_of, hang, round_and_hang
from touchwarp.warp.fit import Fit, make_fit
from touchwarp.warp.table_grid import TableGrid

Real = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Fitted:
    """A table's node values, before they are rounded and stored.

    Attributes:
        values: for each stage, (n, 4) m.
        moves: for each stage, (n, 4) m: how far they are from the solution.
        samples: for each stage, points of the surfaces, and residuals: (s,) m, |table − g| there.
    """

    values: list[Real]
    moves: list[Real]
    samples: list[Samples]
    residuals: list[Real]


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
        self._terms = []
        for stage, sample in zip(stages, self.samples, strict=True):
            owner = problem.boundary.owner[sample.triangle]
            self._terms.append(problem.blend.terms(sample_points(stage, sample), owner))

    def fits(self, solution: Solution) -> bool:
        """Whether a solution is on the grid that this was made for."""
        return [s.level for s in solution.stages] == [s.level for s in self._stages]

    def goals_at_samples(
        self, data: NDArray[np.float64], normal_lanes: NDArray[np.bool_]
    ) -> list[Real]:
        """For each stage, (s, 4): boundary data (v, 4) at its samples."""
        boundary = self.problem.boundary
        result = []
        for sample, terms in zip(self.samples, self._terms, strict=True):
            values = goal_at_samples(sample, boundary, data)
            self.problem.blend.apply(values, terms, data, normal_lanes)
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
        values = [stage.u.astype(np.float64) for stage in stages]
        for stage, region, v in zip(stages, solution.regions, values, strict=True):
            extend_inwards(stage, region, v, normal_lanes)
        for i in range(len(stages)):
            hang(self.grid, i, values)
        goals = self.goals_at_samples(data, normal_lanes)
        self.fit.apply(values, goals, normal_lanes)
        moves = [v - stage.u for v, stage in zip(values, stages, strict=True)]
        return Fitted(values, moves, self.samples, self.fit.residuals(values, goals, lane_scale))

    def bricks(self, solution: Solution, values: list[Real]) -> Bricks:
        """The table of node values (n, C), which are rounded in place."""
        round_and_hang(self.grid, values)
        return bricks_of(self.problem.frame, self.grid, values, self.problem.mirror_depth)
