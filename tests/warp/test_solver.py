"""A solver used again keeps its grid and its ∂Ω1; bases state the error of their whole range."""

import dataclasses

import numpy as np
import pytest

import touchwarp as tw
from touchwarp.errors import SolveError
from touchwarp.scene import Outer, shapes
from touchwarp.warp.solve_bases import RANGE_TOLERANCE

TOLERANCE_MM = 1.0
WIDER = tw.TransformGoal(pivot="centre", scale=(1.2, 1.0, 1.0))
MOVED = tw.TransformGoal(pivot="centre", translation=(0.02, 0.0, 0.0))
FAR = tw.TransformGoal(pivot="centre", translation=(0.12, 0.0, 0.0))


def ball_scene(goal, outer=None):
    ball = tw.Prop("ball", shapes.sphere(0.04), goal)
    return tw.Scene([ball], outer or Outer(box_scale=4.0), tw.Objective(tolerance_mm=TOLERANCE_MM))


@pytest.fixture(scope="module")
def solver():
    solver = tw.WarpSolver(ball_scene(WIDER))
    solver.solve()
    return solver


def test_a_changed_goal_keeps_grid_and_outer_box(solver):
    box = solver.problem.outer_box
    grid = [stage.level for stage in solver._solver.multigrid.stages]
    again = solver.solve({"ball": MOVED})
    np.testing.assert_array_equal(again.outer_box, box)
    assert [stage.level for stage in solver._solver.multigrid.stages][: len(grid)] == grid
    fresh = tw.solve(ball_scene(MOVED, Outer(box=box)))
    x = np.random.default_rng(0).uniform(-0.08, 0.08, (20_000, 3))
    x = x[np.linalg.norm(x, axis=1) > 0.041]
    gap = 1e3 * np.linalg.norm(again(x) - fresh(x), axis=1).max()
    assert gap <= 2 * TOLERANCE_MM
    report = tw.check(ball_scene(MOVED), again, samples=1000)  # of the prop; it is ∂Ω1 that counts
    assert {c.status for c in report.checks if c.name.startswith("identity")} == {"pass"}


def test_a_goal_that_leaves_the_middle_of_the_box_gets_its_own(solver):
    box = solver.problem.outer_box
    far = solver.solve({"ball": FAR})
    assert (far.outer_box[1] - far.outer_box[0] > (box[1] - box[0])).all()


def test_bases_state_the_error_at_the_far_end_of_their_range():
    scene = ball_scene(WIDER)
    bases = tw.solve_bases(scene)
    stated = bases.error_bound_mm({"ball": np.eye(4)})
    assert stated is not None
    assert 0.2 * TOLERANCE_MM < stated <= RANGE_TOLERANCE * TOLERANCE_MM * 1.05
    fixed = dataclasses.replace(scene, outer=Outer(box=bases.meta.outer_box))
    matrix = tw.goals(fixed)["ball"].matrix
    fresh, table = tw.solve(fixed), bases.table({"ball": matrix})
    x = np.random.default_rng(0).uniform(-0.08, 0.08, (20_000, 3))
    x = x[np.linalg.norm(x, axis=1) > 0.041]
    assert 1e3 * np.linalg.norm(fresh(x) - table(x), axis=1).max() <= 2 * TOLERANCE_MM


def test_bases_keep_to_the_memory_allowed():
    with pytest.raises(SolveError, match=r"over the limit of 0\.1 GB"):
        tw.solve_bases(ball_scene(WIDER), tolerance_mm=1e-3, memory_limit_gb=0.1)


def test_each_solve_tells_its_own_progress_also_of_a_grid_that_grows():
    before, after = [], []
    slight = tw.TransformGoal(pivot="centre", translation=(0.001, 0.0, 0.0))
    ball = tw.Prop("ball", shapes.sphere(0.04), slight)
    scene = tw.Scene([ball], Outer(box_scale=4.0), tw.Objective(tolerance_mm=0.5))
    solver = tw.WarpSolver(scene, progress=lambda step, share: before.append(step))
    solver.solve()
    nodes = solver._solver.nodes
    assert before[-1] == "done"
    before.clear()
    stretched = tw.TransformGoal(pivot="centre", scale=(1.5, 0.7, 1.0))
    solver.solve({"ball": stretched}, progress=lambda step, share: after.append(step))
    assert solver._solver.nodes > nodes
    assert before == []
    assert any(step.endswith(" nodes") for step in after)
    assert after[-1] == "done"
