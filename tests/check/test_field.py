"""Random walks find the error of the field, whatever made it, and nothing where there is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.check.stand_ins import (
    BOX,
    RADIUS,
    Spoiled,
    Still,
    ball_scene,
    ball_table,
    ball_warp,
    block_scene,
    case_of,
)
from tests.exact.sample_bricks import near_sphere, sample_bricks
from touchwarp.check.case import Case
from touchwarp.check.field import _random_turns, _rule, check_field, field_errors
from touchwarp.scene import Outer
from touchwarp.scene.shapes import sphere

RNG_SEED = 5
SCENE = ball_scene(outer=Outer(surface=sphere(0.2, 0.3)))


def case_with(warp, screening: float = 0.0) -> Case:
    return replace(case_of(SCENE, warp), screening=screening)


def shell(count: int, seed: int = 1) -> np.ndarray:
    rng = np.random.default_rng(seed)
    x = rng.standard_normal((count, 3))
    return x / np.linalg.norm(x, axis=1, keepdims=True) * rng.uniform(0.055, 0.19, (count, 1))


def errors(case: Case, points: np.ndarray, walks: int = 48):
    return field_errors(case, points, walks, np.random.default_rng(RNG_SEED))


@pytest.mark.parametrize("screening", [0.0, 100.0])
def test_the_exact_field_has_no_error(screening: float) -> None:
    found, doubt, lost = errors(case_with(ball_warp(screening=screening), screening), shell(8))
    assert lost == 0
    assert np.abs(found).max() < 2e-5
    assert doubt.max() < 1e-5


def test_a_bump_that_vanishes_on_the_boundary_is_found_whole() -> None:
    def bump(x):
        t = np.clip((np.linalg.norm(x, axis=1) - 0.05) / 0.15, 0, 1)
        return np.sin(np.pi * t)[:, None] * np.array([1e-3, 0, 5e-4])

    points = shell(8)
    found, doubt, _ = errors(case_with(Spoiled(ball_warp(), bump)), points, 100)
    off = np.linalg.norm(found - bump(points), axis=1)
    assert (off < 4 * doubt + 2e-5).all()
    assert np.linalg.norm(found, axis=1).max() > 5e-4


def test_a_field_of_another_lambda_is_off_by_their_difference() -> None:
    points = shell(8)
    case = case_with(ball_warp(screening=300.0), screening=0.0)
    found, doubt, _ = errors(case, points, 100)
    true = ball_warp(screening=300.0).displacement(points) - ball_warp().displacement(points)
    assert (np.linalg.norm(found - true, axis=1) < 4 * doubt + 2e-5).all()
    assert np.linalg.norm(true, axis=1).max() > 1.5e-3


def even_and_odd(x):
    """Harmonic, its normal component odd in z, the others even; nonsense under the table."""
    u = np.stack([x[:, 0] ** 2 - x[:, 1] ** 2, 2 * x[:, 0] * x[:, 1], x[:, 0] * x[:, 2]], axis=1)
    return np.where(x[:, 2:] < 0, 7.0, u)


def off_the_table(x):
    return even_and_odd(x) + np.array([0, 0, 1e-3])


def beside_the_block(count: int) -> np.ndarray:
    return np.random.default_rng(2).uniform([0.04, -0.05, 1e-3], [0.1, 0.05, 0.05], (count, 3))


def test_a_sliding_table_is_a_mirror() -> None:
    points = beside_the_block(16)
    found, _, lost = errors(case_of(block_scene(), Spoiled(Still(), even_and_odd)), points)
    assert lost == 0
    assert np.abs(found).max() < 1e-12
    found, _, _ = errors(case_of(block_scene(), Spoiled(Still(), off_the_table)), points)
    assert np.abs(found[:, 2]).max() > 1e-4
    assert np.abs(found[:, :2]).max() < 1e-12


def table_of(displacement):
    bricks = sample_bricks(displacement, *BOX, depth=2, refine=near_sphere(0.0, RADIUS))
    return ball_table(SCENE, bricks, tolerance_mm=1.0)


def test_a_table_of_the_right_field_passes_and_one_of_another_fails() -> None:
    (good,) = check_field(case_of(SCENE, table_of(ball_warp().displacement))).checks
    (bad,) = check_field(case_of(SCENE, table_of(ball_warp(screening=900.0).displacement))).checks
    assert (good.group, good.status) == ("hard", "pass")
    assert bad.status == "fail"
    assert bad.value > 1.0


def test_warps_that_claim_no_equation_are_unknown() -> None:
    (check,) = check_field(case_of(SCENE, ball_warp())).checks
    assert (check.group, check.status) == ("told", "unknown")
    assert "does not claim to solve eq. 5" in check.detail


@pytest.mark.parametrize(("d", "degree"), [(3, 7), (2, 11)])
def test_the_rule_is_exact_to_its_degree_and_not_beyond(d: int, degree: int) -> None:
    points, weights = _rule(d)
    assert weights.sum() == pytest.approx(1.0)

    def mean_of_power(p: int) -> float:
        along = points @ (np.array([0.48, 0.6, 0.64]) if d == 3 else np.array([1.0, 0.0]))
        return float(weights @ along**p)

    # means of cosᵖ over the sphere and the circle
    for p in range(2, degree + 1, 2):
        exact = 1 / (p + 1) if d == 3 else np.prod(np.arange(1, p, 2) / np.arange(2, p + 1, 2))
        assert mean_of_power(p) == pytest.approx(exact, rel=1e-12)
    p = degree + 1
    exact = 1 / (p + 1) if d == 3 else np.prod(np.arange(1, p, 2) / np.arange(2, p + 1, 2))
    assert mean_of_power(p) != pytest.approx(exact, rel=1e-6)


def test_turns_are_rotations() -> None:
    for d in (2, 3):
        R = _random_turns(200, d, np.random.default_rng(0))
        assert np.einsum("nij,nkj->nik", R, R) == pytest.approx(np.tile(np.eye(d), (200, 1, 1)))
        assert np.linalg.det(R) == pytest.approx(np.ones(200))
        assert np.abs(R.mean(axis=0)).max() < 0.15
