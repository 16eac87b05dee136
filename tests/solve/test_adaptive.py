"""A grid made finer keeps its cells and their values, and is judged by what a table sees."""

import numpy as np
import pytest

import touchwarp as tw
from touchwarp.scene import shapes
from touchwarp.solve.marking import BEYOND
from touchwarp.warp.solver import IN_METRES, WarpSolver

TOLERANCE_MM = 0.2
GOAL = tw.TransformGoal(pivot="centre", scale=(1.4, 1.0, 1.0))
NO_LANES = np.zeros(4, bool)


@pytest.fixture
def prepared():
    surface = shapes.box([0.08, 0.06, 0.05])
    objective = tw.Objective(tolerance_mm=TOLERANCE_MM, edge_radius_mm=4.0)
    whole = WarpSolver(tw.Scene([tw.Prop("box", surface, GOAL)], tw.Outer(), objective))
    data = whole.problem.goal_data(whole.goals)
    solver = whole.new_solver()
    solver.build(data, NO_LANES, IN_METRES)
    return solver, data


def cells_of(solver):
    """The bricks with cells, (depth, x, y, z)."""
    return {
        (stage.level.depth, *brick)
        for stage in solver.multigrid.stages
        for brick in stage.level.bricks[stage.level.has_cells].tolist()
    }


def demand_all_about_a_corner(solver):
    grid = solver.multigrid
    depth = grid.stages[-1].level.depth - 1
    corner = solver.problem.boundary.corners[:1]
    points = corner + np.random.default_rng(0).uniform(-0.5, 0.5, (50, 3)) / 2.0**depth
    assert solver.demand(points, np.full(len(points), depth))


def test_a_demand_adds_cells_and_takes_none_away(prepared):
    solver, data = prepared
    before = cells_of(solver)
    demand_all_about_a_corner(solver)
    solver.build(data, NO_LANES, IN_METRES)
    assert before < cells_of(solver)


def test_levels_that_come_again_start_from_their_solution(prepared, monkeypatch):
    solver, data = prepared
    grid = solver.multigrid
    before = {s.level.depth: (s.level, s.u.copy()) for s in grid.stages[grid.root + 1 :]}
    demand_all_about_a_corner(solver)
    cycles = []
    cycle = grid.cycle
    monkeypatch.setattr(grid, "cycle", lambda *level: cycles.append(level) or cycle(*level))
    monkeypatch.setattr(grid, "smooth", lambda *_: None)
    monkeypatch.setattr(solver, "settle", lambda: None)
    solver.build(data, NO_LANES, IN_METRES)
    # nothing has cycled or smoothed them, so that they are what they were
    deeper = grid.stages[-1].level.depth - max(before)
    assert len(cycles) == deeper
    for stage in grid.stages[grid.root + 1 :]:
        if stage.level.depth in before:
            level, u = before[stage.level.depth]
            x, inner = level.coordinates(), slice(level.n_inner)
            there = stage.level.index_of(x[inner] // 8)
            local = x[inner] % 8 @ np.array([64, 8, 1])
            np.testing.assert_array_equal(stage.u[stage.level.node[there, local]], u[inner])


def test_levels_that_come_again_for_other_data_have_those(prepared):
    solver, data = prepared
    demand_all_about_a_corner(solver)
    other = data[:, [1, 2, 0, 3]] + np.array([0.01, 0.0, 0.0, 0.0])
    solver.build(other, NO_LANES, IN_METRES)
    grid = solver.multigrid
    for i, stage in enumerate(grid.stages):
        has = stage.cut_values.copy()
        grid.set_stage_goal(i, other, solver._yielding[i])
        np.testing.assert_array_equal(has, stage.cut_values)
    settled = grid.stages[-1].u.copy()
    for _ in range(5):
        grid.cycle()
    assert np.abs(grid.stages[-1].u - settled).max() < 0.1e-3 * TOLERANCE_MM


@pytest.mark.parametrize("where_seen", [False, True])
def test_edges_are_refined_for_errors_that_a_table_has_alone(prepared, where_seen):
    solver, _ = prepared
    grid = solver.multigrid
    solver._errors = [np.zeros(stage.level.n, np.float32) for stage in grid.stages]
    for i, stage in enumerate(grid.stages):
        in_space = solver.regions[i] == 1
        outside = ~solver.tube.contains(
            solver.problem.frame.to_scene(stage.level.coordinates() / 2.0**stage.level.depth)
        )
        wanted = in_space & outside & (grid.covered(i) != where_seen)
        solver._errors[i][wanted] = 10.0 * solver.tolerance
    assert solver.sharpen() == where_seen


@pytest.mark.parametrize(
    ("place_mm", "finer"), [((41.0, 0.0, 0.0), True), ((41.0, 30.0, 25.0), False)]
)
def test_cells_of_the_least_size_at_edges_are_refined_away_from_them(prepared, place_mm, finer):
    solver, _ = prepared
    points = solver.problem.frame.to_grid(1e-3 * np.array([place_mm]))
    assert solver.demand(points, np.array([solver.marker.deepest])) == finer


@pytest.mark.parametrize(("count", "more"), [(1, True), (5000, False)])
def test_levels_beyond_the_last_are_made_where_they_are_small(prepared, count, more):
    solver, data = prepared
    marker, finest = solver.marker, solver.multigrid.stages[-1]
    depth = finest.level.depth
    marker.deepest, marker.limit = depth - BEYOND, depth + 1
    cells = finest.level.bricks[finest.level.has_cells] * 8.0 + 2.0
    points = np.resize(cells, (count, 3)) / 2.0**depth
    marker.demand(points, np.full(count, depth))
    given = finest, solver.regions[-1], data, NO_LANES, IN_METRES
    marked, _ = marker.marks(*given, solver.tube, solver.nodes)
    assert marked.any() == more
    assert (marker.limit > depth) == more
    assert marker.capped or more
