"""Below the surface, and the error budget, for warps whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest

from tests.check.stand_ins import Spoiled, Still, ball, ball_scene, ball_warp, block_scene, case_of
from touchwarp.check.below import DEEPEST, check_below, points_below
from touchwarp.check.budget import check_budget
from touchwarp.scene import Interaction, Prop, Scene, Surface, Tracking, TransformGoal
from touchwarp.scene.shapes import box


def named(finding):
    return {c.name: c for c in finding.checks}


def test_points_below_stay_in_their_half_of_a_wall() -> None:
    slab = box([0.1, 0.1, 0.006])
    case = case_of(Scene(props=[Prop("slab", slab)]), Still())
    points, depth = points_below(case.props[0], np.random.default_rng(0))
    assert len(points) > 2000
    assert depth.max() <= 0.003 * 1.02
    assert np.abs(points[:, 2]).max() < 0.003


def test_points_below_a_ball_go_down_to_ten_millimetres() -> None:
    case = case_of(ball_scene(), ball_warp())
    points, depth = points_below(case.props[0], np.random.default_rng(0))
    assert depth.max() == pytest.approx(DEEPEST, rel=0.01)
    assert np.linalg.norm(points, axis=1).min() > 0.0395


def test_the_goal_going_on_inside_is_sane() -> None:
    checks = named(check_below(case_of(ball_scene(), ball_warp())))
    assert {c.status for c in checks.values()} == {"pass"}
    assert checks["below.gain"].value == pytest.approx(1.2)
    assert checks["below.outside"].value == 0.0


def inside(x, radius=0.049):
    return np.linalg.norm(x, axis=1, keepdims=True) < radius


def test_an_inside_thrown_out_warns() -> None:
    wild = Spoiled(ball_warp(), lambda x: np.where(inside(x), 0.05 * np.sign(x), 0.0))
    checks = named(check_below(case_of(ball_scene(), wild)))
    assert checks["below.mismatch"].status == checks["below.outside"].status == "warn"


def test_a_steep_inside_warns() -> None:
    steep = Spoiled(ball_warp(), lambda x: 2e-3 * np.sin(4000 * x))
    assert named(check_below(case_of(ball_scene(), steep)))["below.gain"].status == "warn"


def test_an_open_surface_has_no_below() -> None:
    surface = ball()
    bowl = surface.faces[(surface.vertices[surface.faces][:, :, 2] < 1e-9).all(axis=1)]
    scene = Scene(props=[Prop("bowl", Surface(surface.vertices, bowl))])
    (check,) = check_below(case_of(scene, Still())).checks
    assert check.status == "unknown"
    assert "no inside" in check.detail


def budget_of(tracking: Tracking, warp=None, mode: str = "slide"):
    scene = block_scene(interaction=Interaction(mode, tracking))
    finding = check_budget(case_of(scene, warp or Still()))
    return named(finding), finding.shown


def test_a_perfect_tracker_leaves_the_table_alone() -> None:
    checks, _ = budget_of(Tracking())
    assert checks["budget.gap"].value == pytest.approx(0.0, abs=1e-9)
    off = Spoiled(Still(), lambda x: np.full_like(x, 1e-3))
    checks, _ = budget_of(Tracking(), off)
    # 1 mm along each axis is 1 mm off every side of a block
    assert checks["budget.table"].value == pytest.approx(1.0, rel=0.01)


def test_noise_on_flat_sides_is_half_normal() -> None:
    checks, shown = budget_of(Tracking(noise_mm=1.0))
    gaps = 1e3 * shown["gaps"]["noise"]
    assert np.median(gaps) == pytest.approx(0.674, rel=0.06)
    assert checks["budget.noise"].value == pytest.approx(1.96, rel=0.06)
    assert checks["budget.bias"].value == pytest.approx(0.0, abs=1e-9)


def test_bias_of_random_direction_is_uniform_across_a_flat_side() -> None:
    _, shown = budget_of(Tracking(bias_mm=1.0))
    assert 1e3 * np.median(shown["gaps"]["bias"]) == pytest.approx(0.5, rel=0.06)


def test_latency_matters_to_a_tap_and_not_to_a_slide_on_a_flat_side() -> None:
    late = Tracking(latency_ms=40.0)
    tap, _ = budget_of(late, mode="tap")
    slide, _ = budget_of(late)
    assert tap["budget.latency"].value == pytest.approx(0.25 * 40.0, rel=0.01)
    assert slide["budget.latency"].value < 4.0


def test_turned_pose_matters_more_far_from_the_middle() -> None:
    small, _ = budget_of(Tracking(pose_deg=1.0))
    shift, _ = budget_of(Tracking(pose_mm=1.0))
    assert shift["budget.pose"].value == pytest.approx(1.96, rel=0.06)
    # a point 50 mm from the middle moves by 0.9 mm a degree
    assert 0.5 < small["budget.pose"].value < 2.5


def test_gain_carries_tracking_errors_along() -> None:
    scene = ball_scene(1.0, (0, 0, 0), interaction=Interaction("slide", Tracking(noise_mm=0.5)))
    twice = Spoiled(Still(), lambda x: x * (1 - 0.05 / np.linalg.norm(x, axis=1, keepdims=True)))
    one = check_budget(case_of(scene, Still()))
    two = check_budget(case_of(scene, twice))
    # radially twice as steep at the surface
    ratio = named(two)["budget.noise"].value / named(one)["budget.noise"].value
    assert ratio == pytest.approx(2.0, rel=0.05)
    assert named(two)["budget.gain"].value == pytest.approx(2.0, rel=0.02)


def test_the_other_preset_is_told_for_comparison() -> None:
    scene = block_scene(goal=TransformGoal(), interaction=Interaction("slide", "headset_hands"))
    checks = named(check_budget(case_of(scene, Still())))
    assert "with “markers” it would be" in checks["budget.gap"].detail
    assert checks["budget.gap"].value > 5.0
    low, high = scene.props[0].surface.vertices.min(0), scene.props[0].surface.vertices.max(0)
    for name in ("budget.gap", "budget.bias", "budget.gain"):
        where = np.array(checks[name].where)
        assert ((where >= low - 1e-9) & (where <= high + 1e-9)).all()
