"""From a plane scene to its warp: the grid is refined until two grids agree to the tolerance."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from touchwarp.errors import SolveError
from touchwarp.goals import Goal, outer_box, validate
from touchwarp.scene import Scene, Surface
from touchwarp.solve.plane import BYTES_PER_NODE, PlaneField, PlaneSolver
from touchwarp.solve.plane_scene import PlaneScene, place_plane_scene
from touchwarp.warp.meta import Outline, WarpMeta
from touchwarp.warp.plane_fit import fit_contact
from touchwarp.warp.plane_table import PlaneTableWarp
from touchwarp.warp.plane_values import PlaneTable

Progress = Callable[[str, float], None]

FIRST_CELLS = 12
"""Cells along the smallest prop on the first, coarsest grid; no cell is longer than 1/√λ."""

SAFETY = 1.5
"""On the estimate: near the curves the error of neighbouring grids does not shrink evenly."""

STEP = (1.6, 3.0)
"""Least and greatest ratio of the spacings of two grids that are compared."""


@dataclass(frozen=True)
class PlaneSolution:
    """How a plane table was solved.

    Attributes:
        nodes: of the final grid.
        spacing: m, near the props.
        residual_history: greatest residual over the greatest datum, one for each grid solved; the
            factorisation is direct, so these are rounding errors.
        error_history: (spacing m, estimated error mm) of each pair of grids compared.
        estimated_error_max_mm: estimated greatest error of the table in Ω, farther than the edge
            radius from sharp corners and ends.
        estimated_error_rms_mm: the same, root mean square over the grid's nodes.
        estimated_edge_error_mm: estimated greatest error within the edge radius.
        contradiction_mm: greatest displacement that the goals ask for where a prop meets a fixed
            line that forbids it.
    """

    nodes: int
    spacing: float
    residual_history: tuple[float, ...]
    error_history: tuple[tuple[float, float], ...]
    estimated_error_max_mm: float
    estimated_error_rms_mm: float
    estimated_edge_error_mm: float
    contradiction_mm: float


def solve_plane(
    scene: Scene,
    goals: Mapping[str, Goal],
    tolerance_mm: float | None = None,
    progress: Progress | None = None,
    *,
    memory_limit_gb: float = 4.0,
) -> PlaneTableWarp:
    """The warp of a plane scene: Δu = λu with u = g − x on the props and 0 on ∂Ω1 (eq. 1, 2, 5).

    Args:
        scene: of dimension 2.
        goals: one for each prop.
        tolerance_mm: instead of the scene's own, mm.
        progress: called with the name of the step and the part that is done, 0…1.
        memory_limit_gb: how much the factorisation may take.
    Raises:
        SceneError: parts of the scene do not fit together.
        SolveError: the tolerance is out of the memory's reach, or not a number > 0.
    """
    tolerance = scene.objective.tolerance_mm if tolerance_mm is None else tolerance_mm
    if not (np.isfinite(tolerance) and tolerance > 0):
        raise SolveError(
            f"tolerance_mm is {tolerance}; a finite length in mm > 0 is needed, such as 0.1."
        )
    tell = progress or (lambda step, done: None)
    validate(scene, goals)
    box = outer_box(scene, goals)
    placed = place_plane_scene(scene, goals, box)
    problem = placed.problem
    affordable = memory_limit_gb * 1e9 / BYTES_PER_NODE
    spacing = float(problem.features.sizes.min())
    if problem.screening > 0:
        spacing = min(spacing, FIRST_CELLS / np.sqrt(problem.screening))
    spacing /= FIRST_CELLS
    _afford(problem.nodes_at(spacing / 2), affordable, tolerance, None)
    tell("solving", 0.0)
    field, table = _solve_at(placed, spacing)
    residuals, errors = [field.residual], []
    ratio = 2.0
    while True:
        spacing /= ratio
        finer, finer_table = _solve_at(placed, spacing)
        far, near = _differences(table, finer, placed, scene.objective.edge_radius_mm)
        shrinks = SAFETY / (ratio**2 - 1.0)
        greatest = 1e3 * shrinks * float(far.max(initial=0.0))
        residuals.append(finer.residual)
        errors.append((spacing, greatest))
        field, table = finer, finer_table
        if greatest <= tolerance:
            break
        ratio = float(np.clip(np.sqrt(greatest / (0.8 * tolerance)), *STEP))
        widest = np.sqrt(affordable / problem.nodes_at(spacing))
        if ratio > widest:  # the least that may do, if that fits
            ratio = max(1.02 * float(np.sqrt(greatest / tolerance)), 1.2)
            closest = greatest * field.reached.size / affordable
            _afford(problem.nodes_at(spacing / ratio), affordable, tolerance, closest)
        tell("solving", min(0.9, tolerance / greatest))
    solution = PlaneSolution(
        nodes=field.reached.size,
        spacing=spacing,
        residual_history=tuple(residuals),
        error_history=tuple(errors),
        estimated_error_max_mm=greatest,
        estimated_error_rms_mm=1e3 * shrinks * float(np.sqrt((far**2).mean())) if far.size else 0.0,
        # At a corner the solution goes as r^(2/3), and so does the error with the spacing.
        estimated_edge_error_mm=1e3 * float(near.max(initial=0.0)) / (ratio ** (2 / 3) - 1.0),
        contradiction_mm=placed.contradiction_mm,
    )
    tell("solving", 1.0)
    return PlaneTableWarp(table, _describe(scene, goals, box, tolerance, solution), solution)


def _afford(nodes: float, affordable: float, tolerance: float, closest: float | None) -> None:
    if nodes <= affordable:
        return
    cure = "raise memory_limit_gb or coarsen the scene's smallest prop"
    if closest is not None:
        cure = f"about {closest:.2g} mm fits; raise tolerance_mm or memory_limit_gb"
    raise SolveError(
        f"A tolerance of {tolerance:g} mm needs a plane grid of {nodes:.3g} nodes, "
        f"{nodes * BYTES_PER_NODE / 1e9:.2g} GB; memory_limit_gb allows "
        f"{affordable * BYTES_PER_NODE / 1e9:.2g} GB: {cure}."
    )


def _solve_at(placed: PlaneScene, spacing: float) -> tuple[PlaneField, PlaneTable]:
    field = PlaneSolver(placed.problem, spacing).solve()
    fitted = fit_contact(field, placed.problem.curves)
    if placed.problem.mirrored:
        fitted[:, 0, 1] = 0.0  # the fit only leaves nanometres here, but a hand rests on this line
    table = PlaneTable(
        placed.T_scene_table,
        field.grid.x_lines,
        field.grid.y_lines,
        fitted.astype(np.float32),
        placed.outer,
        placed.mirror_depth,
    )
    return field, table


def _differences(
    coarser: PlaneTable, finer: PlaneField, placed: PlaneScene, edge_radius_mm: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """|u_coarse table − u_fine| in m at the finer grid's nodes in Ω, far from corners and near."""
    local = finer.grid.nodes()[finer.reached.ravel()]
    scene_points = local @ placed.T_scene_table[:2, :2].T + placed.T_scene_table[:2, 2]
    shown = PlaneTableWarp(coarser, WarpMeta()).displacement(scene_points)
    solved = finer.displacement.reshape(-1, 2)[finer.reached.ravel()]
    gap = np.linalg.norm(shown @ placed.T_scene_table[:2, :2] - solved, axis=1)
    if len(placed.problem.features.corners) == 0:
        return gap, gap[:0]
    distance, _ = cKDTree(placed.problem.features.corners).query(local)
    near = distance <= 1e-3 * edge_radius_mm
    return gap[~near], gap[near]


def _describe(
    scene: Scene,
    goals: Mapping[str, Goal],
    box: NDArray[np.float64],
    tolerance: float,
    solution: PlaneSolution,
) -> WarpMeta:
    return WarpMeta(
        scene_text=scene.text,
        mesh_digests=scene.digests,
        outlines={
            name: Outline(
                Surface(goal.prop_points, goal.faces), Surface(goal.virtual_points, goal.faces)
            )
            for name, goal in goals.items()
        },
        outer_box=box,
        outer_surface=scene.outer.surface,
        screening=scene.objective.screening,
        tolerance_mm=tolerance,
        edge_radius_mm=scene.objective.edge_radius_mm,
        estimated_error_max_mm=solution.estimated_error_max_mm,
        estimated_error_rms_mm=solution.estimated_error_rms_mm,
        prop_names=tuple(prop.name for prop in scene.props),
        goals={name: goal.matrix for name, goal in goals.items() if goal.matrix is not None},
        T_room_scene=np.eye(3),
    )
