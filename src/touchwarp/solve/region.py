"""The physical space Ω: what the grid reaches from ∂Ω1 without crossing a surface.

An uncut edge on any level is a true path, so every level floods along its own uncut edges and tells
the others at the nodes they share, until nothing changes. A hole wider than a cell leaks.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.solve.cuts import cut_along
from touchwarp.solve.multigrid import Stage

OUTER = -2
"""Owner number of the outer surface's triangles."""

Region = NDArray[np.uint8]


def flood_level(
    stage: Stage, coarser: Region | None, coarser_stage: Stage | None, owner: NDArray[np.int16]
) -> Region:
    """(n,) uint8: 1 where a level's node is known to lie in Ω, 2 beyond ∂Ω1, 0 elsewhere.

    Args:
        stage: the level.
        coarser, coarser_stage: the coarser level and its region; None on the coarsest level,
            which starts from the grid's faces.
        owner: (t,) owners of the boundary's triangles.
    """
    level = stage.level
    region = np.zeros(level.n, np.uint8)
    outer_present = bool((owner == OUTER).any())
    if coarser is None or coarser_stage is None:
        region[level.n_inner :] = 2 if outer_present else 1
    else:
        _copy(
            level.bricks, level.parent, level.node, coarser_stage.level.node, coarser, region, False
        )
    return reflood(stage, region, owner)


def reflood(stage: Stage, region: Region, owner: NDArray[np.int16]) -> Region:
    """Let what is known spread along uncut edges, and through ∂Ω1 from beyond it."""
    cuts = stage.cuts
    _flood(
        stage.level.neighbours, cuts.row, cuts.start, cuts.direction, cuts.triangle, owner, region
    )
    return region


def agree(stages: list[Stage], regions: list[Region], owner: NDArray[np.int16]) -> None:
    """Exchange between levels until every path over several levels is followed."""
    last = len(stages) - 1
    exchanges = [
        *((i, True) for i in range(last, 0, -1)),
        *((i, False) for i in range(1, last + 1)),
    ]
    changed = True
    while changed:
        changed = False
        for i, up in exchanges:
            level, coarser = stages[i].level, stages[i - 1].level
            if _copy(
                level.bricks,
                level.parent,
                level.node,
                coarser.node,
                regions[i - 1],
                regions[i],
                up,
            ):
                to = i - 1 if up else i
                reflood(stages[to], regions[to], owner)
                changed = True


@njit(cache=True)
def _shared(bricks, parent, b, x, y, z):
    """Local index, in the parent brick, of the node at even local coordinates."""
    return (
        64 * (4 * (bricks[b, 0] & 1) + x)
        + 8 * (4 * (bricks[b, 1] & 1) + y)
        + 4 * (bricks[b, 2] & 1)
        + z
    )


@njit(cache=True)
def _copy(bricks, parent, node, coarse_node, coarse_region, region, up):
    """Fill what one level does not know of the nodes that both have: the coarser one if `up`."""
    changed = False
    for b in range(bricks.shape[0]):
        if parent[b] < 0:
            continue
        for x in range(4):
            for y in range(4):
                for z in range(4):
                    m = node[b, 128 * x + 16 * y + 2 * z]
                    c = coarse_node[parent[b], _shared(bricks, parent, b, x, y, z)]
                    if m < 0 or c < 0 or (region[m] == 0) == (coarse_region[c] == 0):
                        continue
                    if up and coarse_region[c] == 0:
                        coarse_region[c] = region[m]
                        changed = True
                    elif not up and region[m] == 0:
                        region[m] = coarse_region[c]
                        changed = True
    return changed


@njit(cache=True)
def _passes(row, start, direction, triangle, owner, region, m, k, d):
    """What node k of Ω or beyond makes of its neighbour m, from which k lies in direction d.

    A surface through one end of the edge is seen from that end only, so both are asked.
    """
    from_m = cut_along(row, start, direction, m, d)
    from_k = cut_along(row, start, direction, k, d ^ 1)
    if from_m < 0 and from_k < 0:
        return region[k]
    if region[k] == 2:
        # From beyond ∂Ω1 into Ω, through the outer surface and nothing else.
        seen = from_m if from_m >= 0 else from_k
        last = from_k if from_k >= 0 else from_m
        if owner[triangle[seen]] == OUTER and owner[triangle[last]] == OUTER:
            return 1
    return 0


@njit(cache=True)
def _flood(neighbours, row, start, direction, triangle, owner, region):
    n_inner = neighbours.shape[0]
    stack = np.empty(region.shape[0] + n_inner, np.int32)
    top = 0
    for m in range(n_inner):
        for d in range(6):
            k = neighbours[m, d]
            if region[m] or not region[k]:
                continue
            region[m] = _passes(row, start, direction, triangle, owner, region, m, k, d)
        if region[m]:
            stack[top] = m
            top += 1
    while top > 0:
        top -= 1
        k = stack[top]
        for d in range(6):
            m = neighbours[k, d]
            if region[m]:
                continue
            region[m] = _passes(row, start, direction, triangle, owner, region, m, k, d ^ 1)
            if region[m] and m < n_inner:
                stack[top] = m
                top += 1
