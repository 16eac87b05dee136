"""Claim: between concentric circles a plane warp keeps its tolerance at every point of Ω, and its
own estimate tells its error."""

from functools import cache

import numpy as np
import pytest

from tests.exact import circles as exact
from touchwarp.goals import goals, outer_box
from touchwarp.scene import Objective, Outer, Prop, Scene, Surface, TransformGoal
from touchwarp.solve.plane import PlaneSolver
from touchwarp.solve.plane_scene import place_plane_scene
from touchwarp.warp.plane_solver import solve_plane
from touchwarp.warp.plane_table import PlaneTableWarp
from touchwarp.warp.plane_values import PlaneTable

CENTRE, INNER, OUTER, MOVED = (0.0012, 0.0023), 0.05, 0.18, (0.02, -0.01)
CASES = [(w, t) for w in (0.0, 1.0, 100.0) for t in (0.5, 0.1, 0.02)]


@cache
def scene(mismatch_weight, tolerance_mm):
    return Scene(
        [Prop("disc", Surface(*exact.outline(CENTRE, INNER)), TransformGoal(translation=MOVED))],
        Outer(surface=Surface(*exact.outline(CENTRE, OUTER))),
        Objective(mismatch_weight=mismatch_weight, tolerance_mm=tolerance_mm),
        dimension=2,
    )


@cache
def warp_of(mismatch_weight, tolerance_mm):
    asked = scene(mismatch_weight, tolerance_mm)
    return solve_plane(asked, goals(asked))


def without_fit(warp, mismatch_weight, tolerance_mm):
    """The same grid's solution, as a table that is not fitted to the contact."""
    asked = scene(mismatch_weight, tolerance_mm)
    made = goals(asked)
    problem = place_plane_scene(asked, made, outer_box(asked, made)).problem
    field = PlaneSolver(problem, warp.solution.spacing).solve()
    bare = PlaneTable(
        warp.table.T_scene_table,
        field.grid.x_lines,
        field.grid.y_lines,
        field.displacement.astype(np.float32),
        warp.table.outer,
    )
    return PlaneTableWarp(bare, warp.meta)


def errors_mm(warp, mismatch_weight):
    """At 200,000 points between the circles."""
    x = exact.points_between(np.random.default_rng(7), 200_000, CENTRE, INNER, OUTER)
    screening = scene(mismatch_weight, 0.1).objective.screening
    truth = exact.displacement(x, CENTRE, INNER, OUTER, MOVED, screening)
    return 1e3 * np.linalg.norm(warp.displacement(x) - truth, axis=1)


def contact_errors_mm(warp):
    """At 100,000 points of the inner outline."""
    rng = np.random.default_rng(8)
    points, segments = exact.outline(CENTRE, INNER)
    start, stop = (points[segments[rng.integers(0, len(segments), 100_000)]]).transpose(1, 0, 2)
    x = start + rng.uniform(size=(len(start), 1)) * (stop - start)
    return 1e3 * np.linalg.norm(warp.displacement(x) - MOVED, axis=1)


@pytest.mark.parametrize(("mismatch_weight", "tolerance_mm"), CASES)
def test_the_error_stays_within_the_tolerance_anywhere(mismatch_weight, tolerance_mm):
    warp = warp_of(mismatch_weight, tolerance_mm)
    assert errors_mm(warp, mismatch_weight).max() <= tolerance_mm


@pytest.mark.parametrize(("mismatch_weight", "tolerance_mm"), [c for c in CASES if c[1] < 0.5])
def test_the_tolerance_claim_rejects_a_table_without_contact_fit(mismatch_weight, tolerance_mm):
    warp = warp_of(mismatch_weight, tolerance_mm)
    bare = without_fit(warp, mismatch_weight, tolerance_mm)
    assert errors_mm(bare, mismatch_weight).max() > tolerance_mm


@pytest.mark.parametrize(("mismatch_weight", "tolerance_mm"), CASES)
def test_the_estimate_is_the_error_within_a_small_factor(mismatch_weight, tolerance_mm):
    warp = warp_of(mismatch_weight, tolerance_mm)
    ratio = warp.solution.estimated_error_max_mm / errors_mm(warp, mismatch_weight).max()
    assert 0.8 < ratio < 5.0


def test_the_estimate_claim_rejects_a_table_without_contact_fit():
    warp = warp_of(0.0, 0.1)
    error = errors_mm(without_fit(warp, 0.0, 0.1), 0.0).max()
    assert warp.solution.estimated_error_max_mm / error < 0.8


@pytest.mark.parametrize(("mismatch_weight", "tolerance_mm"), CASES)
def test_the_contact_error_is_a_fraction_of_the_tolerance(mismatch_weight, tolerance_mm):
    errors = contact_errors_mm(warp_of(mismatch_weight, tolerance_mm))
    assert errors.mean() <= 0.02 * tolerance_mm
    assert errors.max() <= 0.15 * tolerance_mm


@pytest.mark.parametrize(("mismatch_weight", "tolerance_mm"), CASES)
def test_the_contact_claim_rejects_a_table_without_contact_fit(mismatch_weight, tolerance_mm):
    warp = warp_of(mismatch_weight, tolerance_mm)
    errors = contact_errors_mm(without_fit(warp, mismatch_weight, tolerance_mm))
    assert errors.mean() > 0.02 * tolerance_mm
    assert errors.max() > 0.15 * tolerance_mm
