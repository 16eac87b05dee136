"""The contact fit of a plane table: its bilinear interpolant is made to equal g on the curves.

A cell that a curve crosses mixes values from both sides of it, and a finger would miss the curve
just where it matters. So the nodes of crossed cells move by least squares until the interpolant
equals g along the curve. Nodes outside Ω are tied weakly, to the field of Ω continued through the
curve; nodes in Ω are tied strongly to the solution and give way only where the others do not
suffice: at convex corners, open sheets and thin walls. The fit is one fixed linear operator.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from touchwarp.solve.plane import PlaneField
from touchwarp.solve.plane_cuts import EAST, NORTH, SOUTH, WEST, Curves, cross_lines
from touchwarp.solve.plane_grid import PlaneGrid

TIE_IN_DOMAIN = 0.05
TIE_CONTINUED = 0.02
TIE_UNKNOWN = 1e-4
"""Strength of the ties against a contact sample's 1: nodes of Ω to the solution, other nodes to the
continued field, and nodes with neither to the solution inside the prop."""


class ContactSamples(NamedTuple):
    """Points along the curves, three to each piece within one cell: enough to pin the interpolant,
    a quadratic along a straight line.

    Attributes:
        points: (k, 2) m, table frame.
        segment: (k,) the curve segment of each.
        fraction: (k,) where along it.
        cell: (k, 2) the cell of each.
        weight: (k,) square root of the piece's length in cells.
    """

    points: NDArray[np.float64]
    segment: NDArray[np.int64]
    fraction: NDArray[np.float64]
    cell: NDArray[np.int64]
    weight: NDArray[np.float64]


def fit_contact(field: PlaneField, curves: Curves) -> NDArray[np.float64]:
    """Node values (nx, ny, 2) m, table axes, whose bilinear interpolant equals g on the curves."""
    samples = sample_contact(field.grid, curves)
    interpolate = interpolation(field.grid, samples.points, samples.cell)
    fitted = np.unique(interpolate.indices)
    solution = field.displacement.reshape(-1, 2)
    if len(fitted) == 0:
        return field.displacement
    on_curve = _along(curves, samples.segment, samples.fraction)
    contact = sparse.diags_array(samples.weight) @ interpolate[:, fitted]
    tie, target = _ties(field, curves, fitted, samples.cell)
    matrix = sparse.vstack([contact, tie]).tocsc()
    right = np.concatenate([samples.weight[:, None] * on_curve, target])
    normal = (matrix.T @ matrix).tocsc()
    moved = splu(normal, permc_spec="MMD_AT_PLUS_A").solve(matrix.T @ right)
    values = solution.copy()
    values[fitted] = moved
    return values.reshape(field.displacement.shape)


def sample_contact(grid: PlaneGrid, curves: Curves) -> ContactSamples:
    """Split every segment at the grid's lines and sample each piece."""
    count = len(curves.segments)
    segments, fractions = [np.repeat(np.arange(count), 2)], [np.tile([0.0, 1.0], count)]
    for axis in range(2):
        _, segment, fraction = cross_lines(grid.lines[axis], curves, axis)
        segments.append(segment)
        fractions.append(fraction)
    segment, fraction = np.concatenate(segments), np.concatenate(fractions)
    order = np.lexsort((fraction, segment))
    segment, fraction = segment[order], fraction[order]
    piece = (segment[1:] == segment[:-1]) & (fraction[1:] - fraction[:-1] > 1e-12)
    segment, low, high = segment[:-1][piece], fraction[:-1][piece], fraction[1:][piece]
    along = (low[:, None] + (high - low)[:, None] * np.array([1 / 6, 1 / 2, 5 / 6])).ravel()
    owner = np.repeat(segment, 3)
    start, stop = (curves.points[curves.segments[owner, end]] for end in range(2))
    points = start + along[:, None] * (stop - start)
    middle = points[1::3]
    cell = np.stack([_cell(grid.lines[axis], middle[:, axis]) for axis in range(2)], axis=1)
    width = np.stack([np.diff(grid.lines[axis])[cell[:, axis]] for axis in range(2)], axis=1)
    length = np.linalg.norm((stop - start)[::3], axis=1) * (high - low)
    weight = np.sqrt(np.maximum(length / width.min(axis=1), 0.01))
    low_corner, high_corner = (
        np.array([grid.lines[axis][end] for axis in range(2)]) for end in (0, -1)
    )
    kept = np.repeat(((middle > low_corner) & (middle < high_corner)).all(axis=1), 3)
    return ContactSamples(
        points[kept],
        owner[kept],
        along[kept],
        np.repeat(cell, 3, axis=0)[kept],
        np.repeat(weight, 3)[kept],
    )


def interpolation(
    grid: PlaneGrid, points: NDArray[np.float64], cell: NDArray[np.int64]
) -> sparse.csr_array:
    """The (k, nodes) matrix of bilinear weights of points (k, 2) in given cells (k, 2)."""
    rows = np.tile(np.arange(len(points)), 4)
    part = np.empty_like(points)
    for axis in range(2):
        lines = grid.lines[axis]
        low = lines[cell[:, axis]]
        part[:, axis] = (points[:, axis] - low) / (lines[cell[:, axis] + 1] - low)
    s, t = part.T
    first = cell[:, 0] * grid.shape[1] + cell[:, 1]
    nodes = np.concatenate([first + k for k in (0, 1, grid.shape[1], grid.shape[1] + 1)])
    weights = np.concatenate([(1 - s) * (1 - t), (1 - s) * t, s * (1 - t), s * t])
    size = grid.shape[0] * grid.shape[1]
    return sparse.csr_array((weights, (rows, nodes)), shape=(len(points), size))


def _cell(lines: NDArray[np.float64], places: NDArray[np.float64]) -> NDArray[np.int64]:
    return np.clip(np.searchsorted(lines, places, side="right") - 1, 0, len(lines) - 2)


def _along(
    curves: Curves, segment: NDArray[np.int64], fraction: NDArray[np.float64]
) -> NDArray[np.float64]:
    start, stop = (curves.displacement[curves.segments[segment, end]] for end in range(2))
    return np.asarray(start + fraction[:, None] * (stop - start))


def _ties(
    field: PlaneField, curves: Curves, fitted: NDArray[np.int64], cell: NDArray[np.int64]
) -> tuple[sparse.csr_array, NDArray[np.float64]]:
    """Rows and right-hand sides (·, 2) that hold the fitted nodes where the curves leave them."""
    solution = field.displacement.reshape(-1, 2)
    reached = field.reached.ravel()[fitted]
    continued, known = _continue(field, curves, fitted)
    strength = np.where(reached, TIE_IN_DOMAIN, np.where(known, TIE_CONTINUED, TIE_UNKNOWN))
    target = np.where((known & ~reached)[:, None], continued, solution[fitted])
    ny = field.grid.shape[1]
    unknown = np.zeros(len(solution), dtype=bool)
    unknown[fitted[~reached & ~known]] = True
    corner = np.unique(cell[:, 0] * ny + cell[:, 1])
    corner = corner[unknown[corner[:, None] + np.array([0, 1, ny, ny + 1])].any(axis=1)]
    column = np.zeros(len(solution), dtype=np.int64)
    column[fitted] = np.arange(len(fitted))
    rows = np.repeat(np.arange(len(corner)), 4)
    columns = column[(corner[:, None] + np.array([0, 1, ny, ny + 1])).ravel()]
    signs = np.tile(TIE_CONTINUED * np.array([1.0, -1.0, -1.0, 1.0]), len(corner))
    no_twist = sparse.csr_array((signs, (rows, columns)), shape=(len(corner), len(fitted)))
    return (
        sparse.vstack([sparse.diags_array(strength), no_twist]).tocsr(),
        np.concatenate([strength[:, None] * target, np.zeros((len(corner), 2))]),
    )


def _continue(
    field: PlaneField, curves: Curves, nodes: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """The field of Ω continued to nodes across a curve, along cut edges.

    A parabola through the crossing and the next two nodes of Ω, or a line through the crossing and
    the next one; a node with several cut edges takes the mean.

    Returns:
        values (k, 2) m, and whether there is a value (k,).
    """
    cuts, shape = field.cuts, np.array(field.grid.shape)
    total, count = np.zeros((len(nodes), 2)), np.zeros(len(nodes))
    for toward, back in ((WEST, EAST), (EAST, WEST), (SOUTH, NORTH), (NORTH, SOUTH)):
        axis, step = divmod(toward, 2)
        hop = np.zeros(2, dtype=np.int64)
        hop[axis] = 2 * step - 1
        at = np.stack(np.divmod(nodes, shape[1]), axis=1)
        inside = ((at + hop >= 0) & (at + hop < shape)).all(axis=1)
        chosen = np.flatnonzero(inside & (cuts.crossing[toward][tuple(at.T)] >= 0))
        chosen = chosen[field.reached[tuple((at[chosen] + hop).T)]]
        node, first = tuple(at[chosen].T), tuple((at[chosen] + hop).T)
        second = tuple(np.clip(node[k] + 2 * hop[k], 0, shape[k] - 1) for k in range(2))
        lines = field.grid.lines[axis]
        row = cuts.crossing[back][first]  # the nearest to Ω where an edge is crossed repeatedly
        at_curve = _along(curves, cuts.segment[row], cuts.fraction[row])
        p = cuts.distance[back][first][:, None]
        q = p + np.abs(lines[second[axis]] - lines[first[axis]])[:, None]
        x = p - np.abs(lines[first[axis]] - lines[node[axis]])[:, None]
        at_first, at_second = field.displacement[first], field.displacement[second]
        straight = at_curve + (at_first - at_curve) * x / p
        with np.errstate(divide="ignore", invalid="ignore"):
            bent = (
                at_curve * (x - p) * (x - q) / (p * q)
                + at_first * x * (x - q) / (p * (p - q))
                + at_second * x * (x - p) / (q * (q - p))
            )
        clear = (cuts.crossing[toward][first] < 0) & (second[axis] != first[axis])
        total[chosen] += np.where(clear[:, None], bent, straight)
        count[chosen] += 1
    return total / np.maximum(count, 1)[:, None], count > 0
