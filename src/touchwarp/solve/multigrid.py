"""FAS multigrid on nested levels: V-cycles, and the change they make.

Each refined level covers part of the coarser one; where it does, the coarse equation is replaced by
the full approximation scheme's, so that all levels together solve one composite problem.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.solve import interface, stencil, transfer
from touchwarp.solve.blend import Yielding
from touchwarp.solve.boundary import Boundary
from touchwarp.solve.cuts import BrickTriangles, Cuts, cut_edges, sieve_triangles
from touchwarp.solve.frame import CELLS, Frame
from touchwarp.solve.interface import Interface, make_interface
from touchwarp.solve.level import LOCAL, Level, make_level
from touchwarp.solve.stencil import LANES, Equation, Stencils, make_stencils
from touchwarp.solve.threads import share

Lanes = NDArray[np.float32]

SWEEPS = 2
"""Red–black sweeps before and after each coarse correction."""

COARSEST_SWEEPS = 12

_NO_LANES = np.empty((0, LANES), np.float32)


@dataclass(eq=False)
class Stage:
    """A level with its geometry, its equation and its unknowns.

    Attributes:
        interface: how the rim follows from the coarser level; None where it lies on the outer box.
        floor: nodes on the sliding plane.
        u: (n, 4) float32, unknowns in m.
        slot, source: the right-hand side f, for the bricks where it is not 0; see `Equation`.
        boundary: (k, 4) g's part of each cut row; `cut_values`: (c, 4) g at each cut.
        rim_constant: (rim, 4) g's part of the rim values beside surfaces.
    """

    level: Level
    triangles: BrickTriangles
    cuts: Cuts
    stencils: Stencils
    interface: Interface | None
    floor: NDArray[np.int32]
    u: Lanes
    slot: NDArray[np.int32]
    source: Lanes = field(default_factory=lambda: _NO_LANES)
    boundary: Lanes = field(default_factory=lambda: _NO_LANES)
    cut_values: Lanes = field(default_factory=lambda: _NO_LANES)
    rim_constant: Lanes = field(default_factory=lambda: _NO_LANES)

    @property
    def equation(self) -> Equation:
        """The level's equation for compiled loops."""
        rows = self.stencils
        return Equation(
            self.cuts.row,
            rows.rows,
            rows.axis_weights,
            rows.screening,
            self.boundary,
            self.slot,
            self.source,
        )

    def set_covered(self, bricks: NDArray[np.bool_]) -> None:
        """Say which bricks (b,) a finer level covers, in part or wholly; f is 0 until it tells."""
        self.slot = np.where(bricks, np.cumsum(bricks) - 1, -1).astype(np.int32)
        self.source = np.zeros((LOCAL * int(bricks.sum()), LANES), np.float32)


class Multigrid:
    """The levels of one scene, from the coarsest to the finest, and cycles over them."""

    def __init__(self, frame: Frame, boundary: Boundary, screening: float) -> None:
        """Build the root level and its coarsenings; `screening` is λ in m⁻²."""
        self.frame = frame
        self.boundary = boundary
        self.screening = screening
        self.stages: list[Stage] = []
        self.floor_zero = np.zeros(LANES, np.bool_)
        self._scratch = _NO_LANES
        halvings = 0
        while (frame.root_cells % 2 ** (halvings + 1) == 0).all() and (
            frame.root_cells >> (halvings + 1) >= 2
        ).all():
            halvings += 1
        for depth in range(-halvings, 1):
            cells = frame.root_cells >> -depth
            blocks = [np.arange(-(-c // 8)) for c in cells]
            bricks = np.stack(np.meshgrid(*blocks, indexing="ij"), axis=-1).reshape(-1, 3)
            self._add_stage(depth, cells, bricks)
        self.root = halvings

    def refine(self, bricks: NDArray[np.int64]) -> Stage:
        """Add a level with the given bricks (b, 3); it starts with u = 0."""
        depth = self.stages[-1].level.depth + 1
        self._add_stage(depth, self.frame.root_cells << depth, bricks)
        return self.stages[-1]

    def drop_from(self, i: int) -> list[Stage]:
        """Take level i and all finer ones away; the one before has its own equation again."""
        dropped = self.stages[i:]
        del self.stages[i:]
        self.stages[-1].set_covered(np.zeros(len(self.stages[-1].level.bricks), bool))
        return dropped

    def _add_stage(self, depth: int, cells: NDArray[np.int64], bricks: NDArray[np.int64]) -> None:
        coarser = self.stages[-1] if self.stages else None
        level = make_level(
            depth, cells, bricks, coarser.level if coarser else None, mirrored=self.frame.mirrored
        )
        corners, faces = self.boundary.corners, self.boundary.faces
        triangles = sieve_triangles(level, corners, faces, coarser.triangles if coarser else None)
        cuts = cut_edges(level, corners, faces, triangles)
        stencils = make_stencils(cuts, self.frame.spacing, self.screening, depth)
        link = None
        if coarser is not None:
            coarser.set_covered(transfer.covered_bricks(level, coarser.level))
            if depth > 0:
                link = make_interface(level, cuts, coarser.level, coarser.cuts)
        floor = np.empty(0, np.int32)
        if level.mirrored:
            on_floor = (level.bricks[level.site // LOCAL, 2] == 0) & (level.site % CELLS == 0)
            floor = np.flatnonzero(on_floor).astype(np.int32)
        u = np.zeros((level.n, LANES), np.float32)
        slot = np.full(len(level.bricks), -1, np.int32)
        self.stages.append(Stage(level, triangles, cuts, stencils, link, floor, u, slot))

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
        yielding: Yielding | None = None,
    ) -> None:
        """Boundary values on one level.

        Args:
            i: the level, counted from the coarsest; coarser ones must have theirs.
            data: (v, 4) g's lanes at the boundary's corners.
            yielding: what gives way at the level's cuts.
        """
        stage, cuts = self.stages[i], self.stages[i].cuts
        stage.cut_values = np.empty((len(cuts.distance), LANES), np.float32)
        stencil.values_at_cuts(cuts, self.boundary.faces, data, stage.cut_values)
        if yielding is not None:
            yielding.apply(stage.cut_values, data, self.floor_zero)
        stage.boundary = np.empty((len(cuts.node), LANES), np.float32)
        stencil.gather_boundary(cuts, stage.stencils.cut_weight, stage.cut_values, stage.boundary)
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
        sign = np.where(self.floor_zero, -1.0, 1.0).astype(np.float32)
        self._between(transfer.prolong_cubic, i, self.stages[i - 1].u, sign, self.stages[i].u)
        self._set_rim(i)

    def take_values(self, i: int, narrow: Stage) -> None:
        """Level i takes the inner values of a stage of the same depth with fewer bricks."""
        stage, old = self.stages[i], narrow.level
        there = stage.level.index_of(old.bricks.astype(np.int64))
        nodes = old.node, old.n_inner, stage.level.node
        share(
            transfer.take_inner, len(there), there, *nodes, narrow.u, stage.u, work=LOCAL, even=True
        )

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
        red, inner = stage.level.n_red, stage.level.n_inner
        given = stage.level.places, stage.equation, self._on_floor, stage.u, _NO_LANES
        for _ in range(sweeps):
            for count, offset in ((red, 0), (inner - red, red)):
                share(stencil.relax, count, offset, *given, even=True)

    def residual(self, i: int) -> Lanes:
        """A level's residual at inner nodes, (n, 4) m (rows scaled by h²), until the next one."""
        stage = self.stages[i]
        result = self._room_for(stage)
        given = stage.level.places, stage.equation, self._on_floor, stage.u, result
        share(stencil.relax, stage.level.n_inner, 0, *given, even=True)
        return result[: stage.level.n_inner]

    def coarsen_equation(self, i: int) -> None:
        """Give the coarser level its FAS equation from level i."""
        fine, coarse = self.stages[i], self.stages[i - 1]
        self._between(transfer.inject, i, fine.u, coarse.u)
        residual = self.residual(i)
        self._between(transfer.restrict_equation, i, residual, coarse.equation, coarse.u)

    def amplify_equation(self, i: int, factor: np.float32) -> None:
        """Multiply what level i has given the coarser one, where i is the finest there is."""
        coarse = self.stages[i - 1]
        self._between(transfer.amplify, i, self.covered(i), coarse.slot, factor, coarse.source)

    def covered(self, i: int) -> NDArray[np.bool_]:
        """(n,) nodes of level i at which a finer level stands in for it."""
        covered = np.zeros(self.stages[i].level.n, bool)
        if i + 1 < len(self.stages):
            self._between(transfer.mark_covered, i + 1, covered)
        return covered

    def correct(self, i: int) -> None:
        """Add the coarser level's change to level i."""
        fine, coarse = self.stages[i], self.stages[i - 1]
        change = self._room_for(coarse)
        self._between(transfer.coarse_change, i, fine.u, coarse.u, change)
        self._between(transfer.prolong_correction, i, change, fine.u)
        self._set_rim(i)

    def release(self) -> None:
        """Give back the memory that only cycles need."""
        self._scratch = _NO_LANES

    def _between(self, kernel: Callable[..., Any], i: int, *arguments: Any) -> None:
        """Run a loop of `transfer` over the bricks of level i."""
        fine, coarse = self.stages[i].level, self.stages[i - 1].level
        given = fine.places, coarse.places, *arguments
        share(kernel, len(fine.bricks), *given, work=LOCAL, even=True)

    @property
    def _on_floor(self) -> NDArray[np.float32]:
        """(4,) 0 for lanes that vanish on the sliding plane, 1 for the others."""
        return np.where(self.floor_zero, 0.0, 1.0).astype(np.float32)

    def _room_for(self, stage: Stage) -> Lanes:
        """(n, 4) that the next call may overwrite; one array serves all levels."""
        if len(self._scratch) < stage.level.n:
            self._scratch = np.empty((stage.level.n, LANES), np.float32)
        return self._scratch[: stage.level.n]

    def _set_rim(self, i: int) -> None:
        stage, coarse = self.stages[i], self.stages[i - 1]
        link = stage.interface
        if link is None:
            return
        places = stage.level.places, coarse.level.places
        share(
            interface.set_plain_rim,
            len(link.plain),
            link.plain,
            *places,
            coarse.u,
            stage.u,
            work=16,
            even=True,
        )
        terms = link.start, link.length, link.source, link.weight, stage.rim_constant
        share(interface.set_rim, len(link.rim), link.rim, *terms, coarse.u, stage.u, work=16)
        self._hold_floor(stage, stage.u)

    def _hold_floor(self, stage: Stage, values: Lanes) -> None:
        if len(stage.floor) and self.floor_zero.any():
            stencil.hold_floor(values, stage.floor, self.floor_zero)
