"""From node values on the solver's levels to the table's bricks."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from touchwarp.solve.frame import Frame
from touchwarp.solve.interface import hanging_values
from touchwarp.solve.level import LOCAL, node_at
from touchwarp.solve.multigrid import Lanes
from touchwarp.solve.threads import share
from touchwarp.warp.bricks import NODES, Bricks
from touchwarp.warp.table_grid import TableGrid


def round_and_hang(grid: TableGrid, fields: list[list[Lanes]]) -> None:
    """Make the table continuous, in place: rim nodes take the coarser level's trilinear value.

    Values are rounded first to a step that leaves two binary places of float32 free, so that means
    of two and of four nodes are stored exactly and no jump remains (at most 15 nm is lost at 6 cm).

    Args:
        grid: the table's bricks.
        fields: for each field and each level, (n, 4) m.
    """
    levels = [v for values in fields for v in values]
    largest = max(float(max(v.max(initial=0.0), -v.min(initial=0.0))) for v in levels)
    step = np.float32(2.0 ** (math.ceil(math.log2(largest)) - 22) if largest > 0.0 else 1.0)
    for values in fields:
        for i, v in enumerate(values):
            # exact, as the step is a power of two
            v /= step
            np.rint(v, out=v)
            v *= step
            hang(grid, i, values)


def hang(grid: TableGrid, i: int, values: list[Lanes]) -> None:
    """Set level i's hanging nodes to the coarser level's trilinear interpolant, in place."""
    if i == 0:
        return
    level, over = grid.stages[i].level, grid.stages[i - 1].level
    values[i][grid.rim[i]] = hanging_values(level, over, grid.rim[i], values[i - 1])


def bricks_of(
    frame: Frame, grid: TableGrid, fields: list[list[Lanes]], lanes: int, depth: float
) -> Bricks:
    """The table of node values that agree on shared faces.

    Args:
        frame: the solver's frame.
        grid: the table's bricks.
        fields: for each field and each level, (n, 4) m, table axes.
        lanes: how many lanes of each field the table takes; they become its channels.
        depth: m, depth of the space under the sliding plane, if the frame is mirrored.
    """
    stages = grid.stages
    cell_bricks = [np.flatnonzero(keep) for keep in grid.keep]
    counts = [len(c) for c in cell_bricks]
    first = np.concatenate([[0], np.cumsum(counts)])
    child = np.full((int(first[-1]), 8), -1, np.int32)
    for i in range(1, len(stages)):
        level, over = stages[i].level, stages[i - 1].level
        rank = np.full(len(over.bricks), -1, np.int64)
        rank[cell_bricks[i - 1]] = np.arange(counts[i - 1])
        fine = cell_bricks[i]
        octant = (level.bricks[fine] & 1) @ np.array([4, 2, 1])
        child[first[i - 1] + rank[level.parent[fine]], octant] = first[i] + np.arange(len(fine))
    stored = np.asarray((child < 0).any(axis=1))
    slot = np.where(stored, np.cumsum(stored) - 1, -1).astype(np.int32)
    channels = len(fields) * lanes
    table = np.zeros((int(stored.sum()), NODES, NODES, NODES, channels), np.float32)
    for i, stage in enumerate(stages):
        keep = stored[first[i] : first[i + 1]]
        level = stage.level
        chosen = cell_bricks[i][keep].astype(np.int32), slot[first[i] : first[i + 1]][keep]
        for k, values in enumerate(fields):
            target = values[i], lanes * k, lanes * (k + 1), table
            share(_gather, len(chosen[0]), *chosen, level.places, *target, work=LOCAL, even=True)
    root = np.full(frame.root_bricks, -1, np.int32)
    where = stages[0].level.bricks[cell_bricks[0]]
    root[tuple(where.T)] = np.arange(counts[0])
    return Bricks(
        frame.T_scene_table,
        frame.spacing,
        root,
        child,
        slot,
        table,
        depth if frame.mirrored else None,
    )


@njit(cache=True, nogil=True)
def _gather(first, last, bricks, slots, places, values, channel, end, table):
    """Copy lanes of node values to the channels channel..end of the table's rows."""
    node, around = places.node, places.around
    for i in range(first, last):
        brick, row = np.int64(bricks[i]), slots[i]
        for x in range(NODES):
            for y in range(NODES):
                for z in range(NODES):
                    m = node_at(node, around, brick, x, y, z)
                    if m >= 0:
                        for q in range(channel, end):
                            table[row, x, y, z, q] = values[m, q - channel]
