"""The part of the solver's grid that the table keeps.

The solver widens a level so that the next one has coarse nodes all around it. Where the next one
did not come to need them, the table does without these bricks: the coarser level is exact enough
there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.solve.level import LOCAL, node_at, node_kinds
from touchwarp.solve.multigrid import Stage
from touchwarp.solve.refine import octant_coordinates, widened
from touchwarp.solve.region import Region
from touchwarp.solve.solution import Solution
from touchwarp.solve.threads import share

RIM = 3
"""Kind of the nodes that are not surrounded by cells; see `node_kinds`."""


@dataclass(frozen=True, eq=False)
class TableGrid:
    """Which bricks of each level the table keeps.

    Attributes:
        stages: the levels from the root to the finest that has any.
        keep: for each, (b,) bool.
        leaf: for each, (b, 8) bool: octants of kept bricks that no kept finer brick covers.
        rim: for each, (k,) nodes that hang on the coarser level; none on the root.
        own: for each, (k,) int32, sorted, the nodes in Ω of its leaf octants, those on their faces
            included: the table takes their values.
    """

    stages: list[Stage]
    keep: list[NDArray[np.bool_]]
    leaf: list[NDArray[np.bool_]]
    rim: list[NDArray[np.int64]]
    own: list[NDArray[np.int32]]

    @classmethod
    def of(cls, solution: Solution) -> TableGrid:
        """Keep what was needed, and what surrounds kept finer bricks."""
        stages = solution.stages
        keep = [needed.copy() for needed in solution.needed]
        leaf = []
        for i in range(len(stages) - 1, -1, -1):
            covered = np.zeros((len(stages[i].level.bricks), 8), bool)
            if i + 1 < len(stages):
                finer = stages[i + 1].level
                children = np.flatnonzero(keep[i + 1])
                octant = (finer.bricks[children] & 1) @ np.array([4, 2, 1])
                covered[finer.parent[children], octant] = True
                around = widened(stages[i], octant_coordinates(stages[i], covered), 1)
                there = stages[i].level.index_of(around // 2)
                keep[i][there[there >= 0]] = True
                keep[i] &= stages[i].level.has_cells
            leaf.append(keep[i][:, None] & ~covered)
        leaf.reverse()
        rim = [np.empty(0, np.int64)]
        for stage, kept in zip(stages[1:], keep[1:], strict=True):
            level = stage.level
            bricks, local = np.nonzero(node_kinds(level, kept) == RIM)
            nodes = level.node[bricks, local].astype(np.int64)
            where = level.coordinates(nodes)
            on_box = (where == 0) | (where == level.cells)
            if level.mirrored:
                on_box[:, 2] &= where[:, 2] != 0
            rim.append(np.sort(nodes[~on_box.any(axis=1)]))
        own = [
            _nodes_of(stage, leaves, region)
            for stage, leaves, region in zip(stages, leaf, solution.regions, strict=True)
        ]
        return cls(stages, keep, leaf, rim, own)


def _nodes_of(stage: Stage, octants: NDArray[np.bool_], region: Region) -> NDArray[np.int32]:
    """The nodes in Ω of octants (b, 8), those on their faces included."""
    level = stage.level
    marks = np.zeros(level.n, np.bool_)
    share(_mark_nodes, len(octants), level.places, octants, marks, work=LOCAL)
    return np.flatnonzero(marks & (region == 1)).astype(np.int32)


@njit(cache=True, nogil=True)
def _mark_nodes(first, last, places, octants, marks):
    node, around = places.node, places.around
    for b in range(first, last):
        for octant in range(8):
            if octants[b, octant]:
                x0, y0, z0 = 4 * (octant >> 2), 4 * (octant >> 1 & 1), 4 * (octant & 1)
                for i in range(125):
                    marks[node_at(node, around, b, x0 + i // 25, y0 + i // 5 % 5, z0 + i % 5)] = (
                        True
                    )
