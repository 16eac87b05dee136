"""Graded grids in the plane: lines that stand close near the props and drift apart away from them.

A plane needs no bricks: fine bands across the whole box cost a few hundred lines a side, and one
sparse factorisation solves them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

MARGIN = 0.1
"""Width, in prop sizes, of the band of even spacing around a prop."""

GROWTH = 3.0
"""Growth of the spacing per prop size of distance. A harmonic field's second derivative falls with
the square of the distance, so that a proportional spacing keeps its truncation error level."""

COARSEST = 16.0
"""The widest spacing, in finest ones."""


CORNER_REACH = 0.1
CORNER_SHARE = 0.6
CORNER_DEPTH = 64.0
"""Towards the grid lines through a corner, from this part of the prop's size on, spacing shrinks in
proportion to the distance, by up to `CORNER_DEPTH`: a corner's r^(2/3) otherwise spoils the whole
field (0.25 → 0.005 mm at 1 mm spacing, for half as many nodes again). Where corners are many, their
reaches together take no more than `CORNER_SHARE` of the prop's size."""


@dataclass(frozen=True, eq=False)
class PlaneFeatures:
    """What a grid is graded to.

    Attributes:
        bounds: (p, 2, 2) m, least and greatest corner of each prop's bounding box.
        corners: (c, 2) m, sharp corners and loose ends.
        owner: (c,) the prop of each.
    """

    bounds: NDArray[np.float64]
    corners: NDArray[np.float64]
    owner: NDArray[np.int64]

    @property
    def sizes(self) -> NDArray[np.float64]:
        """(p,) m, the longest side of each box."""
        return np.asarray((self.bounds[:, 1] - self.bounds[:, 0]).max(axis=1))


@dataclass(frozen=True, eq=False)
class PlaneGrid:
    """A rectilinear grid; nodes stand where lines cross, boundary included.

    Attributes:
        x_lines: (nx,) m, ascending, table frame.
        y_lines: (ny,) m, ascending, table frame.
        finest: m, the spacing near the props.
    """

    x_lines: NDArray[np.float64]
    y_lines: NDArray[np.float64]
    finest: float

    @property
    def shape(self) -> tuple[int, int]:
        """(nx, ny)."""
        return len(self.x_lines), len(self.y_lines)

    @property
    def lines(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The lines across axis 0 and across axis 1."""
        return self.x_lines, self.y_lines

    def nodes(self) -> NDArray[np.float64]:
        """(nx · ny, 2) m, table frame; node (i, j) is row i · ny + j."""
        x, y = np.meshgrid(self.x_lines, self.y_lines, indexing="ij")
        return np.stack([x.ravel(), y.ravel()], axis=1)


def grade_grid(box: NDArray[np.float64], features: PlaneFeatures, spacing: float) -> PlaneGrid:
    """A grid over a box whose spacing is `spacing` near the props, and finer by their corners.

    The lines follow one continuous density, whatever the spacing, so that halving the spacing
    halves every distance and the differences stay of second order.

    Args:
        box: (2, 2) m, least and greatest corner.
        features: the props.
        spacing: m.
    """
    lines = []
    for axis in range(2):
        position, progress = _progress(box[:, axis], features, axis)
        numbers = np.linspace(0.0, progress[-1], _cells(progress[-1], spacing) + 1)
        lines.append(np.interp(numbers, progress, position))
        lines[-1][0], lines[-1][-1] = box[:, axis]
    return PlaneGrid(lines[0], lines[1], spacing)


def count_nodes(box: NDArray[np.float64], features: PlaneFeatures, spacing: float) -> int:
    """Nodes that `grade_grid` would make, without making them."""
    cells = [_cells(_progress(box[:, k], features, k)[1][-1], spacing) for k in range(2)]
    return (cells[0] + 1) * (cells[1] + 1)


def _cells(measure: float, spacing: float) -> int:
    return max(4, int(np.ceil(measure / spacing)))


def _progress(
    ends: NDArray[np.float64], features: PlaneFeatures, axis: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Samples of position along an axis, and the integral of 1 / relative spacing up to them."""
    bounds, sizes = features.bounds[:, :, axis], features.sizes
    band = np.stack([bounds[:, 0] - MARGIN * sizes, bounds[:, 1] + MARGIN * sizes])
    offsets = np.geomspace(1 / CORNER_DEPTH, 1.0, 17)
    offsets = np.concatenate([-offsets, [0.0], offsets])
    corner, near = _corner_lines(features, axis)
    places = [np.linspace(ends[0], ends[1], 2001), band.ravel()]
    position = np.concatenate([*places, (corner[:, None] + near[:, None] * offsets).ravel()])
    position = np.unique(np.clip(position, ends[0], ends[1]))
    outside = np.maximum(band[0] - position[:, None], position[:, None] - band[1])
    relative = 1.0 + GROWTH * np.maximum(outside, 0.0) / sizes
    relative = np.minimum(relative.min(axis=1), COARSEST)
    for place, reach in zip(corner, near, strict=True):
        shrunk = np.abs(position - place) / reach
        relative = np.minimum(relative, np.maximum(shrunk, 1 / CORNER_DEPTH))
    density = 1.0 / relative
    steps = np.diff(position) * 0.5 * (density[1:] + density[:-1])
    return position, np.concatenate([[0.0], np.cumsum(steps)])


def _corner_lines(
    features: PlaneFeatures, axis: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where lines through corners stand, each place once, and how far each one reaches, m."""
    place = features.corners[:, axis]
    rivals = np.bincount(features.owner, minlength=len(features.bounds))
    share = np.minimum(CORNER_REACH, CORNER_SHARE / np.maximum(rivals, 1))
    reach = (share * features.sizes)[features.owner]
    order = np.lexsort((-reach, np.rint(place * 1e9)))
    place, reach = place[order], reach[order]
    first = np.diff(np.rint(place * 1e9), prepend=-np.inf) > 0
    return place[first], reach[first]
