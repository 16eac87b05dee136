"""Bricks agree where they meet; a table with one wrong node does not."""

from __future__ import annotations

import numpy as np
import pytest

from tests.check.stand_ins import (
    BOX,
    RADIUS,
    ball_bricks,
    ball_scene,
    ball_table,
    ball_warp,
    case_of,
    with_values,
)
from tests.exact.sample_bricks import near_sphere, sample_bricks
from tests.warp.tables import turned_bricks
from touchwarp.check.brick_faces import cell_sides, jumps
from touchwarp.check.continuity import ALLOWED_JUMP, check_continuity


def jump_of(bricks, per_face: int = 4):
    return jumps(bricks, per_face, 400_000, np.random.default_rng(0))


def test_a_conforming_table_is_continuous() -> None:
    jump, points, count = jump_of(ball_bricks())
    assert count == (ball_bricks().slot >= 0).sum()
    assert jump.max() <= ALLOWED_JUMP
    assert (points >= BOX[0] - 1e-12).all()
    assert (points <= BOX[1] + 1e-12).all()


def test_a_turned_table_with_oblong_cells_is_continuous() -> None:
    assert jump_of(turned_bricks())[0].max() <= ALLOWED_JUMP


def test_hanging_nodes_left_alone_are_found() -> None:
    torn = sample_bricks(
        ball_warp().displacement, *BOX, depth=2, refine=near_sphere(0.0, RADIUS), conforming=False
    )
    assert jump_of(torn)[0].max() > 1e-6


def face_node(values) -> None:
    values[3, 0, 4, 4, 1] += 1e-4


def test_one_wrong_node_on_a_face_fails() -> None:
    scene = ball_scene()
    spoiled = with_values(ball_bricks(), face_node)
    (good,) = check_continuity(case_of(scene, ball_table(scene))).checks
    (bad,) = check_continuity(case_of(scene, ball_table(scene, spoiled))).checks
    assert good.status == "pass"
    assert bad.status == "fail"
    assert 0.03 < bad.value <= 0.1001


def test_a_nan_on_a_face_fails() -> None:
    def spoil(values) -> None:
        values[3, 0, :, :, 1] = np.nan

    assert jump_of(with_values(ball_bricks(), spoil))[0].max() == np.inf


def test_a_border_that_is_not_zero_is_a_jump_against_outside() -> None:
    open_border = sample_bricks(
        lambda x: np.full_like(x, 1e-3),
        *BOX,
        depth=0,
        refine=near_sphere(0.0, RADIUS),
        zero_outside=False,
    )
    jump, points, _ = jump_of(open_border)
    border = (np.abs(points) > 0.2 - 1e-9).any(axis=1)
    assert jump[border].min() == pytest.approx(1e-3 * np.sqrt(3), rel=1e-6)
    assert jump[~border].max() <= ALLOWED_JUMP


def test_stored_jumps_are_allowed_for_and_told() -> None:
    scene = ball_scene()
    spoiled = with_values(ball_bricks(), face_node)
    (check,) = check_continuity(
        case_of(scene, ball_table(scene, spoiled, storage_jump=2e-4))
    ).checks
    assert check.status == "pass"
    assert "16 bits" in check.detail


def test_other_warps_are_unknown() -> None:
    (check,) = check_continuity(case_of(ball_scene(), ball_warp())).checks
    assert check.status == "unknown"
    assert "not a table" in check.detail


def test_cell_sides_follow_the_levels() -> None:
    bricks = ball_bricks()
    sides = cell_sides(bricks, np.array([[0.05, 0, 0], [0.19, 0.19, 0.19], [5.0, 0, 0]]))
    assert sides[0] == pytest.approx(bricks.spacing / 4)
    assert sides[1] == pytest.approx(bricks.spacing / 2) or sides[1] == pytest.approx(
        bricks.spacing
    )
    assert sides[2] == pytest.approx(bricks.spacing)
