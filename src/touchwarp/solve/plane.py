"""The plane solver: Δu = λ u with Shortley–Weller cut edges on one graded grid.

Where a curve crosses a grid edge the stencil reaches to the crossing and takes the goal's value
there, from both sides. Every weight is non-negative, so the discrete displacement obeys the maximum
principle. The grid is solved by one sparse factorisation, which serves every further goal.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import SuperLU, splu

from touchwarp.errors import SolveError
from touchwarp.solve.plane_cuts import EAST, NORTH, SOUTH, WEST, Curves, PlaneCuts, cut_plane
from touchwarp.solve.plane_grid import PlaneFeatures, PlaneGrid, count_nodes, grade_grid

BYTES_PER_NODE = 2600.0
"""Measured peak of the factorisation at 0.6 million nodes; it grows with log n."""


@dataclass(frozen=True, eq=False)
class PlaneProblem:
    """Geometry and data in the table frame.

    Attributes:
        box: (2, 2) m, least and greatest corner of the grid; u = 0 on its sides.
        features: what the grid is graded to.
        curves: props, outer polygon and held lines, with their displacements in table axes.
        outer: (k,) int64, the rows of `curves.segments` that are ∂Ω1; none where the box is.
        screening: λ, m⁻².
        mirrored: y = `box[0, 1]` is a sliding line: u_y = 0 and ∂u_x/∂y = 0 there.
    """

    box: NDArray[np.float64]
    features: PlaneFeatures
    curves: Curves
    outer: NDArray[np.int64]
    screening: float
    mirrored: bool = False

    def nodes_at(self, spacing: float) -> int:
        """Nodes of the grid of a finest spacing in m."""
        return count_nodes(self.box, self.features, spacing)


@dataclass(frozen=True, eq=False)
class PlaneField:
    """The solution at the nodes.

    Attributes:
        grid: the nodes.
        cuts: the cut edges.
        displacement: (nx, ny, 2) m, table axes.
        reached: (nx, ny) bool, nodes in Ω: those that ∂Ω1 can reach without crossing a curve.
        residual: greatest residual over the greatest datum, rows scaled to a diagonal of 1.
    """

    grid: PlaneGrid
    cuts: PlaneCuts
    displacement: NDArray[np.float64]
    reached: NDArray[np.bool_]
    residual: float


class PlaneSolver:
    """A grid cut and factorised, for repeated solves with other goals on the same curves."""

    def __init__(self, problem: PlaneProblem, spacing: float) -> None:
        """Cut and factorise.

        Args:
            problem: the geometry.
            spacing: m, near the props.
        Raises:
            SolveError: the matrix is singular, which finite geometry does not make.
        """
        self.problem = problem
        self.grid = grade_grid(problem.box, problem.features, spacing)
        self.cuts = cut_plane(self.grid, problem.curves)
        self.reached = _reached(self.grid, self.cuts, problem)
        self._systems: list[tuple[sparse.csr_array, sparse.csr_array, SuperLU]] = []
        for sliding in (True, False) if problem.mirrored else (False,):
            matrix, load = _assemble(self.grid, self.cuts, problem, sliding)
            self._systems.append((matrix, load, _factorise(matrix)))

    def solve(self, displacement: NDArray[np.float64] | None = None) -> PlaneField:
        """The displacement at the nodes.

        Args:
            displacement: (n, 2) m, table axes, at the problem's curve points; its own if None.
        Raises:
            SolveError: numbers overflow.
        """
        given = self.problem.curves.displacement if displacement is None else displacement
        columns = np.empty((self.grid.shape[0] * self.grid.shape[1], 2))
        residual = 0.0
        for component in range(2):
            matrix, load, factors = self._systems[component % len(self._systems)]
            right = load @ given[:, component]
            columns[:, component] = factors.solve(right)
            residual = max(residual, float(np.abs(matrix @ columns[:, component] - right).max()))
        if not np.isfinite(columns).all():
            raise SolveError(
                "The plane solve gave NaN or infinite displacements; data within about 1e100 m "
                "are needed: check the unit of the props and of their goals."
            )
        scale = max(float(np.abs(given).max(initial=0.0)), 1e-300)
        field = columns.reshape(*self.grid.shape, 2)
        return PlaneField(self.grid, self.cuts, field, self.reached, residual / scale)


def _assemble(
    grid: PlaneGrid, cuts: PlaneCuts, problem: PlaneProblem, sliding: bool
) -> tuple[sparse.csr_array, sparse.csr_array]:
    """Rows (1 + λ/d) u − Σ w u_neighbour = Σ w g_crossing, scaled to a diagonal of 1.

    `sliding` makes the floor a mirror (the tangential component); else it is held at 0.
    """
    shape = grid.shape
    nodes = np.arange(shape[0] * shape[1]).reshape(shape)
    distance, crossing = cuts.distance.copy(), cuts.crossing.copy()
    free = np.zeros(shape, dtype=bool)
    free[1:-1, 0 if sliding else 1 : -1] = True
    neighbour = np.zeros((4, *shape), dtype=np.int64)
    neighbour[WEST, 1:], neighbour[EAST, :-1] = nodes[:-1], nodes[1:]
    neighbour[SOUTH, :, 1:], neighbour[NORTH, :, :-1] = nodes[:, :-1], nodes[:, 1:]
    if sliding:
        for part in (distance, crossing, neighbour):
            part[SOUTH, :, 0] = part[NORTH, :, 0]
    gap, crossed, beside = distance[:, free], crossing[:, free], neighbour[:, free]
    rows = np.broadcast_to(nodes[free], gap.shape)
    weight = np.empty_like(gap)
    for low, high in ((WEST, EAST), (SOUTH, NORTH)):
        both = gap[low] + gap[high]
        weight[low] = 2.0 / (gap[low] * both)
        weight[high] = 2.0 / (gap[high] * both)
    weight /= weight.sum(axis=0) + problem.screening
    cut = crossed >= 0
    ends = problem.curves.segments[cuts.segment[crossed[cut]]]
    along = cuts.fraction[crossed[cut]]
    load = sparse.csr_array(
        (
            np.concatenate([weight[cut] * (1.0 - along), weight[cut] * along]),
            (np.tile(rows[cut], 2), np.concatenate([ends[:, 0], ends[:, 1]])),
        ),
        shape=(nodes.size, len(problem.curves.points)),
    )
    inner = sparse.csr_array(
        (weight[~cut], (rows[~cut], beside[~cut])), shape=(nodes.size, nodes.size)
    )
    return (sparse.eye_array(nodes.size, format="csr") - inner).tocsr(), load


def _factorise(matrix: sparse.csr_array) -> SuperLU:
    """LU without pivoting: the matrix is diagonally dominant with a symmetric pattern."""
    try:
        return splu(
            matrix.tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except (MemoryError, RuntimeError) as failure:
        raise SolveError(
            f"The plane grid of {matrix.shape[0]} nodes cannot be factorised ({failure}); "
            "a greater tolerance makes a smaller grid."
        ) from failure


def _reached(grid: PlaneGrid, cuts: PlaneCuts, problem: PlaneProblem) -> NDArray[np.bool_]:
    """Nodes in Ω, by components of the graph of uncut edges."""
    shape = grid.shape
    nodes = np.arange(shape[0] * shape[1]).reshape(shape)
    right = cuts.crossing[EAST, :-1] < 0
    above = cuts.crossing[NORTH, :, :-1] < 0
    ends = (
        np.concatenate([nodes[:-1][right], nodes[:, :-1][above]]),
        np.concatenate([nodes[1:][right], nodes[:, 1:][above]]),
    )
    graph = sparse.coo_array((np.ones(len(ends[0]), np.int8), ends), shape=(nodes.size, nodes.size))
    count, label = connected_components(graph, directed=False)
    if len(problem.outer) == 0:
        floor = nodes[:, :0] if problem.mirrored else nodes[:, :1]
        seeds = np.concatenate([nodes[0], nodes[-1], nodes[:, -1], floor.ravel()])
        chosen = np.unique(label[seeds])
    else:
        on_outer = np.zeros(len(problem.curves.segments), dtype=bool)
        on_outer[problem.outer] = True
        beside = (cuts.crossing >= 0) & on_outer[cuts.segment[cuts.crossing]]
        touching = np.unique(label[nodes[beside.any(axis=0)]])
        first = np.full(count, nodes.size)
        np.minimum.at(first, label, np.arange(nodes.size))
        places = grid.nodes()[first[touching]]
        ends_of = problem.curves.points[problem.curves.segments[problem.outer]]
        chosen = touching[encloses(ends_of, places)]
    return np.isin(label, chosen).reshape(shape)


def encloses(segments: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether closed curves enclose points, by counting crossings of a ray.

    Args:
        segments: (m, 2, 2) m, ends of each segment, in any order and sense.
        points: (n, 2) m.
    Returns:
        (n,) bool.
    """
    result = np.zeros(len(points), dtype=bool)
    rows = max(1, 4_000_000 // len(segments))
    (ax, ay), (bx, by) = segments[:, 0].T, segments[:, 1].T
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = (bx - ax) / (by - ay)
        for k in range(0, len(points), rows):
            x, y = points[k : k + rows, 0, None], points[k : k + rows, 1, None]
            spans = (ay <= y) != (by <= y)
            result[k : k + rows] = (spans & (x < ax + (y - ay) * slope)).sum(axis=1) % 2 == 1
    return result
