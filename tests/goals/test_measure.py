"""Every number of a map's summary, on maps where it is known, and on spoilt ones."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.goals.hand_made_maps import (
    RADIUS,
    ball,
    cube_map,
    doubled,
    ellipsoid_map,
    identity_map,
    with_a_hole,
    with_one_flip,
)
from touchwarp.goals import Goal
from touchwarp.goals.measure import measure_map, outward, weighted_quantile
from touchwarp.scene.shapes import box, ellipsoid, make_shape, sphere
from touchwarp.scene.surface import Surface


@cache
def summary(name: str) -> dict[str, float]:
    goal = {"ellipsoid": ellipsoid_map, "cube": cube_map}[name]()
    return measure_map(goal, samples=20_000).summary()


def spheroid_area(a: float, c: float) -> float:
    """Of a prolate spheroid, c > a."""
    e = math.sqrt(1 - (a / c) ** 2)
    return 2 * math.pi * a**2 * (1 + c / (a * e) * math.asin(e))


def test_a_ball_stretched_to_a_spheroid() -> None:
    surface = sphere(RADIUS, 0.005)
    image = Surface(surface.vertices * [1, 1, 1.5], surface.faces)
    found = measure_map(
        Goal(surface.vertices, image.vertices, surface.faces, virtual_surface=image), samples=2000
    ).summary()
    scale = spheroid_area(1, 1.5) / (4 * math.pi)
    assert found["area_scale"] == pytest.approx(scale, rel=1e-3)
    # at angle t from the axis areas grow by sqrt(cos² t + 1.5² sin² t); over the ball's area
    cosine = (np.arange(2000) + 0.5) / 2000
    ratio = np.sqrt(cosine**2 + 2.25 * (1 - cosine**2)) / scale
    assert ratio.mean() == pytest.approx(1.0, abs=1e-6)
    assert found["area_std"] == pytest.approx(ratio.std(), rel=1e-2)
    assert found["stretch_greatest"] == pytest.approx(1.5, rel=5e-3)
    assert found["stretch_least"] == pytest.approx(1.0, rel=5e-3)
    assert found["displacement_max"] == pytest.approx(0.5 * RADIUS, rel=1e-3)
    # the mean of |cos| over a ball is a half
    assert found["displacement_mean"] == pytest.approx(0.25 * RADIUS, rel=1e-2)
    # |∇u|² = 0.25 sin² t, whose mean is 2/3 of that
    assert found["smoothness"] == pytest.approx(0.25 * 2 / 3, rel=1e-2)


def test_normals_turn_by_what_the_ellipsoid_s_formula_says() -> None:
    points = Rotation.random(4000, rng=0).apply([0, 0, 1])
    normals = points / np.diag([1.2, 0.8, 1.0]).diagonal()
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    turn = np.arccos(np.clip((points * normals).sum(axis=1), -1, 1))
    assert summary("ellipsoid")["normal_mean"] == pytest.approx(turn.mean(), rel=0.03)
    assert summary("ellipsoid")["normal_p95"] == pytest.approx(np.quantile(turn, 0.95), rel=0.03)


def test_curvature_changes_by_what_the_ellipsoid_s_formula_says() -> None:
    surface = ball(0.005)
    image = Surface(surface.vertices * [1.2, 0.8, 1.0], surface.faces)
    goal = Goal(surface.vertices, image.vertices, surface.faces, virtual_surface=image)
    found = measure_map(goal, samples=2000)
    a, b, c = 1.2 * RADIUS, 0.8 * RADIUS, RADIUS
    x, y, z = (found.curvature.points * [1.2, 0.8, 1.0]).T
    h = x**2 / a**4 + y**2 / b**4 + z**2 / c**4
    mean = (a**2 + b**2 + c**2 - x**2 - y**2 - z**2) / (2 * (a * b * c) ** 2 * h**1.5)
    change = mean - 1 / RADIUS
    # a fingertip averages it, which takes off at most a tenth of the greatest
    assert found.curvature.change == pytest.approx(change, abs=0.1 * np.abs(change).max())
    assert found.summary()["curvature_mean"] == pytest.approx(np.abs(change).mean(), rel=0.08)
    assert found.summary()["curvature_p95"] > 0.3 / RADIUS


def test_a_cube_shown_as_a_ball() -> None:
    found = summary("cube")
    side = 0.08
    assert found["area_scale"] == pytest.approx(4 * math.pi * RADIUS**2 / (6 * side**2), rel=2e-3)
    # a face's centre is at side/2 and its corners at √3 side/2 from the middle
    assert found["displacement_max"] == pytest.approx(math.sqrt(3) / 2 * side - RADIUS, rel=1e-6)
    # by rays, area goes as h r² / (h² + …)^{3/2}: h = side/2 from the face's plane
    u = (np.arange(400) + 0.5) / 400 * side / 2
    distance = np.sqrt((side / 2) ** 2 + u[:, None] ** 2 + u[None, :] ** 2)
    ratio = RADIUS**2 * (side / 2) / distance**3
    turn = np.arccos(side / 2 / distance)
    assert found["normal_mean"] == pytest.approx(turn.mean(), rel=0.01)
    assert found["area_std"] == pytest.approx((ratio / ratio.mean()).std(), rel=0.01)
    assert (found["edges_lost"], found["edges_new"]) == (1.0, 0.0)
    assert found["curvature_p95"] > 50  # the cube's edges, as a fingertip feels them


@pytest.mark.parametrize("name", ["ellipsoid", "cube"])
def test_a_bijection_is_on_its_surface_and_covers_it_once(name: str) -> None:
    found = summary(name)
    assert (found["flips"], found["opposing"]) == (0, 0)
    assert found["coverage"] == 1.0
    assert found["layers"] == pytest.approx(1.0, abs=1e-3)
    assert found["distance_max"] < 5e-5
    assert found["landmark_max"] == 0.0


def test_the_identity_measures_nothing() -> None:
    found = measure_map(identity_map(make_shape("tea_cup", {})), samples=5000).summary()
    nothing = {
        *("flips", "opposing", "distance_vertices", "distance_max", "area_std"),
        *("displacement_max", "smoothness", "smoothness_inverse", "edges_lost", "edges_new"),
    }
    assert {name: found[name] for name in nothing if abs(found[name]) > 1e-6} == {}
    assert found["curvature_mean"] < 1e-6
    assert found["normal_p95"] < 1e-6
    for one in ("coverage", "layers", "area_scale", "stretch_least", "stretch_greatest"):
        assert found[one] == pytest.approx(1.0, abs=1e-9)


def test_spoilt_maps_are_told_apart() -> None:
    goal = ellipsoid_map()
    assert measure_map(with_one_flip(goal), samples=1000).summary()["flips"] >= 1
    hole = with_a_hole(goal, np.array([0.0, 0.0, RADIUS]), 0.01)
    assert measure_map(hole, samples=20_000).summary()["coverage"] < 0.995
    twice = measure_map(doubled(identity_map(ball(0.02))), samples=1000).summary()
    assert twice["layers"] == pytest.approx(2.0, abs=0.05)
    off = replace(goal, virtual_points=goal.virtual_points * 1.01)
    assert measure_map(off, samples=1000).summary()["distance_vertices"] > 3.9e-4


def test_landmarks_are_measured_where_they_are_on_the_faces() -> None:
    goal = ellipsoid_map()
    middles = goal.prop_points[goal.faces[::500]].mean(axis=1)
    images = goal.virtual_points[goal.faces[::500]].mean(axis=1)
    exact = replace(goal, landmarks=np.stack([middles, images], axis=1))
    assert measure_map(exact, samples=1000).summary()["landmark_max"] < 1e-12
    images[3] += [0, 0, 2e-3]
    off = measure_map(replace(goal, landmarks=np.stack([middles, images], axis=1)), samples=1000)
    assert off.landmark_error.argmax() == 3
    diagonal = 2 * RADIUS * math.sqrt(1.2**2 + 0.8**2 + 1)
    assert off.summary()["landmark_max"] == pytest.approx(2e-3 / diagonal, rel=1e-2)


def test_moving_and_turning_all_changes_no_number() -> None:
    goal = cube_map(edge=6e-3)
    R = Rotation.random(rng=1).as_matrix()
    assert goal.virtual_surface is not None
    moved = Goal(
        goal.prop_points @ R.T + 0.3,
        goal.virtual_points @ R.T + 0.3,
        goal.faces,
        virtual_surface=Surface(
            goal.virtual_surface.vertices @ R.T + 0.3, goal.virtual_surface.faces
        ),
    )
    before, after = (measure_map(g, samples=2000).summary() for g in (goal, moved))
    for name, value in before.items():
        assert after[name] == pytest.approx(value, rel=1e-4, abs=1e-9, nan_ok=True), name


def test_a_goal_without_a_virtual_surface_is_measured_against_its_image() -> None:
    surface = ball()
    found = measure_map(Goal(surface.vertices, 1.1 * surface.vertices, surface.faces), samples=1000)
    assert found.summary()["distance_max"] < 1e-12
    assert found.summary()["area_scale"] == pytest.approx(1.21)


def test_plane_goals_are_refused() -> None:
    points = np.eye(2)
    with pytest.raises(ValueError, match="goal is of a plane scene"):
        measure_map(Goal(points, points, np.array([[0, 1]])))


def test_which_way_is_out() -> None:
    for surface in (box([1, 2, 3]), ellipsoid([1, 2, 3], 50), make_shape("mug", {})):
        assert outward(surface.vertices, surface.faces) == 1.0
        assert outward(surface.vertices + 9.0, surface.faces[:, ::-1]) == -1.0
    sheet = box([1, 1, 1])
    assert outward(sheet.vertices, sheet.faces[:2]) == 0.0


def test_a_weighted_quantile_is_that_of_repeated_values() -> None:
    rng = np.random.default_rng(0)
    values, weight = rng.random(100), rng.integers(1, 9, 100)
    repeated = np.sort(np.repeat(values, weight))
    for q in (0.01, 0.5, 0.95):
        expected = np.quantile(repeated, q, method="inverted_cdf")
        assert weighted_quantile(values, weight.astype(float), q) == expected
