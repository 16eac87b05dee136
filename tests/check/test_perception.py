"""Values are held against a threshold only under its condition; curvature and pinch are right."""

from __future__ import annotations

import numpy as np
import pytest

from tests.check.stand_ins import Still, ball_scene, ball_warp, block_scene, case_of
from touchwarp.check.curvature import edge_angles, patch_curvatures
from touchwarp.check.perception import check_perception, normal_turn
from touchwarp.check.pinch import find_pinches
from touchwarp.check.thresholds import (
    ACCEPTANCE,
    ANY_MODE,
    DETECTION,
    EDGE_ANGLE,
    JND,
    PINCH_WIDTH,
    THRESHOLDS,
    judge,
    limit_of,
)
from touchwarp.scene import Interaction, TransformGoal


def found(scene, warp):
    return {c.name: c for c in check_perception(case_of(scene, warp)).checks}


def test_every_threshold_has_condition_and_source() -> None:
    for t in THRESHOLDS:
        assert t.condition
        assert t.source
        assert t.kind in (JND, DETECTION, ACCEPTANCE)
        assert set(t.modes) <= set(ANY_MODE)
        assert limit_of(t)


@pytest.mark.parametrize(
    ("mode", "status"), [("pinch", "warn"), ("slide", "unknown"), ("tap", "unknown")]
)
def test_pinch_width_is_judged_in_a_pinch_only(mode: str, status: str) -> None:
    check = found(ball_scene(1.2, mode=mode), ball_warp())["pinch.width"]
    assert check.value == pytest.approx(20.0, rel=1e-6)
    assert check.status == status
    if status == "unknown":
        assert check.limit is None
        assert f"no number for mode “{mode}”; nearest: ≤ 5.75" in check.condition


@pytest.mark.parametrize(("shift", "status"), [(0.040, "pass"), (0.060, "warn")])
def test_offset_in_contact(shift: float, status: str) -> None:
    scene = ball_scene(1.0, (shift, 0, 0))
    check = found(scene, ball_warp(1.0, (shift, 0, 0)))["offset.contact"]
    assert check.value == pytest.approx(1e3 * shift)
    assert check.status == status
    assert "Zhao & Follmer" in check.source
    assert check.condition.startswith("just noticeable difference: normal and shear force")


def test_a_tap_has_no_number_for_the_offset() -> None:
    assert found(ball_scene(mode="tap"), ball_warp())["offset.contact"].status == "unknown"


def test_normals_turn_with_the_goal() -> None:
    goal = TransformGoal(pivot="centre", rotation_deg=[0, 0, 25])
    case = case_of(block_scene(goal=goal), Still())
    turn = normal_turn(case.props[0])
    assert sorted(np.round(turn)) == [0] * 4 + [25] * 8
    assert found(block_scene(goal=goal), Still())["normal.turn"].status == "pass"
    steep = TransformGoal(pivot="centre", rotation_deg=[0, 0, 40])
    assert found(block_scene(goal=steep), Still())["normal.turn"].status == "warn"


@pytest.mark.parametrize("scale", [0.5, 1.3])
def test_curvature_of_a_scaled_ball(scale: float) -> None:
    case = case_of(ball_scene(scale), ball_warp(scale), samples=200_000)
    points, felt, seen, flat = patch_curvatures(case.props[0], np.random.default_rng(0))
    assert len(points) > 1000
    assert flat == 0.0
    assert np.median(felt) == pytest.approx(1 / 0.05, rel=0.05)
    assert np.median(seen / felt) == pytest.approx(1 / scale, rel=1e-6)


def test_curvature_is_judged_in_a_pinch() -> None:
    check = found(ball_scene(0.5, mode="pinch"), ball_warp(0.5))["curvature.change"]
    assert check.value == pytest.approx(100.0, rel=1e-3)
    assert check.status == "warn"
    assert found(ball_scene(1.2, mode="pinch"), ball_warp())["curvature.change"].status == "pass"


def test_flat_sides_have_no_curvature_and_edges_do() -> None:
    case = case_of(block_scene(), Still(), samples=200_000)
    points, felt, _, flat = patch_curvatures(case.props[0], np.random.default_rng(0))
    assert 0.3 < flat < 0.8
    assert (felt > 0).all()
    half = np.array([0.03, 0.02, 0.05])
    from_edges = np.sort(half - np.abs(points - [0, 0, 0.05]), axis=1)[:, 1]
    assert from_edges.max() < 8e-3


def test_pinches_of_a_block_are_its_widths() -> None:
    goal = TransformGoal(pivot="centre", scale=[1.1, 1.0, 0.8])
    case = case_of(block_scene((0.06, 0.04, 0.09), goal=goal), Still())
    points, width, change = find_pinches(case.props[0], np.random.default_rng(0))
    for size, wanted in ((0.06, 0.1), (0.04, 0.0), (0.09, -0.2)):
        of = np.isclose(width, size)
        assert of.sum() > 100
        assert change[of] == pytest.approx(np.full(of.sum(), wanted), abs=1e-6)
    assert len(points) == np.isclose(width[:, None], [0.06, 0.04, 0.09]).sum()


def test_angles_of_edges() -> None:
    shear = np.eye(4)
    shear[0, 1] = 1.0
    case = case_of(block_scene(goal=TransformGoal(matrix=shear)), Still())
    felt, seen, _ = edge_angles(case.props[0])
    assert felt == pytest.approx(np.full(12, np.pi / 2))
    assert np.degrees([seen.min(), seen.max()]) == pytest.approx([45, 135])
    check = found(block_scene(goal=TransformGoal(matrix=shear)), Still())["edges.angle"]
    assert check.value == pytest.approx(50.0)
    assert check.status == "unknown"
    assert EDGE_ANGLE.modes == ()


def test_a_matched_threshold_passes_within_and_warns_beyond() -> None:
    assert judge(PINCH_WIDTH, "pinch", "n", "t", 5.7).status == "pass"
    assert judge(PINCH_WIDTH, "pinch", "n", "t", 5.8).status == "warn"


def test_the_mode_comes_from_the_scene() -> None:
    scene = block_scene(interaction=Interaction("grasp"))
    assert found(scene, Still())["offset.contact"].status == "pass"
