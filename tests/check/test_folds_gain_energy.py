"""det ∂f, singular values and energies against the closed form of concentric spheres."""

from __future__ import annotations

import numpy as np
import pytest

from tests.check.stand_ins import OUTER, RADIUS, ball_scene, ball_warp, case_of
from touchwarp.check.energy import check_energy
from touchwarp.check.folds import check_folds
from touchwarp.check.gain import check_gain
from touchwarp.scene import Objective


def named(finding):
    return {c.name: c for c in finding.checks}


def radial_map(scale: float):
    """f(r) = r (1 + B φ1(r)) outward and its slope, λ = 0."""
    B, norm = scale - 1.0, RADIUS**-3 - OUTER**-3

    def f(r):
        return r * (1.0 + B * (r**-3 - OUTER**-3) / norm)

    def slope(r):
        return 1.0 + B * (-2.0 * r**-3 - OUTER**-3) / norm

    return f, slope


def test_a_ball_shown_twice_as_big_folds_where_the_closed_form_does() -> None:
    f, slope = radial_map(2.0)
    checks = named(check_folds(case_of(ball_scene(2.0, (0, 0, 0)), ball_warp(2.0, (0, 0, 0)))))
    r = np.linspace(RADIUS, OUTER, 200_001)
    folds_to = r[slope(r) < 0].max()
    assert checks["folds.reach"].value == pytest.approx(1e3 * (folds_to - RADIUS), abs=0.7)
    assert checks["folds.reach"].status == "warn"
    volume = 4 / 3 * np.pi * (folds_to**3 - RADIUS**3)
    assert checks["folds.volume"].value == pytest.approx(1e9 * volume, rel=0.02)
    least = slope(RADIUS) * (f(RADIUS) / RADIUS) ** 2
    assert checks["folds.least_det"].value == pytest.approx(least, rel=0.02)
    assert least < -3.0


def test_a_ball_shown_a_little_bigger_does_not_fold() -> None:
    checks = named(check_folds(case_of(ball_scene(1.2, (0, 0, 0)), ball_warp(1.2, (0, 0, 0)))))
    assert (checks["folds.volume"].value, checks["folds.reach"].value) == (0.0, 0.0)
    assert checks["folds.reach"].status == "pass"


def test_gains_are_those_of_the_closed_form() -> None:
    f, slope = radial_map(1.3)
    checks = named(check_gain(case_of(ball_scene(1.3, (0, 0, 0)), ball_warp(1.3, (0, 0, 0)))))
    assert checks["gain.greatest"].value == pytest.approx(f(RADIUS) / RADIUS, rel=0.01)
    assert checks["gain.least"].value == pytest.approx(slope(RADIUS), rel=0.03)
    assert {c.status for c in checks.values()} == {"unknown"}


def test_energies_of_a_shift() -> None:
    d = 0.01
    checks = named(check_energy(case_of(ball_scene(1.0, (d, 0, 0)), ball_warp(1.0, (d, 0, 0)))))
    zeroth = 1 / RADIUS - 1 / OUTER
    distortion = d**2 * 4 * np.pi / zeroth
    assert checks["energy.L2"].value == pytest.approx(1e9 * distortion, rel=0.01)
    r = np.linspace(RADIUS, OUTER, 100_001)
    mismatch = np.trapezoid(4 * np.pi * r**2 * (d * (1 / r - 1 / OUTER) / zeroth) ** 2, r)
    assert checks["energy.L1"].value == pytest.approx(1e15 * mismatch, rel=0.01)


def test_lambda_is_told_without_unit_and_per_square_metre() -> None:
    scene = ball_scene(objective=Objective(mismatch_weight=2.0))
    checks = named(check_energy(case_of(scene, ball_warp(screening=200.0))))
    assert checks["energy.lambda"].value == pytest.approx(2.0)
    assert "200 m⁻²" in checks["energy.lambda"].detail
