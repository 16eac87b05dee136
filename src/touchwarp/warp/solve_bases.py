"""`solve_bases`: the fields from which the warp of any affine goal follows without a solve."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import SolveError
from touchwarp.scene import Scene
from touchwarp.solve.adaptive import AdaptiveSolver
from touchwarp.solve.problem import Problem
from touchwarp.solve.settling import SETTLED
from touchwarp.solve.stencil import LANES
from touchwarp.warp.bases import AffineBases
from touchwarp.warp.meta import BasisProp
from touchwarp.warp.rounds import MOST_ROUNDS, Round, fit_round
from touchwarp.warp.solver import Progress, WarpSolver
from touchwarp.warp.table_error import TableError

RANGE_SHIFT = 0.1
RANGE_STRETCH = 1.0
"""The stated range of goals: a prop's centre moved by this many m, and ‖A − I‖."""

RANGE_TOLERANCE = 5.0
"""At the far end of the range, where displacements are several times those of a usual goal, the
error may be this many times the tolerance; it is linear in the goal."""

STRICTNESS = 1.2
"""The grid is grown for a tolerance that is smaller by this factor: several fields share it, and a
round for the last few points of one would solve all anew."""


def solve_bases(
    scene: Scene,
    *,
    tolerance_mm: float | None = None,
    memory_limit_gb: float = 4.0,
    progress: Progress | None = None,
) -> AffineBases:
    """Scalar fields per prop for the boundary data 1, x, y, z, on one grid.

    With a sliding plane each is solved twice: with no normal derivative on the plane, for the
    tangential components of u, and vanishing on it, for the normal one.

    Args:
        scene: as for `solve`; its goals do not matter.
        tolerance_mm: the scene's own without it; the far end of the range may have five times it.
        memory_limit_gb, progress: as for `solve`.

    Raises:
        SceneError, GoalError, SolveError: as for `solve`.
    """
    if scene.dimension != 3:
        raise SolveError(
            f"solve_bases was given a {scene.dimension}-D scene; instant goals are for scenes in "
            "space: solve a plane scene again instead."
        )
    whole = WarpSolver(
        scene, tolerance_mm=tolerance_mm, memory_limit_gb=memory_limit_gb, progress=progress
    )
    props = _scalings(whole.problem)
    _, rounds = basis_rounds(whole, progress or (lambda text, share: None))
    error = max((r.error for r in rounds), key=lambda e: e.outside_tube_max)
    bricks = rounds[-1].maker.bricks([r.fitted.values for r in rounds], LANES)
    meta = whole.meta(error).as_bases(
        props,
        RANGE_SHIFT,
        RANGE_STRETCH,
        whole.scene.objective.tolerance_mm * RANGE_TOLERANCE,
        error.outside_tube_max * RANGE_TOLERANCE * 1e3,
        error.outside_tube_rms * RANGE_TOLERANCE * 1e3,
    )
    return AffineBases(bricks, meta)


def basis_rounds(whole: WarpSolver, tell: Progress) -> tuple[AdaptiveSolver, list[Round]]:
    """The fields of each prop, with each condition on the sliding plane, and what solved them."""
    problem = whole.problem
    props = _scalings(problem)
    lane_scale = _lane_scale(props)
    none, all_ = np.zeros(LANES, bool), np.ones(LANES, bool)
    solver = whole.new_solver(STRICTNESS)
    solver.settled = SETTLED / 40
    together = np.sum([_basis_data(problem, name, props[name]) for name in props], axis=0)

    def build() -> None:
        solver.build(together, none, lane_scale)
        while solver.sharpen():
            solver.build(together, none, lane_scale)

    def refine(error: TableError) -> bool:
        return rounds_left > 0 and solver.demand(error.poor_points, error.poor_depths)

    build()
    solves = [
        (_basis_data(problem, name, props[name]), lanes)
        for lanes in ((none, all_) if problem.frame.mirrored else (none,))
        for name in props
    ]
    rounds: list[Round] = []
    rounds_left = MOST_ROUNDS - 1
    while len(rounds) < len(solves):
        tell("basis fields", 0.5 + 0.5 * len(rounds) / len(solves))
        data, lanes = solves[len(rounds)]
        solver.solve(data, lanes)
        maker = rounds[-1].maker if rounds else None
        found = fit_round(solver, maker, data, lanes, lane_scale, refine=refine, slack=STRICTNESS)
        if found is not None:
            rounds.append(found)
        else:
            # One grid for all fields: the finer one takes them from the start.
            rounds_left -= 1
            rounds.clear()
            build()
    return solver, rounds


def _lane_scale(props: dict[str, BasisProp]) -> NDArray[np.float32]:
    """(4,) what a unit of each field is in m, over what the error may exceed the tolerance by."""
    reach = max(prop.half_diagonal for prop in props.values())
    return np.array([RANGE_SHIFT, *[RANGE_STRETCH * reach] * 3], np.float32) / RANGE_TOLERANCE


def _scalings(problem: Problem) -> dict[str, BasisProp]:
    """Centre and half-diagonal of each prop's box along the table's axes."""
    result = {}
    for name, rows in problem.vertices.items():
        points = problem.boundary.corners[rows] * problem.frame.spacing
        low, high = points.min(axis=0), points.max(axis=0)
        centre = (low + high) / 2
        result[name] = BasisProp(
            (float(centre[0]), float(centre[1]), float(centre[2])),
            float(np.linalg.norm(high - low) / 2),
        )
    return result


def _basis_data(problem: Problem, name: str, prop: BasisProp) -> NDArray[np.float64]:
    """(v, 4): 1 and the scaled coordinates on one prop, 0 on all other surfaces."""
    data = np.zeros((len(problem.boundary.corners), LANES))
    rows = problem.vertices[name]
    points = problem.boundary.corners[rows] * problem.frame.spacing
    data[rows, 0] = 1.0
    data[rows, 1:] = (points - np.array(prop.centre)) / prop.half_diagonal
    return data
