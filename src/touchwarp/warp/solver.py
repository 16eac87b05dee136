"""`solve`: from a scene to its warp; `WarpSolver`: the same again and again."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import SceneError, SolveError
from touchwarp.goals import Goal, goals, validate
from touchwarp.scene import Scene, closest_props
from touchwarp.scene.goal_spec import GoalSpec, ReadyGoal
from touchwarp.solve.adaptive import MOST_CELLS_ACROSS_TUBE, AdaptiveSolver
from touchwarp.solve.problem import Problem, make_problem
from touchwarp.warp.from_solution import TableMaker
from touchwarp.warp.meta import Outline, WarpMeta
from touchwarp.warp.outline import outline_of, thinned
from touchwarp.warp.plane_solver import solve_plane
from touchwarp.warp.plane_table import PlaneTableWarp
from touchwarp.warp.record import SolveRecord
from touchwarp.warp.rounds import refine_rounds
from touchwarp.warp.table import TableWarp
from touchwarp.warp.table_error import TableError

Progress = Callable[[str, float], None]

COMPONENTS = 3
IN_METRES = np.array([1.0, 1.0, 1.0, 0.0], np.float32)
"""Lane scale of a displacement: three components in m, and an empty lane."""


def solve(
    scene: Scene,
    *,
    tolerance_mm: float | None = None,
    memory_limit_gb: float = 4.0,
    progress: Progress | None = None,
) -> TableWarp | PlaneTableWarp:
    """The warp of a scene: Δu = λu in Ω, u = g − x on the props, 0 on ∂Ω1 (eq. 1, 2, 5).

    Args:
        scene: what to solve.
        tolerance_mm: bound on the table's error; the scene's own without it.
        memory_limit_gb: no more memory than this is asked for.
        progress: called with what is being done and the share done, 0 to 1.

    Raises:
        SceneError, GoalError: the scene does not fit together.
        SolveError: the tolerance is out of memory's reach, or no convergence.
    """
    if scene.dimension == 2:
        if tolerance_mm is None:
            tolerance_mm = scene.objective.tolerance_mm
        own = goals(scene)
        return solve_plane(scene, own, tolerance_mm, progress, memory_limit_gb=memory_limit_gb)
    solver = WarpSolver(
        scene, tolerance_mm=tolerance_mm, memory_limit_gb=memory_limit_gb, progress=progress
    )
    return solver.solve()


class WarpSolver:
    """A scene prepared once and solved for many goals and mismatch weights.

    The first `solve` grows the grid. Later ones keep it, and grow it only where the estimated error
    asks for more. With `box_scale` they keep ∂Ω1 as well, while the virtual objects stay in its
    middle half.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        tolerance_mm: float | None = None,
        memory_limit_gb: float = 4.0,
        progress: Progress | None = None,
    ) -> None:
        """Check the scene and prepare its surfaces.

        Raises:
            SceneError, GoalError: the scene does not fit together.
            SolveError: a number is out of range, or the scene is not in space.
        """
        if scene.dimension != 3:
            raise SolveError(
                f"WarpSolver was given a {scene.dimension}-D scene; it solves scenes in space: "
                "use touchwarp.solve for a plane one."
            )
        if tolerance_mm is not None:
            scene = scene.with_objective(tolerance_mm=tolerance_mm)
        if not memory_limit_gb > 0.0:
            raise SolveError(f"memory_limit_gb is {memory_limit_gb}; a number > 0 is needed.")
        self.scene = scene
        self._memory_limit = memory_limit_gb * 1e9
        self._progress: Progress = progress or (lambda text, share: None)
        self._tell("reading the goals", 0.0)
        self.goals = goals(scene, self._tell)
        validate(scene, self.goals)
        _check_gaps(scene)
        self.problem: Problem = make_problem(scene, self.goals)
        self._solver: AdaptiveSolver | None = None
        self._maker: TableMaker | None = None
        self._outlines = _outlines(self.goals)

    def solve(
        self,
        changed_goals: Mapping[str, GoalSpec | ReadyGoal] | None = None,
        *,
        mismatch_weight: float | None = None,
        progress: Progress | None = None,
    ) -> TableWarp:
        """The warp for the scene's goals, or for others on the same surfaces.

        Args:
            changed_goals: by prop; their prop points must be the scene's own.
            mismatch_weight: λ; the scene's, or the last one, without it.
            progress: called from now on, in place of the one before.

        Raises:
            GoalError: a goal is not on its prop's own points.
            SolveError: the tolerance is out of memory's reach, or no convergence.
        """
        if progress is not None:
            self._progress = progress
        if mismatch_weight is not None:
            self.scene = self.scene.with_objective(mismatch_weight=mismatch_weight)
            screening = self.scene.objective.screening
            self.problem = dataclasses.replace(self.problem, screening=screening)
        if changed_goals:
            self.scene = self.scene.with_goals(changed_goals)
            self.goals = goals(self.scene, self._tell)
            validate(self.scene, self.goals)
            self._outlines = _outlines(self.goals)
            problem = make_problem(self.scene, self.goals, self._kept_box())
            if not _same_surfaces(problem, self.problem):
                self._solver = None
            self.problem = problem
        data = self.problem.goal_data(self.goals)
        lanes = self.problem.normal_lanes
        if self._solver is None:
            self._solver = self.new_solver()
            self._solver.build(data, lanes, IN_METRES)
        else:
            self._solver.multigrid.set_screening(self.problem.screening)
            self._solver.solve(data, lanes)
        last = refine_rounds(self._solver, self._maker, data, lanes, IN_METRES, self._tell)
        self._maker = last.maker
        bricks = last.maker.bricks([last.fitted.values], COMPONENTS)
        self._tell("done", 1.0)
        return TableWarp(bricks, self.meta(last.error), SolveRecord.of(last.solution, last.error))

    def _tell(self, step: str, share: float) -> None:
        """What is handed on to others, so that they tell whoever is to be told now."""
        self._progress(step, share)

    def _kept_box(self) -> NDArray[np.float64] | None:
        """∂Ω1 of the solves before, where `box_scale` would give each goal a box of its own.

        None where it is given, or where the virtual objects have left the box's middle half.
        """
        if self.scene.outer.box_scale is None:
            return None
        box = self.problem.outer_box
        points = np.concatenate([goal.virtual_points for goal in self.goals.values()])
        quarter = (box[1] - box[0]) / 4
        inside = (points >= box[0] + quarter) & (points <= box[1] - quarter)
        return box if inside.all() else None

    def new_solver(self, strictness: float = 1.0) -> AdaptiveSolver:
        """A solver with the root levels only, for the tolerance over `strictness`."""
        objective = self.scene.objective
        return AdaptiveSolver(
            self.problem,
            objective.tolerance_mm * 1e-3 / strictness,
            objective.edge_radius_mm * 1e-3,
            self._memory_limit,
            self._tell,
        )

    def meta(self, error: TableError) -> WarpMeta:
        """What a warp of this scene says of itself."""
        outer = self.scene.outer.surface
        objective = self.scene.objective
        affine = {n: g.matrix for n, g in self.goals.items() if g.matrix is not None}
        return WarpMeta(
            scene_text=self.scene.text,
            mesh_digests=self.scene.digests,
            outlines=self._outlines,
            outer_box=self.problem.outer_box,
            outer_surface=None if outer is None else thinned(outer),
            screening=self.problem.screening,
            tolerance_mm=objective.tolerance_mm,
            edge_radius_mm=objective.edge_radius_mm,
            estimated_error_max_mm=error.outside_tube_max * 1e3,
            estimated_error_rms_mm=error.outside_tube_rms * 1e3,
            prop_names=tuple(prop.name for prop in self.scene.props),
            goals=affine,
        )


def _outlines(own: Mapping[str, Goal]) -> dict[str, Outline]:
    return {name: outline_of(goal) for name, goal in own.items()}


def _check_gaps(scene: Scene) -> None:
    """Raise SceneError where two props are less than two of the finest cells apart."""
    least = 2.0 * scene.objective.edge_radius_mm * 1e-3 / MOST_CELLS_ACROSS_TUBE
    closest = closest_props(scene, limit=least)
    if closest is not None:
        raise SceneError(
            f"props '{closest[0]}' and '{closest[1]}' are {closest[2] * 1e3:.2g} mm apart, less "
            f"than two of the finest cells ({least * 1e3:.2g} mm): move one by its pose, join them "
            "to one mesh, or make one [[fixed]]."
        )


def _same_surfaces(a: Problem, b: Problem) -> bool:
    """Whether two problems differ in their data only."""
    return (
        a.boundary.corners.shape == b.boundary.corners.shape
        and np.array_equal(a.frame.T_scene_table, b.frame.T_scene_table)
        and np.array_equal(a.frame.spacing, b.frame.spacing)
        and np.array_equal(a.boundary.corners, b.boundary.corners)
        and np.array_equal(a.boundary.faces, b.boundary.faces)
    )
