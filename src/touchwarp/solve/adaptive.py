"""Full multigrid that grows its grid: solve a level, see where it is too coarse, add the next."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from touchwarp.solve.blend import Yielding, terms_of_cuts
from touchwarp.solve.edges import points_along, sharp_edges
from touchwarp.solve.estimate import discretisation_error
from touchwarp.solve.ghosts import extended_inwards
from touchwarp.solve.interface import hanging_values
from touchwarp.solve.level import LOCAL, OFFSETS
from touchwarp.solve.marking import SAFETY, Marker
from touchwarp.solve.memory import check_memory
from touchwarp.solve.multigrid import SWEEPS, Lanes, Multigrid, Stage
from touchwarp.solve.problem import Problem
from touchwarp.solve.refine import octant_coordinates, surrounded, unique_rows, widened
from touchwarp.solve.region import Region, agree, flood_level
from touchwarp.solve.settling import SETTLED, settle
from touchwarp.solve.solution import Solution
from touchwarp.solve.stencil import LANES
from touchwarp.solve.tube import Tube

Progress = Callable[[str, float], None]

CELLS_ACROSS_TUBE = 2.0
"""The finest cells near edges are no larger than the tube's radius over this, …"""

MOST_CELLS_ACROSS_TUBE = 8.0
"""… and no smaller than this share of it."""

RIM = 0.5
"""A level is widened where the coarser one misses its rim by more than this share of the tolerance,
…"""

AGAIN = 0.75
"""… and again while it misses the new rim by more than this. The table keeps what is missed."""

FEW = 0.1
"""No round is made for points that are fewer than this share of those where cells are capped."""

HELPED = 0.9
"""Finer cells near edges have helped if the error outside the tube is below this share of the one
before."""


class AdaptiveSolver:
    """A problem, its grid, and u on it; the grid is kept when only the data change.

    Attributes:
        settled: see `settling.SETTLED`; what shall be summed from several solutions asks for less.
    """

    def __init__(
        self,
        problem: Problem,
        tolerance: float,
        edge_radius: float,
        memory_limit: float,
        progress: Progress | None = None,
    ) -> None:
        """Prepare the root levels.

        Args:
            problem: what to solve.
            tolerance: m, bound on the table's error in Ω outside the tube.
            edge_radius: m, radius of the tube around sharp edges.
            memory_limit: bytes.
            progress: called with what is being done and the share done.
        """
        self.problem = problem
        self.tolerance = tolerance
        self.edge_radius = edge_radius
        self.memory_limit = memory_limit
        self.settled = SETTLED
        self._tell = progress or (lambda text, share: None)
        self.multigrid = Multigrid(problem.frame, problem.boundary, problem.screening)
        self.regions: list[Region] = []
        self.residuals: list[float] = []
        self.changes: list[float] = []
        deepest = self._depth_of(edge_radius / MOST_CELLS_ACROSS_TUBE)
        self.marker = Marker(problem, tolerance, deepest)
        self._data = np.empty((0, LANES))
        self._lane_scale = np.ones(LANES, np.float32)
        self._yielding: list[Yielding] = []
        self._needed = [stage.level.has_cells for stage in self.multigrid.stages]
        self._demanded = False
        self._depth_at_edges = self._depth_of(edge_radius / CELLS_ACROSS_TUBE)
        self._errors: list[NDArray[np.float32]] = []
        self._missed = np.inf
        corners = problem.frame.to_scene(problem.boundary.corners)
        edges = sharp_edges(corners, problem.boundary.faces)
        self.tube = Tube(points_along(corners, edges, 0.25 * max(edge_radius, 1e-4)), edge_radius)

    def build(
        self,
        data: NDArray[np.float64],
        normal_lanes: NDArray[np.bool_],
        lane_scale: NDArray[np.float32],
    ) -> None:
        """Grow a grid for boundary data (v, 4) until the tolerance should be met, edges apart.

        A second call follows `sharpen` or `demand`; no cell is taken away, and where the data are
        those solved for last, levels start from what they had.

        Args:
            data: boundary data at the corners.
            normal_lanes: (4,) lanes that vanish on the sliding plane.
            lane_scale: (4,) weight of each lane in the indicator, to metres.

        Raises:
            SolveError: memory would not suffice, or no convergence.
        """
        self._lane_scale = lane_scale
        self._errors = []
        if not self.regions:
            self._data, self.multigrid.floor_zero = data, normal_lanes
            for i in range(len(self.multigrid.stages)):
                self._start(i, data)
        earlier = self._taken_away() if self._demanded else []
        known = self._set_data(data, normal_lanes)
        if not known:
            self.multigrid.cycle()
        while True:
            bricks = needed = self._next_bricks(data, lane_scale, self._depth_at_edges)
            before = None
            if earlier:
                before, was_needed = earlier.pop(0)
                have = before.level.bricks[before.level.has_cells].astype(np.int64)
                bricks = unique_rows(np.concatenate([bricks, have]), before.level.cells // 8)
                needed = np.concatenate([needed, before.level.bricks[was_needed]])
            if len(bricks) == 0:
                break
            check_memory(
                self.nodes, len(bricks), self.memory_limit, self.tolerance, self._error_outside_tube
            )
            self._add_level(bricks, needed, data, before if known else None)
            self._tell(f"{self.nodes:,} nodes", self._share_done())
        agree(self.multigrid.stages, self.regions, self.problem.boundary.owner)
        self._find_thin_parts()
        self.settle()

    def sharpen(self) -> bool:
        """Make the next `build` finer near edges, by a level; whether that may be, and may help.

        It may where the discretisation error outside the tube is large, and falls by it.
        """
        stages = self.multigrid.stages
        finest = stages[-1].level.depth
        if not self._depth_at_edges <= finest < self.marker.deepest:
            return False
        before, self._missed = self._missed, self._error_outside_tube()
        if self._missed < SAFETY * self.tolerance or self._missed > HELPED * before:
            return False
        self._depth_at_edges = finest + 1
        return True

    def solve(self, data: NDArray[np.float64], normal_lanes: NDArray[np.bool_]) -> None:
        """Solve for other boundary data (v, 4) on the grid as it is, from the last solution.

        Raises:
            SolveError: no convergence.
        """
        self._missed = np.inf
        self._set_data(data, normal_lanes)
        self.settle()

    def demand(self, points: NDArray[np.float64], depths: NDArray[np.int64]) -> bool:
        """Make the next `build` refine cells of levels `depths` (k,) at root-grid points (k, 3).

        Cells at the marker's limits are left. Whether any other is asked for, and such cells are
        more than a few beside those that are left: the tolerance is missed there.
        """
        in_tube = self.tube.contains(self.problem.frame.to_scene(points))
        can = depths < np.where(in_tube, self.marker.deepest, self.marker.limit)
        self.marker.capped |= not can.all()
        if np.count_nonzero(can) <= FEW * np.count_nonzero(~can):
            return False
        self.marker.demand(points[can], depths[can])
        self._missed = np.inf
        self._demanded = True
        return True

    def settle(self) -> None:
        """Cycle until u no longer changes, and estimate its error.

        Raises:
            SolveError: it keeps changing.
        """
        enough = self.settled * self.tolerance
        self.residuals, self.changes = settle(self.multigrid, self._lane_scale, enough)
        self._errors = discretisation_error(self.multigrid, self._lane_scale)
        self.multigrid.release()

    @property
    def nodes(self) -> int:
        """Nodes of all levels."""
        return sum(stage.level.n for stage in self.multigrid.stages)

    def solution(self, contradiction: float) -> Solution:
        """What has been found."""
        grid = self.multigrid
        root = grid.root
        return Solution(
            grid.stages[root:],
            self.regions[root:],
            self._needed[root:],
            self._errors[root:],
            self.nodes,
            float(self.problem.frame.spacing.min() / 2.0 ** grid.stages[-1].level.depth),
            tuple(self.residuals),
            tuple(self.changes),
            self.marker.capped,
            contradiction,
        )

    def _taken_away(self) -> list[tuple[Stage, NDArray[np.bool_]]]:
        """All refined levels and what was needed of them; coarser ones can make room for finer
        ones when these come again."""
        self._demanded = False
        first = self.multigrid.root + 1
        taken = list(zip(self.multigrid.drop_from(first), self._needed[first:], strict=True))
        for levels in (self.regions, self._yielding, self._needed):
            del levels[first:]
        return taken

    def _set_data(self, data: NDArray[np.float64], normal_lanes: NDArray[np.bool_]) -> bool:
        """Give all levels their boundary data (v, 4); whether they had them."""
        grid = self.multigrid
        if np.array_equal(data, self._data) and np.array_equal(normal_lanes, grid.floor_zero):
            return True
        self._data, grid.floor_zero = data, normal_lanes
        for i in range(len(grid.stages)):
            grid.set_stage_goal(i, data, self._yielding[i])
        return False

    def _start(self, i: int, data: NDArray[np.float64], narrow: Stage | None = None) -> None:
        """First values on level i: from the coarser one, or from the level that i replaces."""
        grid = self.multigrid
        if len(self._yielding) == i:
            stage, blend = grid.stages[i], self.problem.blend
            find = partial(terms_of_cuts, blend, stage.level, stage.cuts)
            self._yielding.append(Yielding(blend, find))
        grid.set_stage_goal(i, data, self._yielding[i])
        if i == 0:
            grid.smooth(0, 60)
        else:
            grid.start_from_coarser(i)
            if narrow is not None:
                grid.take_values(i, narrow)
                grid.smooth(i, SWEEPS)
            else:
                grid.cycle(i)
        if len(self.regions) == i:
            stages, owner = grid.stages, self.problem.boundary.owner
            coarser = self.regions[i - 1] if i else None
            self.regions.append(
                flood_level(stages[i], coarser, stages[i - 1] if i else None, owner)
            )

    def _next_bricks(
        self, data: NDArray[np.float64], lane_scale: NDArray[np.float32], depth_at_edges: int
    ) -> NDArray[np.int64]:
        """(k, 3) bricks of the level after the finest, which may first be widened to hold them."""
        stages = self.multigrid.stages
        octants, strong = self._marked(data, lane_scale, depth_at_edges)
        if stages[-1].level.depth > 0:
            # widening leaves the coarser level as it is
            coarser = extended_inwards(stages[-2], self.regions[-2], self.multigrid.floor_zero)
            margin = np.concatenate(
                [widened(stages[-1], octants, 1), widened(stages[-1], strong, 2)]
            )
            missed = self._missed_by_coarser(coarser, depth_at_edges, RIM)
            if self._widen(margin // 2, missed, data):
                while len(missed := self._missed_by_coarser(coarser, depth_at_edges, AGAIN)):
                    if not self._widen(missed, missed, data):
                        break
                octants, _ = self._marked(data, lane_scale, depth_at_edges)
        return octants[surrounded(stages[-1], octants)]

    def _widen(
        self, margin: NDArray[np.int64], needed: NDArray[np.int64], data: NDArray[np.float64]
    ) -> bool:
        """Add bricks (k, 3) to the finest level, and solve it again; whether there were any to add.

        Args:
            margin: for the next level's sake.
            needed: for the tolerance.
            data: boundary data.
        """
        level, coarser = self.multigrid.stages[-1].level, self.multigrid.stages[-2]
        shape = level.cells // 8
        have = level.bricks[level.has_cells].astype(np.int64)
        bricks = unique_rows(np.concatenate([have, margin, needed]), shape)
        there = level.index_of(bricks)
        old = (there >= 0) & level.has_cells[there]
        bricks = bricks[old | surrounded(coarser, bricks)]
        if len(bricks) == len(have):
            there = level.index_of(needed)
            self._needed[-1][there[there >= 0]] = True
            self._needed[-1] &= level.has_cells
            return False
        before = level.bricks[self._needed[-1]].astype(np.int64)
        (narrow,) = self.multigrid.drop_from(len(self.multigrid.stages) - 1)
        del self.regions[-1], self._yielding[-1], self._needed[-1]
        self._add_level(bricks, np.concatenate([before, needed]), data, narrow)
        return True

    def _missed_by_coarser(
        self, values: Lanes, depth_at_edges: int, share: float
    ) -> NDArray[np.int64]:
        """(k, 3) bricks beside nodes that the table's coarser cells would miss, there or not.

        Looked at are the finest level's rim and its margin, which the table does without.

        Args:
            values: (n, 4) m, the coarser level's, continued behind surfaces.
            depth_at_edges: from this level on the tube is left out.
            share: of the tolerance, by which a node is missed.
        """
        fine, coarse = self.multigrid.stages[-1], self.multigrid.stages[-2].level
        assert fine.interface is not None
        level, region = fine.level, self.regions[-1]
        margin = level.has_cells & ~self._needed[-1]
        inner = np.flatnonzero(margin[level.site[: level.n_inner] // LOCAL])
        nodes = np.concatenate([fine.interface.nodes, inner])
        nodes = nodes[region[nodes] == 1]
        gap = hanging_values(level, coarse, nodes, values) - fine.u[nodes]
        gap *= self._lane_scale
        nodes = nodes[np.linalg.norm(gap, axis=1) > share * self.marker.tolerance]
        where = level.coordinates(nodes)
        if level.depth > depth_at_edges:
            points = self.problem.frame.to_scene(where / 2.0**level.depth)
            where = where[~self.tube.contains(points)]
        beside = ((where[:, None] + OFFSETS) // 8).reshape(-1, 3)
        return beside[((beside >= 0) & (beside < level.cells // 8)).all(axis=1)]

    def _marked(
        self, data: NDArray[np.float64], lane_scale: NDArray[np.float32], depth_at_edges: int
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """(k, 3) octants of the finest level to split, and those that will be split again."""
        stage = self.multigrid.stages[-1]
        tube = self.tube if stage.level.depth >= depth_at_edges else None
        marked, strong = self.marker.marks(
            stage, self.regions[-1], data, self.multigrid.floor_zero, lane_scale, tube, self.nodes
        )
        return octant_coordinates(stage, marked), octant_coordinates(stage, strong)

    def _add_level(
        self,
        bricks: NDArray[np.int64],
        needed: NDArray[np.int64],
        data: NDArray[np.float64],
        narrow: Stage | None = None,
    ) -> None:
        """A level of the given bricks, of which some are needed for the tolerance itself.

        `narrow` is the level with fewer bricks that it replaces.
        """
        level = self.multigrid.refine(bricks).level
        is_needed = np.zeros(len(level.bricks), bool)
        there = level.index_of(needed)
        is_needed[there[there >= 0]] = True
        self._needed.append(is_needed & level.has_cells)
        self._start(len(self.multigrid.stages) - 1, data, narrow)

    def _find_thin_parts(self) -> None:
        self.tube = self.tube.with_thin_parts(
            self.multigrid.stages[-1], self.regions[-1], self.problem.frame
        )

    def _error_outside_tube(self) -> float:
        """m: the greatest estimated discretisation error farther than the radius from edges."""
        grid, errors = self.multigrid, self._errors
        if len(errors) < len(grid.stages):
            errors = discretisation_error(grid, self._lane_scale)
        # what a level would miss where a finer one stands in for it is missed by nobody
        seen = [np.where(grid.covered(i), 0.0, error) for i, error in enumerate(errors)]
        least = 0.5 * self.tolerance
        return self.tube.greatest_outside(
            self.problem.frame, grid.stages, self.regions, seen, least
        )

    def _depth_of(self, spacing: float) -> int:
        """The first level with cells no larger than `spacing` (m)."""
        if spacing <= 0.0:
            return 12
        return max(0, int(np.ceil(np.log2(self.problem.frame.spacing.max() / spacing) - 1e-9)))

    def _share_done(self) -> float:
        depth = self.multigrid.stages[-1].level.depth
        planned = self._depth_of(self.edge_radius / CELLS_ACROSS_TUBE)
        return min(0.9, 0.9 * 4.0 ** (depth - planned))
