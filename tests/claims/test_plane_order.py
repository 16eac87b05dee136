"""Claim: the plane solver is second order, on any outline and at any cut of its edges."""

import numpy as np
import pytest
from scipy.special import kn

from tests.exact import circles
from tests.exact.order import observed_order
from touchwarp.solve.plane import PlaneProblem, PlaneSolver
from touchwarp.solve.plane_cuts import Curves
from touchwarp.solve.plane_grid import PlaneFeatures
from touchwarp.solve.plane_scene import find_corners
from touchwarp.warp.meta import WarpMeta
from touchwarp.warp.plane_fit import fit_contact
from touchwarp.warp.plane_table import PlaneTableWarp
from touchwarp.warp.plane_values import PlaneTable

SOURCE = np.array([0.004, -0.007])
SPACINGS = np.array([5e-3, 3.5e-3, 2.5e-3, 1.75e-3, 1.25e-3])


def field(x, screening):
    """A screened source, and the x derivative of one: (n, 2) m, exact away from SOURCE."""
    r = np.linalg.norm(x - SOURCE, axis=1)
    along = (x - SOURCE)[:, 0] / r
    if screening == 0:
        return np.stack([0.01 * np.log(0.2 / r), 5e-4 * along / r], axis=1)
    s = np.sqrt(screening)
    return np.stack([0.01 * kn(0, s * r), 5e-4 * along * s * kn(1, s * r)], axis=1)


def rounded(kind):
    """The prop's outline: points (n, 2) m and segments."""
    if kind == "circle":
        return circles.outline((0.0013, 0.0021), 0.05, 4000)
    corners = 0.05 * np.array([[-1.0, -0.7], [1.0, -0.7], [1.0, 0.7], [-1.0, 0.7]])
    turn = np.radians({"square": 0.0, "turned square": 23.0}[kind])
    corners = corners @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    along = np.arange(1000)[:, None] / 1000
    sides = [a + along * (b - a) for a, b in zip(corners, np.roll(corners, -1, 0), strict=True)]
    number = np.arange(4000)
    return np.concatenate(sides), np.stack([number, (number + 1) % 4000], axis=1)


def problem_of(kind, screening, wall_shift=0.0):
    points, segments = rounded(kind)
    outer_points, outer_segments = circles.outline((0.003, -0.002), 0.14, 4000)
    data = np.concatenate([field(points, screening), field(outer_points, screening)])
    corners = find_corners(points, segments)
    return PlaneProblem(
        box=np.array([[-0.15, -0.15], [0.15, 0.15]]),
        features=PlaneFeatures(
            np.array([[points.min(axis=0), points.max(axis=0)]]),
            corners,
            np.zeros(len(corners), dtype=np.int64),
        ),
        curves=Curves(
            np.concatenate([points + np.array([wall_shift, 0.0]), outer_points]),
            np.concatenate([segments, outer_segments + len(points)]),
            data,
        ),
        outer=np.arange(len(segments), len(segments) + len(outer_segments)),
        screening=screening,
    )


def rms_error(kind, screening, spacing, wall_shift=0, fitted=False):
    """Root mean square error, m: at the nodes in Ω or, fitted, of the table between circles."""
    problem = problem_of(kind, screening, wall_shift * spacing)
    solved = PlaneSolver(problem, spacing).solve()
    if fitted:
        values = fit_contact(solved, problem.curves)
        lines = solved.grid.x_lines, solved.grid.y_lines
        warp = PlaneTableWarp(
            PlaneTable(np.eye(3), *lines, values, np.empty((0, 2, 2))), WarpMeta()
        )
        rng = np.random.default_rng(3)
        x = circles.points_between(rng, 50_000, (0.0013, 0.0021), 0.0501, 0.13)
        gap = warp.displacement(x) - field(x, screening)
    else:
        x = solved.grid.nodes()[solved.reached.ravel()]
        gap = solved.displacement[solved.reached] - field(x, screening)
    return np.sqrt((gap**2).sum(axis=1).mean())


KINDS = ("circle", "square", "turned square")


@pytest.mark.parametrize("screening", [0.0, 100.0])
@pytest.mark.parametrize("kind", KINDS)
def test_the_solution_is_second_order_against_a_source_inside_the_prop(kind, screening):
    errors = [rms_error(kind, screening, spacing) for spacing in SPACINGS]
    assert observed_order(SPACINGS, errors) == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize("kind", KINDS)
def test_order_claim_rejects_a_wall_one_node_off(kind):
    errors = [rms_error(kind, 0.0, spacing, wall_shift=1) for spacing in SPACINGS]
    assert observed_order(SPACINGS, errors) < 1.5


def test_the_fitted_table_is_at_least_second_order():
    """More than 2 is seen because the cells that the fit moves are ever fewer."""
    errors = [rms_error("circle", 0.0, spacing, fitted=True) for spacing in SPACINGS]
    assert observed_order(SPACINGS, errors) > 1.85


def test_table_order_claim_rejects_a_wall_one_node_off():
    errors = [rms_error("circle", 0.0, h, wall_shift=1, fitted=True) for h in SPACINGS]
    assert observed_order(SPACINGS, errors) < 1.5
