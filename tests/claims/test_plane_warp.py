"""Claims on plane warps of props with corners: frames, sliding lines, bounds, continuity."""

from dataclasses import replace

import numpy as np
import pytest

from touchwarp.goals import goals, outer_box
from touchwarp.scene import Fixed, Objective, Outer, Prop, Scene, Surface, TransformGoal
from touchwarp.solve.plane import PlaneSolver, encloses
from touchwarp.solve.plane_scene import place_plane_scene
from touchwarp.warp.plane_fit import fit_contact
from touchwarp.warp.plane_solver import solve_plane

CORNERS = np.array([[-0.05, 0.0], [0.05, 0.0], [0.06, 0.07], [-0.04, 0.05]])
SIDES = [[0, 1], [1, 2], [2, 3], [3, 0]]
ROOM = np.array([[-0.2, -0.15], [0.2, -0.15], [0.2, 0.2], [-0.2, 0.2]])
GOAL = np.array([[1.1, 0.2, 0.01], [-0.1, 0.9, -0.004], [0.0, 0.0, 1.0]])
TABLE_GOAL = np.array([[1.2, 0.1, 0.012], [0.0, 0.8, 0.0], [0.0, 0.0, 1.0]])


def rigid(angle_deg, shift):
    c, s = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    return np.array([[c, -s, shift[0]], [s, c, shift[1]], [0.0, 0.0, 1.0]])


def scene_at(T, goal=GOAL, fixed=(), tolerance_mm=0.1, mismatch_weight=1.0):
    prop = Surface(CORNERS, SIDES).transformed(T)
    return Scene(
        [Prop("block", prop, TransformGoal(matrix=T @ goal @ np.linalg.inv(T)))],
        Outer(surface=Surface(ROOM, SIDES).transformed(T)),
        Objective(mismatch_weight=mismatch_weight, tolerance_mm=tolerance_mm),
        fixed=fixed,
        dimension=2,
    )


def warp_of(scene):
    return solve_plane(scene, goals(scene))


def points_in_room(count=20_000):
    return np.random.default_rng(5).uniform(ROOM.min(axis=0), ROOM.max(axis=0), (count, 2))


def in_domain(x):
    """Outside the prop, and farther than the edge radius from its corners."""
    gap = np.linalg.norm(x[:, None] - CORNERS, axis=2).min(axis=1)
    return (gap > 2e-3) & ~encloses(CORNERS[np.array(SIDES)], x)


def mapped(T, x):
    return x @ T[:2, :2].T + T[:2, 2]


TURNED = rigid(37.0, (0.3, -0.2))


def difference_mm(first, second, T):
    """Greatest gap between a warp and one turned by T, at points of the room off the corners."""
    x = points_in_room()
    x = x[in_domain(x)]
    gap = mapped(T, first(x)) - second(mapped(T, x))
    return 1e3 * np.linalg.norm(gap, axis=1).max()


def test_turning_the_scene_turns_the_warp():
    assert difference_mm(warp_of(scene_at(np.eye(3))), warp_of(scene_at(TURNED)), TURNED) < 0.2


def test_turning_claim_rejects_a_goal_that_stays():
    stays = np.linalg.inv(TURNED) @ rigid(0.0, TURNED[:2, 2]) @ GOAL
    stays = stays @ rigid(0.0, -TURNED[:2, 2]) @ TURNED
    second = warp_of(scene_at(TURNED, goal=stays))
    assert difference_mm(warp_of(scene_at(np.eye(3))), second, TURNED) > 0.2


def test_carrying_the_warp_is_turning_the_scene():
    carried = warp_of(scene_at(np.eye(3))).at(TURNED)
    assert difference_mm(warp_of(scene_at(np.eye(3))), carried, TURNED) < 1e-9


def test_carrying_claim_rejects_the_warp_left_behind():
    warp = warp_of(scene_at(np.eye(3)))
    assert difference_mm(warp, warp, TURNED) > 0.2


TABLE = Fixed("table", plane=((0.0, 0.0), (0.0, 1.0)))
HELD = Fixed("table", plane=((0.0, 0.0), (0.0, 1.0)), contact="hold", blend_mm=0.0)


def mirrored_scene():
    """Prop and mirror image in one, in a room that is its own mirror image."""
    image = CORNERS * [1.0, -1.0]
    points = np.concatenate([CORNERS[1:], CORNERS[:1], image])[[0, 1, 2, 3, 7, 6]]
    prop = Surface(points, [[i, (i + 1) % 6] for i in range(6)])
    room = Surface([[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]], SIDES)
    return prop, room


def test_a_sliding_line_is_a_mirror():
    """Against a solve of prop and image together; the goal is mirrored too: no shear in x."""
    goal = np.array([[1.2, 0.0, 0.012], [0.0, 0.8, 0.0], [0.0, 0.0, 1.0]])
    both, room = mirrored_scene()
    objective = Objective(tolerance_mm=0.1)
    whole = Scene(
        [Prop("both", both, TransformGoal(matrix=goal))],
        Outer(surface=room),
        objective,
        dimension=2,
    )
    half = Scene(
        [Prop("block", Surface(CORNERS, SIDES), TransformGoal(matrix=goal))],
        Outer(surface=room),
        objective,
        fixed=[TABLE],
        dimension=2,
    )
    held = Scene(half.props, half.outer, objective, fixed=[HELD], dimension=2)
    x = points_in_room()
    x = x[in_domain(x) & (x[:, 1] > 0)]
    truth = warp_of(whole)(x)
    gaps = [1e3 * np.linalg.norm(warp_of(s)(x) - truth, axis=1).max() for s in (half, held)]
    assert gaps[0] < 0.2
    assert gaps[1] > 0.2  # the twin: a line that holds is no mirror


@pytest.mark.parametrize("angle_deg", [0.0, 90.0, 25.0])
def test_a_finger_on_the_table_stays_on_it(angle_deg):
    T = rigid(angle_deg, (0.1, 0.05))
    table = Fixed("table", plane=(T[:2, 2], T[:2, 1]))
    warp = warp_of(scene_at(T, TABLE_GOAL, [table]))
    on_table = np.stack([np.linspace(-0.19, 0.19, 400), np.zeros(400)], axis=1)
    shown = warp(mapped(T, on_table))
    assert np.abs((shown - T[:2, 2]) @ T[:2, 1]).max() < 1e-9
    assert np.abs(warp.displacement(mapped(T, on_table))).max() > 5e-3  # and it does slide


def test_table_claim_rejects_a_scene_without_the_table():
    warp = warp_of(scene_at(np.eye(3), TABLE_GOAL))
    on_table = np.stack([np.linspace(-0.19, 0.19, 400), np.zeros(400)], axis=1)
    assert np.abs(warp(on_table)[:, 1]).max() > 1e-4


def fields(scene):
    made = goals(scene)
    placed = place_plane_scene(scene, made, outer_box(scene, made))
    solved = PlaneSolver(placed.problem, 2e-3).solve()
    return placed, solved


@pytest.mark.parametrize("mismatch_weight", [0.0, 10.0])
def test_no_displacement_in_the_domain_exceeds_the_boundary_s(mismatch_weight):
    placed, solved = fields(scene_at(np.eye(3), mismatch_weight=mismatch_weight))
    most = np.linalg.norm(placed.problem.curves.displacement, axis=1).max()
    assert np.linalg.norm(solved.displacement, axis=2).max() <= most + 1e-12


def test_bound_claim_rejects_a_field_one_part_in_a_hundred_too_great():
    placed, solved = fields(scene_at(np.eye(3)))
    most = np.linalg.norm(placed.problem.curves.displacement, axis=1).max()
    # On the grid the bound is taken to within a cell of the farthest corner.
    assert np.linalg.norm(1.01 * solved.displacement, axis=2).max() > most + 1e-12


def test_the_warp_has_no_jumps():
    warp = warp_of(scene_at(np.eye(3)))
    rng = np.random.default_rng(11)
    x = points_in_room(20_000)
    for axis, lines in enumerate((warp.table.x_lines, warp.table.y_lines)):
        x[:, axis] = rng.choice(lines[1:-1], len(x))
        step = np.zeros(2)
        step[axis] = 1e-12
        inside = (np.abs(x - ROOM.mean(axis=0)) < 0.49 * np.ptp(ROOM, axis=0)).all(axis=1)
        jump = warp(x[inside] - step) - warp(x[inside] + step)
        assert np.abs(jump).max() < 1e-9


def test_jump_claim_rejects_a_table_with_one_node_torn():
    warp = warp_of(scene_at(np.eye(3)))
    x = warp.table.x_lines[40]
    y = np.linspace(-0.1, 0.15, 500)
    sides = [np.stack([np.full(500, x + step), y], axis=1) for step in (-1e-12, 1e-12)]
    torn = warp(sides[0]) - (warp(sides[1]) + np.array([2e-9, 0.0]))
    assert np.abs(torn).max() > 1e-9


def test_the_warp_is_linear_in_the_goal():
    placed, _ = fields(scene_at(np.eye(3)))
    solver = PlaneSolver(placed.problem, 2e-3)
    rng = np.random.default_rng(2)
    first, second = rng.normal(0.0, 0.01, (2, len(placed.problem.curves.points), 2))
    tables = []
    for data in (first, second, 2.0 * first - 0.5 * second):
        curves = replace(placed.problem.curves, displacement=data)
        tables.append(fit_contact(solver.solve(data), curves))
    assert np.abs(2.0 * tables[0] - 0.5 * tables[1] - tables[2]).max() < 1e-12


def test_linearity_claim_rejects_a_clipped_warp():
    _, solved = fields(scene_at(np.eye(3)))
    clipped = [np.clip(k * solved.displacement, -0.008, 0.008) for k in (1.0, 2.0)]
    assert np.abs(2.0 * clipped[0] - clipped[1]).max() > 1e-12
