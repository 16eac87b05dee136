"""The physical space Ω: what the grid reaches from ∂Ω1 without crossing a surface.

An uncut edge on any level is a true path, so every level floods along its own uncut edges and tells
the others at the nodes they share, until nothing changes. A hole wider than a cell leaks.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.solve.cuts import cut_along
from touchwarp.solve.level import FLOOR, beside, octant_start
from touchwarp.solve.multigrid import Stage

OUTER = -2
"""Owner number of the outer surface's triangles."""

TURNS = 3
"""Times that every node looks at those beside it, before those that learn late pass it on."""

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
        _copy(level.places, coarser_stage.level.places, coarser, region, False)
    return reflood(stage, region, owner)


def reflood(stage: Stage, region: Region, owner: NDArray[np.int16]) -> Region:
    """Let what is known spread along uncut edges, and through ∂Ω1 from beyond it."""
    _flood(stage.level.places, stage.cuts, owner, region)
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
            places = stages[i].level.places, stages[i - 1].level.places
            if _copy(*places, regions[i - 1], regions[i], up):
                to = i - 1 if up else i
                reflood(stages[to], regions[to], owner)
                changed = True


@njit(cache=True, nogil=True)
def _copy(fine, coarse, coarse_region, region, up):
    """Fill what one level does not know of the nodes that both have: the coarser one if `up`."""
    bricks, parent, node, coarse_node = fine.bricks, fine.parent, fine.node, coarse.node
    changed = False
    for b in range(bricks.shape[0]):
        start = 512 * np.int64(parent[b]) + octant_start(bricks, b)
        for i in range(64):
            half = 64 * (i >> 4) + 8 * ((i >> 2) & 3) + (i & 3)
            m, c = node[512 * b + 2 * half], coarse_node[start + half]
            if m < 0 or c < 0 or (region[m] == 0) == (coarse_region[c] == 0):
                continue
            if up and coarse_region[c] == 0:
                coarse_region[c] = region[m]
                changed = True
            elif not up and region[m] == 0:
                region[m] = coarse_region[c]
                changed = True
    return changed


@njit(cache=True, nogil=True)
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
            return np.uint8(1)
    return np.uint8(0)


_LOCAL_OF = np.array([448, 448, 56, 56, 7, 7])
_LAST_OF = np.array([0, 448, 0, 56, 0, 7])
_STEP_OF = np.array([-64, 64, -8, 8, -1, 1])
_BEYOND_OF = np.array([4, 22, 10, 16, 12, 14])
"""For each direction: the bits of a site that it changes, these where the next site is in another
brick, the step to it, and which of the bricks around that is."""


@njit(cache=True, nogil=True)
def _flood(places, cuts, owner, region):
    """Let each node learn from those beside it, and pass on what none was there to learn from.

    From the coarser level's nodes it is three steps at most to any other, the second and third in
    one turn, as red nodes come first.
    """
    node, around, site, n_inner = places.node, places.around, places.site, places.n_inner
    row, start, direction, triangle = cuts.row, cuts.start, cuts.direction, cuts.triangle
    lists = start, direction, triangle, owner, region
    new = np.empty(len(region), np.int32)
    count = 0
    for turn in range(TURNS):
        for m in range(len(region)):
            if region[m]:
                continue
            s = np.int64(site[m])
            for d in range(6):
                if s & _LOCAL_OF[d] != _LAST_OF[d]:
                    k = node[s + _STEP_OF[d]]
                elif d == 4 and around[s >> 9, FLOOR] == 1:
                    k = node[s + 1]
                else:
                    there = 512 * np.int64(around[s >> 9, _BEYOND_OF[d]])
                    k = node[there + (s & 511) - 7 * _STEP_OF[d]]
                # nothing comes from one node of the rim to another
                if k < 0 or not region[k] or (k >= n_inner and m >= n_inner):
                    continue
                plain = row[m] < 0 and row[k] < 0
                region[m] = region[k] if plain else _passes(row, *lists, m, k, d)
                if region[m]:
                    # those that learn in the last turn were met too late by the ones beside them
                    new[count] = m
                    count += turn == TURNS - 1
                    break
    while count > 0:
        count -= 1
        k = new[count]
        for d in range(6):
            m = beside(node, around, site[k], d)
            if m < 0 or region[m] or (k >= n_inner and m >= n_inner):
                continue
            plain = row[m] < 0 and row[k] < 0
            region[m] = region[k] if plain else _passes(row, *lists, m, k, d ^ 1)
            if region[m]:
                new[count] = m
                count += 1
