"""The maximum principle: the exact warp keeps it, one with a bump in mid-air does not."""

from __future__ import annotations

import numpy as np
import pytest

from tests.check.stand_ins import (
    Spoiled,
    ball_bricks,
    ball_scene,
    ball_table,
    ball_warp,
    case_of,
    with_values,
)
from touchwarp.check.bounds import check_bounds, shell_points


def found(scene, warp):
    return {c.name: c for c in check_bounds(case_of(scene, warp)).checks}


@pytest.mark.parametrize("screening", [0.0, 100.0])
def test_the_exact_warp_is_within_its_boundary_values(screening: float) -> None:
    checks = found(ball_scene(), ball_warp(screening=screening))
    assert [c.status for c in checks.values()] == ["pass", "pass"]
    assert checks["bounds.excess"].value == 0.0
    # the inscribed facets' vertices just miss the direction in which the sphere moves farthest
    assert checks["bounds.excess_at_surface"].value == pytest.approx(0.0, abs=0.02)


def test_a_bump_in_mid_air_fails() -> None:
    spot = np.array([0.0, 0.0, 0.07])

    def bump(x):
        r = np.linalg.norm(x - spot, axis=1)
        return np.exp(-((r / 8e-3) ** 2))[:, None] * np.array([0.03, 0, 0])

    checks = found(ball_scene(), Spoiled(ball_warp(), bump))
    assert checks["bounds.excess"].status == "fail"
    assert np.linalg.norm(np.array(checks["bounds.excess"].where) - spot) < 8e-3


def test_a_bump_beside_the_surface_is_held_against_the_contact_error() -> None:
    def bump(x):
        r = np.linalg.norm(x, axis=1)
        return np.where((r > 0.0502) & (r < 0.052), 1.0, 0.0)[:, None] * np.array([0.002, 0, 0])

    # it stays off the surface, so that no contact error allows for it
    checks = found(ball_scene(), Spoiled(ball_warp(), bump))
    assert checks["bounds.excess"].status == "pass"
    assert checks["bounds.excess_at_surface"].status == "fail"


def test_one_wrong_node_of_a_table_is_found() -> None:
    def spoil(values) -> None:
        values[3, 4, 4, 4] = [0.1, 0, 0]

    scene = ball_scene()
    table = ball_table(scene, with_values(ball_bricks(), spoil))
    assert found(scene, ball_table(scene))["bounds.excess"].status == "pass"
    assert found(scene, table)["bounds.excess"].status == "fail"


def test_beside_the_surface_the_contact_error_is_allowed_for() -> None:
    scene = ball_scene()
    checks = found(scene, ball_table(scene))
    assert checks["bounds.excess_at_surface"].status == "pass"


def test_shell_points_are_in_the_region_and_close() -> None:
    case = case_of(ball_scene(), ball_warp())
    points = shell_points(case, 5000)
    r = np.linalg.norm(points, axis=1)
    assert case.region.contains(points).all()
    assert len(points) > 4900
    assert r.max() < 0.05 + 5.1e-3
    assert np.median(r) < 0.0507
