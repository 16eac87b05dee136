"""The contact fit: node values in cells that a surface crosses, so that the table equals g there.

Minimises, for each lane, Σ w |table(s) - g(s)|² over the surface's samples + Σ κ |x - x₀|² over the
nodes of the cells they lie in. x₀ is the solution in Ω, and behind surfaces its continuation
(`ghosts`). Nodes behind surfaces are fitted first, alone; then, for what is left, nodes in Ω too,
but only in the tube around sharp edges, open sheets and thin walls, where nodes behind do not
suffice. Everywhere else nodes in Ω keep the solution. Hanging nodes follow their masters. The whole
is one linear operator, whatever g is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.solve.frame import Frame
from touchwarp.solve.level import node_at
from touchwarp.solve.region import Region
from touchwarp.solve.samples import Samples
from touchwarp.solve.stencil import LANES
from touchwarp.solve.tube import Tube
from touchwarp.warp.fit_system import FitSystem, make_system
from touchwarp.warp.table_grid import TableGrid

TIE_BEHIND = 1e-3
TIE_IN_TUBE = 0.01
"""κ, in units of one cell face of surface: a misfit that only such nodes can mend is left to about
κ."""

Real = NDArray[np.float64]


@dataclass(eq=False)
class Fit:
    """The fit's operator for one grid, ready for any g.

    Attributes:
        samples: for each stage.
        cells: for each stage, (c, 8) int64 nodes at the corners (4x + 2y + z) of cells with
            samples; -1 where u is fixed.
        starts: for each stage, (c + 1,) first sample of each cell.
        numbers: for each stage, (n,) int32: number of each node among the unknowns, or -1.
        system: the normal equations.
    """

    samples: list[Samples]
    cells: list[NDArray[np.int64]]
    starts: list[NDArray[np.int64]]
    numbers: list[NDArray[np.int32]]
    system: FitSystem

    def apply(self, values: list[Real], goals: list[Real], normal_lanes: NDArray[np.bool_]) -> None:
        """Adjust node values to meet g, in place.

        Args:
            values: for each stage, (n, 4) m: the first guess x₀, hanging nodes included.
            goals: for each stage, (s, 4) m: g at its samples.
            normal_lanes: (4,) lanes that stay 0 on the sliding plane.

        Raises:
            SolveError: no convergence.
        """
        rhs = np.zeros((self.system.count, LANES))
        for i, sample in enumerate(self.samples):
            _add_rhs(
                self.starts[i],
                sample.place,
                sample.weight,
                goals[i],
                self.cells[i],
                self.numbers[i],
                values[i],
                rhs,
            )
        change = self.system.solve(rhs, normal_lanes)
        for numbers, v in zip(self.numbers, values, strict=True):
            nodes = np.flatnonzero(numbers >= 0)
            v[nodes] += change[numbers[nodes]]

    def residuals(
        self, values: list[Real], goals: list[Real], lane_scale: NDArray[np.float32]
    ) -> list[Real]:
        """For each stage, (s,) m: |table - g| at its samples, lanes weighted by (4,) to metres."""
        result = []
        for i, sample in enumerate(self.samples):
            size = np.empty(len(sample.cell))
            _residuals(
                self.starts[i],
                sample.place,
                goals[i],
                self.cells[i],
                values[i],
                lane_scale.astype(np.float64),
                size,
            )
            result.append(size)
        return result


def make_fit(
    grid: TableGrid, regions: list[Region], samples: list[Samples], frame: Frame, tube: Tube
) -> Fit:
    """Number the unknowns and add up each cell's samples.

    Args:
        grid: the table's bricks; regions, samples: for each of its levels.
        frame: where the grid lies.
        tube: where nodes in Ω may give way to contact.
    """
    stages = grid.stages
    starts, cells = [], []
    for stage, sample in zip(stages, samples, strict=True):
        first = np.flatnonzero(np.diff(sample.cell, prepend=-1))
        starts.append(np.append(first, len(sample.cell)).astype(np.int64))
        cells.append(_cell_corners(sample.cell[first], stage.level.node, stage.level.around))
    wanted = [np.unique(c[c >= 0]) for c in cells]
    links: list[tuple[int, NDArray[np.int64], NDArray[np.int64]]] = []
    for i in range(len(stages) - 1, 0, -1):
        level, over = stages[i].level, stages[i - 1].level
        rim = np.intersect1d(wanted[i], grid.rim[i], assume_unique=True)
        masters = np.full((len(rim), 4), -1, np.int64)
        _masters(rim, level.site, level.bricks, level.parent, over.node, over.around, masters)
        links.append((i, rim, masters))
        wanted[i - 1] = np.union1d(wanted[i - 1], masters[masters >= 0])
    numbers, behind, floors, ties = [], [], [], []
    count = 0
    for i, stage in enumerate(stages):
        level = stage.level
        free = np.zeros(level.n, bool)
        free[: level.n_inner] = True
        free[grid.rim[i]] = True
        nodes = wanted[i][free[wanted[i]]]
        hangs = np.zeros(level.n, bool)
        hangs[grid.rim[i]] = True
        where = frame.to_scene(level.coordinates(nodes) / 2.0**level.depth)
        nodes = nodes[(regions[i][nodes] != 1) | hangs[nodes] | tube.contains(where)]
        number = np.full(level.n, -1, np.int32)
        number[nodes] = count + np.arange(len(nodes), dtype=np.int32)
        numbers.append(number)
        count += len(nodes)
        behind.append(regions[i][nodes] != 1)
        ties.append(np.where(behind[-1], TIE_BEHIND, TIE_IN_TUBE))
        on_floor = np.zeros(level.n, bool)
        on_floor[stage.floor] = True
        floors.append(on_floor[nodes])
    hanging = np.concatenate([numbers[i][rim] for i, rim, _ in links] or [np.empty(0, np.int32)])
    master = np.concatenate(
        [np.where(m >= 0, numbers[i - 1][m], -1) for i, _, m in links]
        or [np.empty((0, 4), np.int32)]
    )
    share = np.concatenate([1.0 / (m >= 0).sum(axis=1) for _, _, m in links] or [np.empty(0)])
    unknowns, grams = [], []
    for i, sample in enumerate(samples):
        corner = np.where(cells[i] >= 0, numbers[i][cells[i]], -1).astype(np.int32)
        gram = np.zeros((len(corner), 8, 8))
        _add_gram(starts[i], sample.place, sample.weight, gram)
        unknowns.append(corner)
        grams.append(gram)
    system = make_system(
        count,
        np.concatenate(unknowns),
        np.concatenate(grams),
        np.concatenate(ties),
        np.concatenate(behind),
        np.concatenate(floors),
        hanging.astype(np.int32),
        master.astype(np.int32),
        share,
    )
    return Fit(samples, cells, starts, numbers, system)


@njit(cache=True)
def _cell_corners(cell, node, around):
    result = np.full((len(cell), 8), -1, np.int64)
    for i in range(len(cell)):
        b, local = cell[i] // 512, cell[i] % 512
        x, y, z = local // 64, local // 8 % 8, local % 8
        for c in range(8):
            result[i, c] = node_at(
                node, around, False, b, x + (c >> 2), y + (c >> 1 & 1), z + (c & 1)
            )
    return result


@njit(cache=True)
def _masters(rim, site, bricks, parent, coarse_node, coarse_around, masters):
    for i in range(len(rim)):
        b = site[rim[i]] // 512
        local = site[rim[i]] % 512
        x, y, z = local // 64, local // 8 % 8, local % 8
        k = 0
        for dx in range(1 + (x & 1)):
            for dy in range(1 + (y & 1)):
                for dz in range(1 + (z & 1)):
                    masters[i, k] = node_at(
                        coarse_node,
                        coarse_around,
                        False,
                        parent[b],
                        4 * (bricks[b, 0] & 1) + x // 2 + dx,
                        4 * (bricks[b, 1] & 1) + y // 2 + dy,
                        4 * (bricks[b, 2] & 1) + z // 2 + dz,
                    )
                    k += 1


@njit(cache=True)
def _shape(place, n):
    for c in range(8):
        n[c] = (
            (place[0] if c >> 2 else 1.0 - place[0])
            * (place[1] if c >> 1 & 1 else 1.0 - place[1])
            * (place[2] if c & 1 else 1.0 - place[2])
        )


@njit(cache=True)
def _add_gram(start, place, weight, gram):
    n = np.empty(8)
    for c in range(gram.shape[0]):
        for s in range(start[c], start[c + 1]):
            _shape(place[s], n)
            for i in range(8):
                for j in range(8):
                    gram[c, i, j] += weight[s] * n[i] * n[j]


@njit(cache=True)
def _add_rhs(start, place, weight, goal, cells, numbers, values, rhs):
    n = np.empty(8)
    for c in range(len(start) - 1):
        for s in range(start[c], start[c + 1]):
            _shape(place[s], n)
            for q in range(LANES):
                gap = goal[s, q]
                for i in range(8):
                    if cells[c, i] >= 0:
                        gap -= n[i] * values[cells[c, i], q]
                for i in range(8):
                    if cells[c, i] >= 0 and numbers[cells[c, i]] >= 0:
                        rhs[numbers[cells[c, i]], q] += weight[s] * n[i] * gap


@njit(cache=True)
def _residuals(start, place, goal, cells, values, lane_scale, size):
    n = np.empty(8)
    for c in range(len(start) - 1):
        for s in range(start[c], start[c + 1]):
            _shape(place[s], n)
            square = 0.0
            for q in range(LANES):
                gap = goal[s, q]
                for i in range(8):
                    if cells[c, i] >= 0:
                        gap -= n[i] * values[cells[c, i], q]
                square += (lane_scale[q] * gap) ** 2
            size[s] = np.sqrt(square)
