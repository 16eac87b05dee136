"""The closed forms solve the equation that they claim to solve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.exact.sources import PointSources
from tests.exact.spheres import SphereWarp
from touchwarp.warp.protocol import Warp

STEP = 1e-3
STRETCH = np.array([[0.3, 0.1, 0.0], [-0.2, 0.5, 0.1], [0.0, 0.3, -0.4]])
WARP = SphereWarp(
    centre=np.array([0.01, -0.02, 0.03]), shift=np.array([0.02, 0.0, -0.01]), stretch=STRETCH
)


def between(count: int = 200, inner: float = 0.06, outer: float = 0.19) -> np.ndarray:
    random = np.random.default_rng(1)
    directions = random.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return WARP.centre + directions * random.uniform(inner, outer, (count, 1))


def laplacian(displacement, x):
    total = -6.0 * displacement(x)
    for axis in np.eye(3) * STEP:
        total = total + displacement(x + axis) + displacement(x - axis)
    return total / STEP**2


def residual(warp: SphereWarp, screening: float) -> float:
    """Greatest |Δu − λu| over the greatest |Δu| that a field of this size could have, near 0."""
    x = between()
    difference = laplacian(warp.displacement, x) - screening * warp.displacement(x)
    return float(np.abs(difference).max() * warp.radius**2 / warp.max_displacement)


@pytest.mark.parametrize("screening", [0.0, 100.0, 2500.0])
def test_spheres_solve_the_screened_equation(screening: float) -> None:
    assert residual(replace(WARP, screening=screening), screening) < 3e-3


@pytest.mark.parametrize("screening", [0.0, 100.0])
def test_the_residual_rejects_another_screening(screening: float) -> None:
    assert residual(replace(WARP, screening=screening + 60.0), screening) > 3e-2


@pytest.mark.parametrize("screening", [0.0, 100.0, 1e-6])
def test_spheres_hold_the_goal_inside_and_nothing_outside(screening: float) -> None:
    warp = replace(WARP, screening=screening)
    on_inner = warp.centre + 0.05 * (between() - warp.centre) / np.linalg.norm(
        between() - warp.centre, axis=1, keepdims=True
    )
    goal = warp.shift + (on_inner - warp.centre) @ STRETCH.T
    np.testing.assert_allclose(warp.displacement(on_inner), goal, atol=1e-12)
    on_outer = warp.centre + 4.0 * (on_inner - warp.centre)
    np.testing.assert_allclose(warp.displacement(on_outer), 0.0, atol=1e-12)
    assert (warp.displacement(warp.centre + 1.01 * (on_outer - warp.centre)) == 0.0).all()


def test_a_small_screening_tends_to_none() -> None:
    x = between()
    np.testing.assert_allclose(
        replace(WARP, screening=1e-4).displacement(x), WARP.displacement(x), atol=1e-7
    )


@pytest.mark.parametrize("screening", [0.0, 100.0])
def test_the_jacobian_is_the_slope(screening: float) -> None:
    warp, x, h = replace(WARP, screening=screening), between(), 1e-6
    steps = np.eye(3) * h
    slope = np.stack([(warp(x + s) - warp(x - s)) / (2 * h) for s in steps], axis=-1)
    np.testing.assert_allclose(warp.jacobian(x), slope, atol=1e-6)
    assert np.abs(warp.jacobian(x).swapaxes(-1, -2) - slope).max() > 1e-2


def test_spheres_are_a_warp() -> None:
    assert isinstance(WARP, Warp)
    assert np.isnan(WARP([np.nan, 0.0, 0.0])).all()
    with pytest.raises(ValueError, match=r"shape \(2,\)"):
        WARP([0.0, 0.0])


SOURCES = PointSources(
    np.array([[0.0, 0.01, 0.05], [0.02, 0.0, 0.03]]),
    np.array([[1e-3, 2e-3, -1e-3], [5e-4, 0.0, 1e-3]]),
    mirrored=True,
)


def test_sources_are_harmonic_and_slide_on_the_plane() -> None:
    x = np.random.default_rng(2).uniform([0.1, 0.1, 0.0], [0.2, 0.2, 0.2], (50, 3))
    size = np.abs(SOURCES.displacement(x)).max() / 0.1**2
    assert np.abs(laplacian(SOURCES.displacement, x)).max() < 1e-2 * size
    plane = x * [1.0, 1.0, 0.0]
    np.testing.assert_allclose(SOURCES.displacement(plane)[:, 2], 0.0, atol=1e-15)
    np.testing.assert_allclose(SOURCES.gradient(plane)[:, :2, 2], 0.0, atol=1e-13)


def test_the_sliding_claim_rejects_sources_without_images() -> None:
    bare = replace(SOURCES, mirrored=False)
    assert np.abs(bare.displacement(np.array([0.1, 0.1, 0.0]))[2]) > 1e-4


def test_the_gradient_of_sources_is_the_slope() -> None:
    x, h = np.array([[0.1, 0.12, 0.04]]), 1e-6
    slope = [
        (SOURCES.displacement(x + s) - SOURCES.displacement(x - s)) / (2 * h) for s in np.eye(3) * h
    ]
    np.testing.assert_allclose(SOURCES.gradient(x), np.stack(slope, axis=-1), rtol=1e-6, atol=1e-9)
