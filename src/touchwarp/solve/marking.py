"""Which octants of a level a finer one must take over."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.solve.ghosts import extended_inwards
from touchwarp.solve.memory import NODES_PER_BRICK
from touchwarp.solve.multigrid import Stage
from touchwarp.solve.problem import Problem
from touchwarp.solve.refine import greatest_of_octants, indicate, octant_of
from touchwarp.solve.region import Region
from touchwarp.solve.samples import (
    goal_at_samples,
    misfit,
    sample_points,
    sample_surfaces,
    yielding_samples,
)
from touchwarp.solve.tube import Tube

SAFETY = 0.75
"""Octants are split above this share of the tolerance: the errors of interpolation and of
discretisation add up."""

STRONG = 4.0
"""Octants above the limit by this factor will be split again on the next level."""

MISFIT = 4.0
"""Octants are split, too, where the table before its fit is off g by this many times the limit."""

PER_CELL = 2
"""Samples along a cell's side by which misfits are found."""

BESIDE = 1e-3 * np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3, indexing="ij"), axis=-1).reshape(8, 3)
"""Steps, in cells, into the cells that share a node."""

BEYOND = 3
"""Levels finer than the least cells near edges that smooth parts may have, …"""

FURTHER = 2
"""… and how many more, where a goal is steeper than these resolve, …"""

LEVEL_SHARE = 0.1
"""… as long as each adds no more than this share of the nodes: where it jumps, none would do."""


class Marker:
    """The rule by which octants are marked, and what was asked for besides.

    Attributes:
        deepest: in the tube, and for misfits, no level is finer.
        limit: elsewhere no level is.
        capped: whether a limit has kept an octant from being marked.
    """

    def __init__(self, problem: Problem, tolerance: float, deepest: int) -> None:
        """`tolerance` in m."""
        self.problem = problem
        self.tolerance = tolerance
        self.deepest = deepest
        self.limit = deepest + BEYOND + FURTHER
        self.capped = False
        self._points = np.empty((0, 3))
        self._depths = np.empty(0, np.int64)

    def demand(self, points: NDArray[np.float64], depths: NDArray[np.int64]) -> None:
        """Ask for cells finer than level `depths` (k,) at root-grid points (k, 3)."""
        self._points = np.concatenate([self._points, points])
        self._depths = np.concatenate([self._depths, depths])

    def marks(
        self,
        stage: Stage,
        region: Region,
        data: NDArray[np.float64],
        normal_lanes: NDArray[np.bool_],
        lane_scale: NDArray[np.float32],
        tube: Tube | None,
        nodes: int,
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """(b, 8) octants to split, and those of them that will be split again.

        Args:
            stage, region: the level.
            data, normal_lanes: boundary data (v, 4), and its lanes that vanish on the plane.
            lane_scale: (4,) weight of each lane, to metres.
            tube: where cells are not split on this level; None for nowhere.
            nodes: of the grid so far.
        """
        limit, depth = SAFETY * self.tolerance, stage.level.depth
        none = np.zeros((len(stage.level.bricks), 8), bool)
        if depth >= self.limit:
            self.capped = True
            return none, none
        value = indicate(stage, region, lane_scale, normal_lanes)
        of_octant = greatest_of_octants(stage.level, value)
        marked, strong = of_octant > limit, of_octant > STRONG * limit
        if tube is not None and marked.any():
            over = np.flatnonzero(value > limit)
            where = stage.level.coordinates(over) / 2.0**depth
            over = over[~tube.contains(self.problem.frame.to_scene(where))]
            outside = _octants(stage, stage.level.site[over])
            self.capped = self.capped or bool((marked & ~outside).any())
            marked = outside
            strong = _octants(stage, stage.level.site[over[value[over] > STRONG * limit]])
        marked |= self._misfits(stage, region, data, normal_lanes, lane_scale, marked, tube)
        demanded = self._demanded(stage)
        marked, strong = marked | demanded, strong | demanded
        added = NODES_PER_BRICK * int(marked.sum())
        if depth >= self.deepest + BEYOND and added > LEVEL_SHARE * nodes:
            self.limit, self.capped = depth, True
            return none, none
        return marked, strong

    def _misfits(
        self,
        stage: Stage,
        region: Region,
        data: NDArray[np.float64],
        normal_lanes: NDArray[np.bool_],
        lane_scale: NDArray[np.float32],
        marked: NDArray[np.bool_],
        tube: Tube | None,
    ) -> NDArray[np.bool_]:
        """Octants in which a table of this level's values would be far from g on the surfaces.

        Thin walls, sheets and tight curves show here: their cells serve two sides.
        """
        level, problem = stage.level, self.problem
        if level.depth >= self.deepest:
            return np.zeros_like(marked)
        samples = sample_surfaces(
            stage, problem.boundary, ~marked & level.has_cells[:, None], PER_CELL
        )
        if len(samples.cell) == 0:
            return np.zeros_like(marked)
        goal = goal_at_samples(samples, problem.boundary, data)
        yielding_samples(stage, samples, problem.blend).apply(goal, data, normal_lanes)
        values = extended_inwards(stage, region, normal_lanes)
        over = misfit(stage, samples, goal, values, lane_scale) > (MISFIT * SAFETY * self.tolerance)
        if tube is not None:
            points = sample_points(stage, samples, over)
            over[over] = ~tube.contains(problem.frame.to_scene(points))
        return _octants(stage, samples.cell[over])

    def _demanded(self, stage: Stage) -> NDArray[np.bool_]:
        level = stage.level
        points = self._points[self._depths >= level.depth] * 2.0**level.depth
        # A node is on the faces of up to eight cells, some of which may not be on this level.
        beside = (points[:, None] + BESIDE).reshape(-1, 3)
        cell = np.clip(np.floor(beside).astype(np.int64), 0, level.cells - 1)
        brick = level.index_of(cell // 8)
        known = brick >= 0
        return _octants(stage, 512 * brick[known] + cell[known] % 8 @ np.array([64, 8, 1]))


def _octants(stage: Stage, site: NDArray[np.integer]) -> NDArray[np.bool_]:
    """(b, 8) the octants that hold the given places, 512 · brick + 64x + 8y + z."""
    marks = np.zeros((len(stage.level.bricks), 8), bool)
    brick, local = np.divmod(site, 512)
    marks[brick, octant_of(local)] = True
    return marks
