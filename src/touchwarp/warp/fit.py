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
from touchwarp.solve.level import node_at, octant_start
from touchwarp.solve.multigrid import Lanes
from touchwarp.solve.region import Region
from touchwarp.solve.samples import Samples
from touchwarp.solve.stencil import LANES
from touchwarp.solve.threads import share
from touchwarp.solve.tube import Tube
from touchwarp.warp.fit_system import MASTERS, FitSystem, make_system
from touchwarp.warp.table_grid import TableGrid

TIE_BEHIND = 1e-3
TIE_IN_TUBE = 0.01
"""κ, in units of one cell face of surface: a misfit that only such nodes can mend is left to about
κ."""


@dataclass(eq=False)
class Fit:
    """The fit's operator for one grid, ready for any g.

    Attributes:
        samples: for each stage.
        starts: for each stage, (c + 1,) first sample of each cell with samples.
        corners: for each stage, (c, 8) int32 nodes at the corners (4x + 2y + z) of these cells; -1
            where u is fixed.
        unknowns: for each stage, (c, 8) int32 their numbers among the unknowns, or -1.
        free: for each stage, the nodes that are unknowns, in order of their numbers.
        system: the normal equations.
    """

    samples: list[Samples]
    starts: list[NDArray[np.int64]]
    corners: list[NDArray[np.int32]]
    unknowns: list[NDArray[np.int32]]
    free: list[NDArray[np.int32]]
    system: FitSystem

    def apply(
        self, values: list[Lanes], goals: list[Lanes], normal_lanes: NDArray[np.bool_]
    ) -> None:
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
            cells = self.starts[i], self.corners[i], self.unknowns[i]
            _add_rhs(*cells, sample.place, sample.weight, goals[i], values[i], rhs)
        change = self.system.solve(rhs, normal_lanes)
        first = 0
        for nodes, v in zip(self.free, values, strict=True):
            v[nodes] += change[first : first + len(nodes)]
            first += len(nodes)


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
    starts, corners = [], []
    for stage, sample in zip(stages, samples, strict=True):
        first = np.flatnonzero(np.diff(sample.cell, prepend=-1))
        starts.append(np.append(first, len(sample.cell)).astype(np.int64))
        corners.append(_cell_corners(sample.cell[first], stage.level.places))
    wanted = [np.zeros(stage.level.n, bool) for stage in stages]
    for marks, nodes in zip(wanted, corners, strict=True):
        marks[nodes[nodes >= 0]] = True
    rims: list[NDArray[np.int64]] = [np.empty(0, np.int64)]
    masters: list[NDArray[np.int32]] = [np.empty((0, MASTERS), np.int32)]
    for i in range(len(stages) - 1, 0, -1):
        rim = grid.rim[i][wanted[i][grid.rim[i]]]
        found = np.full((len(rim), MASTERS), -1, np.int32)
        _masters(rim, stages[i].level.places, stages[i - 1].level.places, found)
        rims.insert(1, rim)
        masters.insert(1, found)
        wanted[i - 1][found[found >= 0]] = True
    free, unknowns, behind, floors, hanging, mastering = [], [], [], [], [], []
    count, coarser = 0, np.empty(0, np.int32)
    for i, stage in enumerate(stages):
        level = stage.level
        hangs = np.zeros(level.n, bool)
        hangs[grid.rim[i]] = True
        wanted[i][level.n_inner :] &= hangs[level.n_inner :]
        nodes = np.flatnonzero(wanted[i]).astype(np.int32)
        taken = (regions[i][nodes] != 1) | hangs[nodes]
        scale = 2.0**level.depth
        where = frame.to_scene(level.coordinates(nodes[~taken]) / scale)
        # what a node carries along ends a cell farther, which has to be in the tube too
        taken[~taken] = tube.contains(where, float(frame.spacing.max()) / scale)
        nodes = nodes[taken]
        number = np.full(level.n, -1, np.int32)
        number[nodes] = count + np.arange(len(nodes), dtype=np.int32)
        count += len(nodes)
        free.append(nodes)
        unknowns.append(np.where(corners[i] >= 0, number[corners[i]], -1).astype(np.int32))
        behind.append(regions[i][nodes] != 1)
        floors.append(np.isin(nodes, stage.floor))
        hanging.append(number[rims[i]])
        mastering.append(
            np.where(masters[i] >= 0, coarser[masters[i]], -1).astype(np.int32) if i else masters[i]
        )
        coarser = number
    ends = np.cumsum([len(first) - 1 for first in starts])
    gram = np.zeros((int(ends[-1]), 8, 8), np.float32)
    for own, first, sample in zip(np.split(gram, ends[:-1]), starts, samples, strict=True):
        share(_add_gram, len(own), first, sample.place, sample.weight, own, work=64)
    is_behind = np.concatenate(behind)
    system = make_system(
        count,
        np.concatenate(unknowns),
        gram,
        np.where(is_behind, TIE_BEHIND, TIE_IN_TUBE),
        is_behind,
        np.flatnonzero(np.concatenate(floors)).astype(np.int32),
        np.concatenate(hanging),
        np.concatenate(mastering),
        np.concatenate([1.0 / (m >= 0).sum(axis=1) for m in masters]),
    )
    return Fit(samples, starts, corners, unknowns, free, system)


@njit(cache=True, nogil=True)
def _cell_corners(cell, places):
    node, around = places.node, places.around
    result = np.empty((len(cell), 8), np.int32)
    for i in range(len(cell)):
        b, local = np.int64(cell[i] >> 9), cell[i] & 511
        x, y, z = local >> 6, (local >> 3) & 7, local & 7
        for c in range(8):
            result[i, c] = node_at(node, around, b, x + (c >> 2), y + (c >> 1 & 1), z + (c & 1))
    return result


@njit(cache=True, nogil=True)
def _masters(rim, fine, coarse, masters):
    """The coarser level's nodes that a hanging node is the mean of: one, two or four."""
    bricks, parent, site = fine.bricks, fine.parent, fine.site
    node, around = coarse.node, coarse.around
    for i in range(len(rim)):
        b, local = site[rim[i]] >> 9, site[rim[i]] & 511
        x, y, z = local >> 6, (local >> 3) & 7, local & 7
        start, p = octant_start(bricks, b), np.int64(parent[b])
        x0, y0, z0 = (start >> 6) + (x >> 1), ((start >> 3) & 7) + (y >> 1), (start & 7) + (z >> 1)
        k = 0
        for dx in range(1 + (x & 1)):
            for dy in range(1 + (y & 1)):
                for dz in range(1 + (z & 1)):
                    masters[i, k] = node_at(node, around, p, x0 + dx, y0 + dy, z0 + dz)
                    k += 1


@njit(cache=True, nogil=True)
def _shape(place, s, n):
    for c in range(8):
        n[c] = (
            (place[s, 0] if c >> 2 else 1.0 - place[s, 0])
            * (place[s, 1] if c >> 1 & 1 else 1.0 - place[s, 1])
            * (place[s, 2] if c & 1 else 1.0 - place[s, 2])
        )


@njit(cache=True, nogil=True)
def _add_gram(first, last, start, place, weight, gram):
    """Add Σ w N Nᵀ over the samples of cells first..last to their matrices."""
    n = np.empty(8)
    for c in range(first, last):
        for s in range(start[c], start[c + 1]):
            _shape(place, s, n)
            for i in range(8):
                for j in range(8):
                    gram[c, i, j] += weight[s] * n[i] * n[j]


@njit(cache=True, nogil=True, fastmath=True)
def _add_rhs(start, corners, unknowns, place, weight, goal, values, rhs):
    n = np.empty(8)
    known, total = np.empty((8, LANES)), np.empty((8, LANES))
    for c in range(len(start) - 1):
        for i in range(8):
            m = corners[c, i]
            for q in range(LANES):
                known[i, q] = values[m, q] if m >= 0 else np.float32(0.0)
                total[i, q] = 0.0
        for s in range(start[c], start[c + 1]):
            _shape(place, s, n)
            for q in range(LANES):
                gap = np.float64(goal[s, q])
                for i in range(8):
                    gap -= n[i] * known[i, q]
                gap *= weight[s]
                for i in range(8):
                    total[i, q] += n[i] * gap
        for i in range(8):
            if unknowns[c, i] >= 0:
                for q in range(LANES):
                    rhs[unknowns[c, i], q] += total[i, q]
