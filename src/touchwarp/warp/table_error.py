"""What the table is estimated to miss, and where."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.solve.cuts import cut_along
from touchwarp.solve.level import beside
from touchwarp.solve.marking import SAFETY
from touchwarp.solve.problem import Problem
from touchwarp.solve.refine import indicate
from touchwarp.solve.samples import sample_points
from touchwarp.solve.solution import Solution
from touchwarp.solve.threads import share
from touchwarp.solve.tube import Tube
from touchwarp.warp.from_solution import Fitted
from touchwarp.warp.table_grid import TableGrid

Real = NDArray[np.float64]

GROSS = 3.0
"""Single points of the surfaces may miss the tolerance, but not by this many times, as long as the
99th percentile and the field keep it. The certificate, which allows five, finds points between the
fit's own that miss by half as much again."""


@dataclass(frozen=True, eq=False)
class TableError:
    """The estimated error of a table.

    Attributes:
        outside_tube_max: m, greatest error in Ω farther than the edge radius from edges.
        outside_tube_rms: m, over the nodes there.
        inside_tube_max: m, greatest error within the edge radius.
        contact_p99: m, 99th percentile over the props' area of |table − g|.
        contact_max: m.
        poor_points: (k, 3) root-grid coordinates where the tolerance is missed.
        poor_depths: (k,) levels of the cells there.
    """

    outside_tube_max: float
    outside_tube_rms: float
    inside_tube_max: float
    contact_p99: float
    contact_max: float
    poor_points: Real
    poor_depths: NDArray[np.int64]


def interpolation_error(
    solution: Solution,
    lane_scale: NDArray[np.float32],
    normal_lanes: NDArray[np.bool_],
) -> list[NDArray[np.float32]]:
    """What trilinear interpolation of a solution misses (⅛ |Σ h² ∂²u|): for each stage (n,) m.

    0 at nodes that are not inner ones of their level.

    Args:
        solution: what the table is made of.
        lane_scale: (4,) weight of each lane, to metres.
        normal_lanes: (4,) lanes that vanish on the sliding plane.
    """
    return [
        np.append(
            indicate(stage, region, lane_scale, normal_lanes),
            np.zeros(stage.level.n - stage.level.n_inner, np.float32),
        )
        for stage, region in zip(solution.stages, solution.regions, strict=True)
    ]


def estimate_error(
    problem: Problem,
    solution: Solution,
    grid: TableGrid,
    tube: Tube,
    lane_scale: NDArray[np.float32],
    tolerance: float,
    interpolation: list[NDArray[np.float32]],
    fitted: Fitted | None = None,
) -> TableError:
    """Discretisation (τ) and interpolation, and what hanging and fitting moved.

    Args:
        problem, solution, grid: what the table is made of.
        tube: where only contact is promised.
        lane_scale: (4,) weight of each lane, to metres.
        tolerance: m.
        interpolation: see `interpolation_error`.
        fitted: the table; without it, what hanging and fitting add is left out.
    """
    outside: list[NDArray[np.floating]] = [np.zeros(1)]
    points: list[Real] = [np.empty((0, 3))]
    depths: list[NDArray[np.int64]] = [np.empty(0, np.int64)]
    inside = 0.0
    for i, stage in enumerate(solution.stages):
        nodes, size = grid.own[i], interpolation[i]
        if len(nodes) == 0:
            continue
        if fitted is not None:
            moved = fitted.moved[i]
            moves = (fitted.values[i][moved] - stage.u[moved]) * lane_scale
            length = np.zeros(stage.level.n, np.float32)
            length[moved] = np.sqrt(np.einsum("ij,ij->i", moves, moves))
            size = size.copy()
            given = length, stage.level.places, stage.cuts, solution.regions[i]
            share(add_moves, len(moved), moved, *given, interpolation[i], size)
        size = size[nodes] + solution.error[i][nodes]
        suspects = np.flatnonzero(size > 0.5 * min(size.max(), tolerance))
        where = stage.level.coordinates(nodes[suspects]) / 2.0**stage.level.depth
        in_tube = np.zeros(len(nodes), bool)
        in_tube[suspects] = tube.contains(problem.frame.to_scene(where))
        outside.append(size[~in_tube])
        inside = max(inside, float(size[in_tube].max(initial=0.0)))
        poor = (size[suspects] > tolerance) & ~in_tube[suspects]
        points.append(where[poor])
        depths.append(np.full(int(poor.sum()), stage.level.depth))
    p99, worst = (0.0, 0.0) if fitted is None else _contact(problem, fitted)
    if fitted is not None:
        # the fit serves its own samples best, so their percentile has to keep a distance
        within = tolerance if p99 > SAFETY * tolerance else GROSS * tolerance
        # where the field is poor it is because of cells like those whose contact is
        beyond = tolerance if any(len(found) for found in points) else within
        for i, where in enumerate(_poor_contact(problem, solution, fitted, tube, within, beyond)):
            points.append(where)
            depths.append(np.full(len(where), solution.stages[i].level.depth))
    all_outside = np.concatenate(outside)
    return TableError(
        float(all_outside.max()),
        float(np.sqrt((all_outside**2).mean())),
        inside,
        p99,
        worst,
        np.concatenate(points),
        np.concatenate(depths),
    )


@njit(cache=True, nogil=True)
def greatest_between(a, b, interpolation):
    """The greatest of (1 - t) a + t b + 4 t (1 - t) interpolation for t from 0 to 1."""
    if abs(b - a) >= 4.0 * interpolation:
        return max(a, b)
    return 0.5 * (a + b) + interpolation + (b - a) ** 2 / (16.0 * interpolation)


@njit(cache=True, nogil=True)
def add_moves(first, last, moved, length, places, cuts, region, interpolation, size):
    """Add how far nodes were moved to what interpolation misses in the cells around them.

    At a moved node nothing is interpolated; half way to a neighbour, half of what both were moved
    is there. In a cell the sum is greatest on an edge: at a place t interpolation misses no more
    than 4 tᵢ (1 - tᵢ) of its greatest, tᵢ being the coordinate nearest to ½, and along that axis
    moves are a mean of those on four edges. Each edge counts for the end that was moved farther;
    one that leaves Ω through a surface counts up to there, with the node's own move.

    Args:
        first, last: the part of `moved` (k,) to do.
        length: (n,) m, how far each node was moved.
        places, cuts, region: the level.
        interpolation: (n,) m; size: (n,) m, written for the nodes that were moved.
    """
    node, around, site = places.node, places.around, places.site
    row, start, direction, distance = cuts.row, cuts.start, cuts.direction, cuts.distance
    for i in range(first, last):
        m = moved[i]
        own, worst = length[m], length[m]
        for d in range(6):
            k = beside(node, around, site[m], d)
            cut = cut_along(row, start, direction, m, d)
            if cut >= 0:
                t = min(distance[cut], 0.5)
                worst = max(worst, own + 4.0 * t * (1.0 - t) * interpolation[m])
            elif k >= 0 and region[k] == 1:
                other = min(length[k], own)
                worst = max(worst, greatest_between(own, other, interpolation[m]))
        size[m] = worst


def _poor_contact(
    problem: Problem,
    solution: Solution,
    fitted: Fitted,
    tube: Tube,
    within: float,
    beyond: float,
) -> list[Real]:
    """Root-grid coordinates (k, 3) on the surfaces where contact is poor, for each stage.

    Args:
        problem, solution, fitted, tube: see `estimate_error`.
        within, beyond: m, what contact may miss in the tube and outside it.
    """
    result = []
    for stage, samples, size in zip(solution.stages, fitted.samples, fitted.residuals, strict=True):
        poor = size > min(within, beyond)
        where = sample_points(stage, samples, poor)
        in_tube = tube.contains(problem.frame.to_scene(where))
        result.append(where[size[poor] > np.where(in_tube, within, beyond)])
    return result


def _contact(problem: Problem, fitted: Fitted) -> tuple[float, float]:
    """99th percentile by area, and maximum, of residuals on the props."""
    sizes: list[NDArray[np.floating]] = [np.zeros(1)]
    areas: list[Real] = [np.zeros(1)]
    for i, (samples, size) in enumerate(zip(fitted.samples, fitted.residuals, strict=True)):
        own = problem.boundary.owner[samples.triangle] >= 0
        sizes.append(size[own])
        areas.append(samples.weight[own].astype(np.float64) / 4.0**i)
    size, area = np.concatenate(sizes), np.concatenate(areas)
    return _quantile(size, area, 0.99), float(size.max())


def _quantile(size: NDArray[np.floating], weight: Real, share: float) -> float:
    """The least value that this share of all weight does not exceed.

    Only the largest values are sorted.
    """
    above = (1.0 - share) * float(weight.sum())
    least = float(size.max())
    top = size >= least
    while weight[top].sum() <= above and not top.all():
        least = 0.7 * least if least > 1e-12 else -1.0
        top = size >= least
    order = np.argsort(size[top])[::-1]
    beyond = np.cumsum(weight[top][order])
    at = min(int(np.searchsorted(beyond, above, side="right")), len(order) - 1)
    return float(size[top][order[at]])
