"""FAS multigrid on nested levels: V-cycles, and the change they make.

Each refined level covers part of the coarser one; where it does, the coarse equation is replaced by
the full approximation scheme's, so that all levels together solve one composite problem.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from touchwarp.solve import interface, stencil, transfer
from touchwarp.solve.blend import Blend, Terms
from touchwarp.solve.boundary import Boundary
from touchwarp.solve.cuts import BrickTriangles, Cuts, cut_edges, sieve_triangles
from touchwarp.solve.frame import CELLS, Frame
from touchwarp.solve.interface import Interface, make_interface
from touchwarp.solve.level import Level, make_level
from touchwarp.solve.stencil import LANES, Stencils, make_stencils
from touchwarp.solve.threads import share

Lanes = NDArray[np.float32]

SWEEPS = 2
"""Red–black sweeps before and after each coarse correction."""

COARSEST_SWEEPS = 12


@dataclass(eq=False)
class Stage:
    """A level with its geometry, its equation and its unknowns.

    Attributes:
        covered: inner nodes (fine, coarse) that coincide with the coarser level's inner nodes.
        interface: how the rim follows from the coarser level; None where it lies on the outer box.
        floor: nodes on the sliding plane.
        u, f, r, before: (n, 4) float32, unknowns in m, right-hand side, residual, and the values
            that the finer level's correction is counted from.
        boundary: (k, 4) g's part of each cut row; `cut_values`: (c, 4) g at each cut.
        rim_constant: (rim, 4) g's part of the rim values.
    """

    level: Level
    triangles: BrickTriangles
    cuts: Cuts
    stencils: Stencils
    covered: tuple[NDArray[np.int32], NDArray[np.int32]]
    interface: Interface | None
    floor: NDArray[np.int32]
    u: Lanes
    f: Lanes
    r: Lanes
    before: Lanes
    boundary: Lanes = field(default_factory=lambda: np.empty((0, LANES), np.float32))
    cut_values: Lanes = field(default_factory=lambda: np.empty((0, LANES), np.float32))
    rim_constant: Lanes = field(default_factory=lambda: np.empty((0, LANES), np.float32))


class Multigrid:
    """The levels of one scene, from the coarsest to the finest, and cycles over them."""

    def __init__(self, frame: Frame, boundary: Boundary, screening: float) -> None:
        """Build the root level and its coarsenings; `screening` is λ in m⁻²."""
        self.frame = frame
        self.boundary = boundary
        self.screening = screening
        self.stages: list[Stage] = []
        self.floor_zero = np.zeros(LANES, np.bool_)
        halvings = 0
        while (frame.root_cells % 2 ** (halvings + 1) == 0).all() and (
            frame.root_cells >> (halvings + 1) >= 2
        ).all():
            halvings += 1
        for depth in range(-halvings, 1):
            cells = frame.root_cells >> -depth
            blocks = [np.arange(-(-c // 8)) for c in cells]
            bricks = np.stack(np.meshgrid(*blocks, indexing="ij"), axis=-1).reshape(-1, 3)
            self.stages.append(self._make_stage(depth, cells, bricks))
        self.root = halvings

    def refine(self, bricks: NDArray[np.int64]) -> Stage:
        """Add a level with the given bricks (b, 3); it starts with u = 0."""
        depth = self.stages[-1].level.depth + 1
        self.stages.append(self._make_stage(depth, self.frame.root_cells << depth, bricks))
        return self.stages[-1]

    def drop_finest(self) -> Stage:
        """Take the finest level away."""
        return self.stages.pop()

    def _make_stage(self, depth: int, cells: NDArray[np.int64], bricks: NDArray[np.int64]) -> Stage:
        coarser = self.stages[-1] if self.stages else None
        share(CELLS**3 * len(bricks))
        level = make_level(
            depth, cells, bricks, coarser.level if coarser else None, mirrored=self.frame.mirrored
        )
        corners, faces = self.boundary.corners, self.boundary.faces
        triangles = sieve_triangles(level, corners, faces, coarser.triangles if coarser else None)
        cuts = cut_edges(level, corners, faces, triangles)
        stencils = make_stencils(cuts, self.frame.spacing, self.screening, depth)
        empty = np.empty(0, np.int32)
        covered, link = (empty, empty), None
        if coarser is not None:
            covered = transfer.covered_pairs(
                level.bricks,
                level.parent,
                level.node,
                level.n_inner,
                coarser.level.node,
                coarser.level.n_inner,
            )
            if depth > 0:
                link = make_interface(level, cuts, coarser.level, coarser.cuts)
        floor = empty
        if level.mirrored:
            on_floor = (level.bricks[level.site // 512, 2] == 0) & (level.site % 8 == 0)
            floor = np.flatnonzero(on_floor).astype(np.int32)
        u, f, r, before = (np.zeros((level.n, LANES), np.float32) for _ in range(4))
        return Stage(level, triangles, cuts, stencils, covered, link, floor, u, f, r, before)

    def set_screening(self, screening: float) -> None:
        """Change λ (m⁻²) and keep everything else."""
        self.screening = screening
        for stage in self.stages:
            stage.stencils = make_stencils(
                stage.cuts, self.frame.spacing, screening, stage.level.depth
            )

    def set_stage_goal(
        self,
        i: int,
        data: NDArray[np.float64],
        blend: Blend | None = None,
        terms: list[Terms] | None = None,
    ) -> None:
        """Boundary values on one level.

        Args:
            i: the level, counted from the coarsest; coarser ones must have theirs.
            data: (v, 4) g's lanes at the boundary's corners.
            blend, terms: what gives way to fixed surfaces.
        """
        stage, cuts = self.stages[i], self.stages[i].cuts
        stage.cut_values = np.empty((len(cuts.distance), LANES), np.float32)
        stencil.values_at_cuts(
            cuts.triangle, cuts.weights, self.boundary.faces, data, stage.cut_values
        )
        if blend is not None and terms:
            blend.apply(stage.cut_values, terms, data, self.floor_zero)
        stage.boundary = np.empty((len(cuts.node), LANES), np.float32)
        stencil.gather_boundary(
            cuts.start, stage.stencils.cut_weight, stage.cut_values, stage.boundary
        )
        link = stage.interface
        if link is not None:
            stage.rim_constant = np.empty((len(link.rim), LANES), np.float32)
            interface.interface_constants(
                link.start,
                link.length,
                link.source,
                link.weight,
                self.stages[i - 1].cut_values,
                link.fine_start,
                link.fine_length,
                link.fine_cut,
                link.fine_weight,
                stage.cut_values,
                stage.rim_constant,
            )

    def start_from_coarser(self, i: int) -> None:
        """Full multigrid start: level i takes the coarser level's values, by cubic
        interpolation."""
        fine, coarse = self.stages[i], self.stages[i - 1]
        share(fine.level.n)
        sign = np.where(self.floor_zero, -1.0, 1.0).astype(np.float32)
        transfer.prolong_cubic(
            fine.u,
            coarse.u,
            fine.level.bricks,
            fine.level.parent,
            fine.level.node,
            fine.level.n_inner,
            coarse.level.node,
            coarse.level.around,
            coarse.level.bricks,
            fine.level.mirrored,
            sign,
        )
        self._set_rim(i)

    def take_values(self, i: int, narrow: Stage) -> None:
        """Level i takes the inner values of a stage of the same depth with fewer bricks."""
        stage = self.stages[i]
        there = stage.level.index_of(narrow.level.bricks.astype(np.int64))
        old, new = narrow.level.node, stage.level.node[there]
        both = (there[:, None] >= 0) & (old >= 0) & (old < narrow.level.n_inner)
        stage.u[new[both]] = narrow.u[old[both]]

    def cycle(self, i: int | None = None) -> None:
        """One V-cycle from level i (the finest without it) down and back."""
        i = len(self.stages) - 1 if i is None else i
        if i == 0:
            self.smooth(0, COARSEST_SWEEPS)
            return
        self.smooth(i, SWEEPS)
        self.coarsen_equation(i)
        self.cycle(i - 1)
        self.correct(i)
        self.smooth(i, SWEEPS)

    def smooth(self, i: int, sweeps: int) -> None:
        """Red–black Gauss–Seidel on one level."""
        stage = self.stages[i]
        level, rows = stage.level, stage.stencils
        share(level.n)
        arguments = (
            stage.u,
            stage.f,
            level.neighbours,
            stage.cuts.row,
            rows.rows,
            stage.boundary,
            rows.axis_weights,
            rows.screening,
        )
        for _ in range(sweeps):
            for first, last in ((0, level.n_red), (level.n_red, level.n_inner)):
                stencil.sweep(*arguments, first, last)
                self._hold_floor(stage, stage.u)

    def residual(self, i: int) -> Lanes:
        """Compute a level's residual, (n, 4) m (rows scaled by h²)."""
        stage = self.stages[i]
        level, rows = stage.level, stage.stencils
        share(level.n)
        stencil.residual(
            stage.u,
            stage.f,
            level.neighbours,
            stage.cuts.row,
            rows.rows,
            stage.boundary,
            rows.axis_weights,
            rows.screening,
            stage.r,
        )
        self._hold_floor(stage, stage.r)
        return stage.r

    def coarsen_equation(self, i: int) -> None:
        """Give the coarser level its FAS equation from level i."""
        fine, coarse = self.stages[i], self.stages[i - 1]
        self.residual(i)
        under, over = fine.covered
        transfer.inject(fine.u, coarse.u, coarse.before, under, over)
        share(fine.level.n)
        level, rows = fine.level, coarse.stencils
        transfer.restrict_equation(
            fine.r,
            under,
            over,
            level.site,
            level.node,
            level.around,
            level.bricks,
            level.mirrored,
            level.n_inner,
            coarse.u,
            coarse.level.neighbours,
            coarse.cuts.row,
            rows.rows,
            coarse.boundary,
            rows.axis_weights,
            rows.screening,
            self.floor_zero,
            coarse.f,
        )

    def correct(self, i: int) -> None:
        """Add the coarser level's change to level i."""
        fine, coarse = self.stages[i], self.stages[i - 1]
        share(fine.level.n)
        transfer.prolong_correction(
            fine.u,
            coarse.u,
            coarse.before,
            fine.level.bricks,
            fine.level.parent,
            fine.level.node,
            fine.level.n_inner,
            coarse.level.node,
            coarse.level.around,
            coarse.level.bricks,
            fine.level.mirrored,
        )
        self._set_rim(i)

    def _set_rim(self, i: int) -> None:
        stage = self.stages[i]
        link = stage.interface
        if link is not None:
            interface.set_rim(
                stage.u,
                self.stages[i - 1].u,
                link.rim,
                link.start,
                link.length,
                link.source,
                link.weight,
                stage.rim_constant,
            )
            self._hold_floor(stage, stage.u)

    def _hold_floor(self, stage: Stage, values: Lanes) -> None:
        if len(stage.floor) and self.floor_zero.any():
            stencil.hold_floor(values, stage.floor, self.floor_zero)
