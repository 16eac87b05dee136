"""What moved nodes and interpolation miss together in a cell, and which nodes are judged."""

from itertools import combinations

import numpy as np
import pytest

import touchwarp as tw
from touchwarp.scene import Outer, shapes
from touchwarp.solve.refine import octant_of
from touchwarp.warp.table_error import greatest_between
from touchwarp.warp.table_grid import TableGrid

CORNERS = np.stack(np.meshgrid(*[[0, 1]] * 3, indexing="ij"), axis=-1).reshape(8, 3)
EDGES = [(i, j) for i, j in combinations(range(8), 2) if abs(CORNERS[i] - CORNERS[j]).sum() == 1]
SUBSETS = [list(s) for n in (1, 2, 3) for s in combinations(range(3), n)]


def random_cell(seed):
    """How far the corners were moved, what interpolation misses at most, and the sum's greatest."""
    rng = np.random.default_rng(seed)
    moves = rng.uniform(0.0, 1.0, 8) * rng.integers(0, 2, 8)
    bends = rng.normal(size=(3, 3)) * rng.uniform(0.0, 4.0)
    interpolation = max(np.linalg.norm(bends[s].sum(axis=0)) for s in SUBSETS) / 8
    t = np.stack(np.meshgrid(*[np.linspace(0, 1, 21)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    weights = np.prod(np.where(CORNERS, t[:, None], 1 - t[:, None]), axis=2)
    missed = np.linalg.norm((4 * t * (1 - t)) @ bends, axis=1) / 8
    return moves, interpolation, (weights @ moves + missed).max()


@pytest.mark.parametrize("seed", range(40))
def test_the_sum_in_a_cell_is_greatest_on_an_edge(seed):
    moves, interpolation, greatest = random_cell(seed)
    bound = max(greatest_between(moves[i], moves[j], interpolation) for i, j in EDGES)
    assert greatest <= bound + 1e-12
    assert bound <= moves.max() + interpolation + 1e-12


def test_neither_part_alone_bounds_the_sum():
    cells = [random_cell(seed) for seed in range(40)]
    assert any(greatest > max(*moves, part) + 0.05 for moves, part, greatest in cells)


@pytest.mark.parametrize(("a", "b", "bend"), [(0.4, 0.0, 0.1), (0.3, 0.2, 0.5), (0.0, 0.0, 0.1)])
def test_the_sum_along_an_edge_is_that_of_all_places_on_it(a, b, bend):
    t = np.linspace(0.0, 1.0, 100_001)
    along = (1 - t) * a + t * b + 4 * t * (1 - t) * bend
    assert greatest_between(a, b, bend) == pytest.approx(along.max(), abs=1e-9)


@pytest.fixture(scope="module")
def grid():
    """The table's grid of a ball, and its solution."""
    goal = tw.TransformGoal(pivot="centre", scale=(1.2, 1.0, 1.0))
    ball = tw.Prop("ball", shapes.sphere(0.04), goal)
    scene = tw.Scene([ball], Outer(box_scale=4.0), tw.Objective(tolerance_mm=0.2))
    solver = tw.WarpSolver(scene)
    solver.solve()
    solution = solver._solver.solution(0.0)
    return TableGrid.of(solution), solution


def places(level, nodes):
    return {tuple(c) for c in level.coordinates(nodes).tolist()}


def corners_of_leaves(level, leaf):
    """Coordinates of all nodes of the leaf octants (b, 8), faces included."""
    brick, octant = np.nonzero(leaf)
    low = 8 * level.bricks[brick] + 4 * CORNERS[octant]
    steps = np.stack(np.meshgrid(*[np.arange(5)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    return {tuple(c) for c in (low[:, None] + steps).reshape(-1, 3).tolist()}


def test_the_nodes_judged_are_all_nodes_in_space_of_the_leaf_cells(grid):
    table, solution = grid
    for stage, leaf, region, own in zip(
        table.stages, table.leaf, solution.regions, table.own, strict=True
    ):
        in_space = places(stage.level, np.flatnonzero(region == 1))
        assert places(stage.level, own) == corners_of_leaves(stage.level, leaf) & in_space


def test_a_nodes_own_octant_would_leave_out_those_that_hang_on_upper_faces(grid):
    table, _ = grid
    left_out = 0
    for stage, leaf, own, rim in zip(table.stages, table.leaf, table.own, table.rim, strict=True):
        brick, local = np.divmod(stage.level.site[own], 512)
        left_out += len(np.intersect1d(own[~leaf[brick, octant_of(local)]], rim))
    assert left_out > 100
