"""Curvature over a fingertip agrees with closed forms, on smooth surfaces and at sharp edges."""

from __future__ import annotations

import math

import numpy as np
import pytest

from touchwarp.goals.fingertip_curvature import (
    FINGERTIP_RADIUS,
    Curvature,
    fingertip_curvature,
    vertex_areas,
)
from touchwarp.goals.refinement import refine
from touchwarp.scene.shapes import box, cylinder, ellipsoid, make_shape, sphere
from touchwarp.scene.surface import Surface


def curvature(surface: Surface, radius: float = FINGERTIP_RADIUS) -> Curvature:
    return fingertip_curvature(surface.vertices, surface.faces, radius)


@pytest.mark.parametrize("radius", [0.02, 0.05])
def test_a_ball_has_one_over_its_radius(radius: float) -> None:
    # vertices of an inscribed triangulation stand for unequal areas: within 2 %
    found = curvature(sphere(radius, 0.01))
    assert found.mean == pytest.approx(np.full(len(found.mean), 1 / radius), rel=0.02)
    assert found.gaussian == pytest.approx(np.full(len(found.mean), 1 / radius**2), rel=0.02)
    assert found.mean != pytest.approx(np.full(len(found.mean), 1.05 / radius), rel=0.02)


def test_a_cylinder_has_half_of_that_and_no_gaussian_curvature() -> None:
    surface = refine(cylinder(0.03, 0.2), FINGERTIP_RADIUS / 3)
    found = curvature(surface)
    x, y, z = surface.vertices.T
    side = (np.abs(z - 0.1) < 0.05) & (np.hypot(x, y) > 0.0299)
    assert side.sum() > 1000
    assert np.median(found.mean[side]) == pytest.approx(1 / 0.06, rel=0.01)
    assert found.mean[side] == pytest.approx(np.full(side.sum(), 1 / 0.06), rel=0.06)
    assert np.abs(found.gaussian[side]).max() < 1e-3 / 0.03**2


def test_an_ellipsoid_has_its_own_at_each_point() -> None:
    a, b, c = 0.06, 0.04, 0.05
    surface = ellipsoid([2 * a, 2 * b, 2 * c], 0.005)
    found = curvature(surface, radius=3e-3)
    x, y, z = surface.vertices.T
    h = x**2 / a**4 + y**2 / b**4 + z**2 / c**4
    gaussian = 1 / (a * b * c * h) ** 2
    mean = (a**2 + b**2 + c**2 - x**2 - y**2 - z**2) / (2 * (a * b * c) ** 2 * h**1.5)
    assert found.mean == pytest.approx(mean, rel=0.04)
    assert found.gaussian == pytest.approx(gaussian, rel=0.06)
    # the twin: a ball of the same size is not within reach of that
    assert np.abs(found.mean * 0.05 - 1).max() > 0.3


def test_a_sharp_edge_is_spread_over_a_fingertip() -> None:
    surface = refine(box([0.06, 0.06, 0.04]), FINGERTIP_RADIUS / 8)
    found = curvature(surface)
    x, y, z = surface.vertices.T
    level = (z > 0.02 - 1e-9) & (np.abs(y) < 0.01)
    away = 0.03 - np.abs(x[level])
    reach = FINGERTIP_RADIUS / math.sqrt(8)
    # an edge of π/2 carries π/4 a length; the step of diffusion gives it this profile
    exact = math.pi / 4 / (2 * reach) * np.exp(-away / reach)
    assert found.mean[level] == pytest.approx(exact, abs=0.02 * exact.max())
    assert np.abs(found.mean[level] - 0.95 * exact).max() > 0.03 * exact.max()


@pytest.mark.parametrize(
    ("shape", "total_mean", "characteristic"),
    [
        (box([0.03, 0.04, 0.1]), math.pi / 4 * 4 * 0.17, 2),
        (sphere(0.05, 0.05), 4 * math.pi * 0.05, 2),
        (make_shape("mug", {}), None, 0),
    ],
)
def test_nothing_is_lost_in_spreading(
    shape: Surface, total_mean: float | None, characteristic: int
) -> None:
    surface = refine(shape, FINGERTIP_RADIUS / 3)
    found = curvature(surface)
    mass = vertex_areas(surface.vertices, surface.faces)
    assert mass @ found.gaussian == pytest.approx(2 * math.pi * characteristic, abs=1e-4)
    if total_mean is not None:
        assert mass @ found.mean == pytest.approx(total_mean, rel=2e-3)


def test_seen_from_inside_a_ball_is_hollow() -> None:
    surface = sphere(0.05, 0.05)
    inward = fingertip_curvature(surface.vertices, surface.faces[:, ::-1])
    assert (inward.mean < -19).all()
    assert (inward.gaussian > 350).all()


def test_a_plane_wound_to_and_fro_is_flat_within() -> None:
    surface = refine(box([0.1, 0.1, 0.02]), 2e-3)
    x, y, z = surface.vertices.T
    top = surface.faces[(z[surface.faces] > 0.0099).all(axis=1)]
    top[::3] = top[::3, ::-1]
    found = fingertip_curvature(surface.vertices, top)
    assert np.abs(found.mean).max() < 1e-6
    assert np.abs(found.gaussian).max() < 1e-6
    raised = surface.vertices + np.stack([0 * x, 0 * y, 0.1 * np.abs(x)], axis=1)
    assert np.abs(fingertip_curvature(raised, top).mean).max() > 1


def test_a_thin_wall_s_other_side_is_out_of_reach() -> None:
    """Two balls, one in the other with 1 mm between: neither is aware of the other."""
    outer, inner = sphere(0.05, 0.02), sphere(0.049, 0.02)
    vertices = np.concatenate([outer.vertices, inner.vertices])
    faces = np.concatenate([outer.faces, inner.faces[:, ::-1] + len(outer.vertices)])
    found = fingertip_curvature(vertices, faces).mean
    assert found[: len(outer.vertices)] == pytest.approx(
        np.full(len(outer.vertices), 20.0), rel=0.02
    )
    assert found[len(outer.vertices) :] == pytest.approx(
        np.full(len(inner.vertices), -1 / 0.049), rel=0.02
    )


def test_vertices_that_coincide_are_one() -> None:
    surface = sphere(0.05, 0.05)
    soup = Surface(
        surface.vertices[surface.faces].reshape(-1, 3),
        np.arange(3 * len(surface.faces)).reshape(-1, 3),
    )
    together = curvature(surface).mean[surface.faces].reshape(-1)
    assert curvature(soup).mean == pytest.approx(together, rel=1e-6)


def test_a_rim_has_no_curvature_of_its_own() -> None:
    sheet = refine(
        Surface(
            np.array([[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0]]),
            np.array([[0, 1, 2], [0, 2, 3]]),
        ),
        3e-3,
    )
    found = curvature(sheet)
    assert np.abs(found.mean).max() < 1e-9
    assert np.abs(found.gaussian).max() < 1e-9
