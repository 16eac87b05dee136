import numpy as np
import pytest

from touchwarp.solve.plane_grid import (
    CORNER_DEPTH,
    PlaneFeatures,
    count_nodes,
    grade_grid,
)

BOX = np.array([[-0.5, -0.4], [0.6, 0.7]])
PROP = np.array([[[-0.05, -0.05], [0.05, 0.03]]])
NO_CORNERS = PlaneFeatures(PROP, np.empty((0, 2)), np.empty(0, np.int64))
CORNER = PlaneFeatures(PROP, np.array([[0.05, 0.03]]), np.zeros(1, np.int64))


@pytest.mark.parametrize("features", [NO_CORNERS, CORNER])
def test_lines_span_the_box_and_ascend(features):
    grid = grade_grid(BOX, features, 2e-3)
    for axis, lines in enumerate(grid.lines):
        assert lines[0] == BOX[0, axis]
        assert lines[-1] == BOX[1, axis]
        assert (np.diff(lines) > 0).all()
    assert count_nodes(BOX, features, 2e-3) == grid.shape[0] * grid.shape[1]


def test_spacing_is_as_asked_by_the_prop_and_wider_far_away():
    steps = np.diff(grade_grid(BOX, NO_CORNERS, 2e-3).x_lines)
    x = grade_grid(BOX, NO_CORNERS, 2e-3).x_lines[:-1]
    np.testing.assert_allclose(steps[np.abs(x) < 0.055], 2e-3, rtol=0.02)
    assert steps[0] > 5 * 2e-3
    assert (steps[1:] / steps[:-1] < 1.2).all()
    assert (steps[1:] / steps[:-1] > 1 / 1.2).all()


def test_spacing_shrinks_towards_a_corner():
    grid = grade_grid(BOX, CORNER, 2e-3)
    nearest = np.abs(grid.x_lines - 0.05).argmin()
    assert np.diff(grid.x_lines)[nearest] == pytest.approx(2e-3 / CORNER_DEPTH, rel=0.1)


def test_many_corners_do_not_multiply_the_grid():
    rng = np.random.default_rng(0)
    corners = rng.uniform(-0.05, 0.03, (200, 2))
    many = PlaneFeatures(PROP, corners, np.zeros(200, np.int64))
    assert count_nodes(BOX, many, 2e-3) < 20 * count_nodes(BOX, NO_CORNERS, 2e-3)


def test_halving_the_spacing_halves_every_step():
    coarse, fine = (grade_grid(BOX, CORNER, h) for h in (4e-3, 2e-3))
    cells = len(coarse.x_lines) - 1
    halved = np.interp(
        np.linspace(0, 1, cells + 1),
        np.linspace(0, 1, len(fine.x_lines)),
        fine.x_lines,
    )
    np.testing.assert_allclose(halved, coarse.x_lines, atol=2e-4)
