"""Where the lines of a plane grid cross curves: the cut edges of the plane solver."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.solve.plane_grid import PlaneGrid

WEST, EAST, SOUTH, NORTH = range(4)
NEAREST = 1e-6
"""A crossing nearer to a node than this part of a cell is put at this distance: the node then takes
its value, and the stencil stays finite."""


@dataclass(frozen=True, eq=False)
class Curves:
    """Every curve with Dirichlet data, as one set of segments.

    Attributes:
        points: (n, 2) m, table frame.
        segments: (m, 2) int64, rows of point indices.
        displacement: (n, 2) m, table axes: u at the points, linear between.
    """

    points: NDArray[np.float64]
    segments: NDArray[np.int64]
    displacement: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PlaneCuts:
    """The nearest crossing on each side of each node.

    Attributes:
        distance: (4, nx, ny) m to the crossing or, without one, to the next node, by direction
            west, east, south, north; infinite where the grid ends.
        crossing: (4, nx, ny) int64, row in the arrays below, or -1.
        segment: (c,) int64, the segment crossed.
        fraction: (c,) in 0…1, where along that segment.
    """

    distance: NDArray[np.float64]
    crossing: NDArray[np.int64]
    segment: NDArray[np.int64]
    fraction: NDArray[np.float64]


def cut_plane(grid: PlaneGrid, curves: Curves) -> PlaneCuts:
    """Cut the edges of a grid by curves."""
    shape = grid.shape
    distance = np.full((4, *shape), np.inf)
    distance[EAST, :-1] = distance[WEST, 1:] = np.diff(grid.x_lines)[:, None]
    distance[NORTH, :, :-1] = distance[SOUTH, :, 1:] = np.diff(grid.y_lines)[None, :]
    crossing = np.full((4, *shape), -1, dtype=np.int64)
    segments, fractions = [], []
    found = 0
    for axis in range(2):  # the axis along which the lines that are scanned run
        line, segment, fraction = cross_lines(grid.lines[1 - axis], curves, 1 - axis)
        start, stop = (curves.points[curves.segments[segment, end], axis] for end in range(2))
        place = start + fraction * (stop - start)
        node, backward, gap, row = _sides(grid.lines[axis], place)
        i, j = (node, line[row]) if axis == 0 else (line[row], node)
        direction = 2 * axis + np.where(backward, 0, 1)
        order = np.argsort(-gap, kind="stable")  # where one node sees several, the nearest is last
        at = direction[order], i[order], j[order]
        crossing[at] = found + row[order]
        cell = distance[at]
        distance[at] = np.maximum(gap[order], NEAREST * np.where(np.isfinite(cell), cell, 1.0))
        segments.append(segment)
        fractions.append(fraction)
        found += len(segment)
    return PlaneCuts(distance, crossing, np.concatenate(segments), np.concatenate(fractions))


def cross_lines(
    lines: NDArray[np.float64], curves: Curves, axis: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Crossings of segments with grid lines at given coordinates along an axis.

    A segment's ends belong to it, so that no line slips through between two segments; one that
    lies along a line gives its two ends.

    Returns:
        line (c,), segment (c,), fraction along the segment (c,).
    """
    start, stop = (curves.points[curves.segments[:, end], axis] for end in range(2))
    low, high = np.minimum(start, stop), np.maximum(start, stop)
    first = np.searchsorted(lines, low, side="left")
    count = np.searchsorted(lines, high, side="right") - first
    segment = np.repeat(np.arange(len(first)), count)
    line = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count) + first[segment]
    rise = (stop - start)[segment]
    along = rise == 0.0
    fraction = np.where(along, 0.0, (lines[line] - start[segment]) / np.where(along, 1.0, rise))
    return (
        np.concatenate([line, line[along]]),
        np.concatenate([segment, segment[along]]),
        np.clip(np.concatenate([fraction, np.ones(int(along.sum()))]), 0.0, 1.0),
    )


def _sides(
    lines: NDArray[np.float64], place: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.bool_], NDArray[np.float64], NDArray[np.int64]]:
    """The nodes of a line that see a crossing, which side they see it on, and how far away.

    A crossing at a node is seen by that node on both sides, and by both its neighbours.
    """
    last = len(lines) - 1
    cell = np.clip(np.searchsorted(lines, place, side="right") - 1, 0, last - 1)
    inside = (place >= lines[0]) & (place <= lines[-1])
    width = lines[cell + 1] - lines[cell]
    ahead = np.maximum(place - lines[cell], 0.0)
    behind = np.maximum(lines[cell + 1] - place, 0.0)
    on_lower = inside & (ahead < NEAREST * width)
    on_upper = inside & (behind < NEAREST * width)
    rows = np.arange(len(place))
    parts = [  # node, whether it looks backward, distance, which crossings
        (cell, False, ahead, inside),
        (cell + 1, True, behind, inside),
        (cell, True, ahead, on_lower),
        (cell - 1, False, lines[cell] - lines[cell - 1], on_lower & (cell > 0)),
        (cell + 1, False, behind, on_upper),
        (
            cell + 2,
            True,
            lines[np.minimum(cell + 2, last)] - lines[cell + 1],
            on_upper & (cell + 2 <= last),
        ),
    ]
    return (
        np.concatenate([node[chosen] for node, _, _, chosen in parts]),
        np.concatenate([np.full(int(chosen.sum()), back) for _, back, _, chosen in parts]),
        np.concatenate([gap[chosen] for _, _, gap, chosen in parts]),
        np.concatenate([rows[chosen] for _, _, _, chosen in parts]),
    )
