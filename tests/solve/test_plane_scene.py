import numpy as np
import pytest

from touchwarp.errors import SolveError
from touchwarp.goals import goals, outer_box
from touchwarp.scene import Fixed, Objective, Outer, Prop, Scene, Surface, TransformGoal
from touchwarp.solve.plane import PlaneSolver
from touchwarp.solve.plane_scene import find_corners, place_plane_scene

SQUARE = Surface(
    [[-0.05, 0], [0.05, 0], [0.05, 0.1], [-0.05, 0.1]], [[0, 1], [1, 2], [2, 3], [3, 0]]
)


def place(*, fixed=(), goal=None, outer=None):
    scene = Scene(
        [Prop("block", SQUARE, goal or TransformGoal(translation=(0.01, 0.004)))],
        outer or Outer(),
        fixed=fixed,
        dimension=2,
    )
    made = goals(scene)
    return place_plane_scene(scene, made, outer_box(scene, made))


def test_corners_are_found_and_flat_vertices_are_not():
    points = np.array([[0, 0], [0.5, 0], [1, 0], [1, 1], [0.5, 1.02], [0, 1]], dtype=float)
    number = np.arange(6)
    corners = find_corners(points, np.stack([number, (number + 1) % 6], axis=1))
    assert sorted(map(tuple, corners.tolist())) == [(0, 0), (0, 1), (1, 0), (1, 1)]


def test_loose_ends_and_branchings_are_corners():
    points = np.array([[0, 0], [1, 0], [2, 0], [1, 1]], dtype=float)
    assert len(find_corners(points, np.array([[0, 1], [1, 2]]))) == 2
    assert len(find_corners(points, np.array([[0, 1], [1, 2], [1, 3]]))) == 4


def test_a_box_turned_by_a_sliding_line_becomes_a_polygon():
    upright = Fixed("table", plane=((0, 0), (0, 1)))
    slanted = Fixed("table", plane=((0, -0.05), (0.2, 1)))
    assert len(place(fixed=[upright]).outer) == 0
    assert len(place(fixed=[slanted]).outer) == 4


def test_a_goal_that_lifts_a_prop_off_its_table_bends_to_it():
    table = Fixed("table", plane=((0, 0), (0, 1)), blend_mm=10)
    placed = place(fixed=[table])
    assert placed.contradiction_mm == pytest.approx(4.0)
    curves = placed.problem.curves
    on_table = curves.points[:, 1] == 0.0
    above = curves.points[:, 1] >= 0.010
    assert on_table.any()
    np.testing.assert_allclose(curves.displacement[on_table], [[0.01, 0.0]] * on_table.sum())
    np.testing.assert_allclose(curves.displacement[above], [[0.01, 0.004]] * above.sum())


def test_a_goal_that_agrees_with_the_table_is_kept_as_it_is():
    table = Fixed("table", plane=((0, 0), (0, 1)))
    placed = place(fixed=[table], goal=TransformGoal(pivot="base", scale=[1.2, 0.7]))
    assert placed.contradiction_mm == 0.0
    assert len(placed.problem.curves.points) == 4


def test_a_held_line_forbids_all_displacement():
    table = Fixed("table", plane=((0, 0), (0, 1)), contact="hold")
    assert place(fixed=[table]).contradiction_mm == pytest.approx(np.hypot(10, 4))


def displacement_beside_the_block(fixed):
    solved = PlaneSolver(place(fixed=fixed).problem, 2e-3).solve()
    i, j = (np.abs(a - b).argmin() for a, b in zip(solved.grid.lines, (0.08, 0.05), strict=True))
    return np.abs(solved.displacement[i, j]).max()


def test_a_held_outline_is_not_displaced():
    bar = Surface([[0.08, 0.0], [0.08, 0.1]], [[0, 1]])
    assert displacement_beside_the_block([Fixed("bar", surface=bar)]) < 5e-4


def test_held_outline_claim_rejects_a_scene_without_it():
    assert displacement_beside_the_block([]) > 5e-4


def test_a_space_scene_is_refused():
    box = Surface([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [[0, 1, 2]])
    scene = Scene([Prop("sheet", box)])
    with pytest.raises(SolveError, match="dimension 3; the plane solver needs 2"):
        place_plane_scene(scene, {}, np.zeros((2, 2)))


def test_a_table_turned_upside_down_is_refused():
    with pytest.raises(SolveError, match="turn the normal round"):
        place(fixed=[Fixed("table", plane=((0, 0.1), (0, 1)))])


@pytest.mark.filterwarnings("ignore:overflow", "ignore:invalid")
def test_numbers_that_overflow_are_refused():
    solver = PlaneSolver(place().problem, 5e-3)
    with pytest.raises(SolveError, match="check the unit of the props"):
        solver.solve(np.full((4, 2), np.inf))


def test_objective_reaches_the_problem():
    scene = Scene([Prop("block", SQUARE)], objective=Objective(mismatch_weight=2.0), dimension=2)
    made = goals(scene)
    assert place_plane_scene(
        scene, made, outer_box(scene, made)
    ).problem.screening == pytest.approx(200.0)
