"""Star-shaped bodies share azimuth and polar angle; others are refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from touchwarp.errors import GoalError
from touchwarp.goals import Goal, goals
from touchwarp.goals.star_centre import even_directions, star_kernel
from touchwarp.scene import DirectionGoal, Prop, Scene, Surface
from touchwarp.scene.pose import pose_matrix
from touchwarp.scene.shapes import box, cylinder, ellipsoid, make_shape, sphere

CUBE = box((0.1, 0.1, 0.1))


def made(prop: Surface, virtual: Surface, **keys: Any) -> Goal:
    return goals(Scene([Prop("it", prop, DirectionGoal(virtual, **keys))]))["it"]


def moved(surface: Surface, *position: float) -> Surface:
    return surface.transformed(pose_matrix(position, (0, 0, 0)))


def turned_by(goal: Goal, centre: Any, virtual_centre: Any) -> float:
    """rad: the greatest angle between the directions of a point and of its image."""
    directions = [goal.prop_points - centre, goal.virtual_points - virtual_centre]
    first, second = (d / np.linalg.norm(d, axis=1)[:, None] for d in directions)
    return float(np.linalg.norm(np.cross(first, second), axis=1).max())


@pytest.mark.parametrize("centre", [None, (0.0, 0.0, 0.0), (0.01, 0.0, -0.02)])
def test_a_ball_is_felt_as_a_cube(centre: Any) -> None:
    goal = made(sphere(0.06, facet_mm=0.2), CUBE, centre=centre)
    expected = np.zeros(3) if centre is None else np.array(centre)
    np.testing.assert_allclose(goal.report["centre"], expected, atol=1e-9)
    assert turned_by(goal, expected, expected) < 1e-12
    np.testing.assert_allclose(np.abs(goal.virtual_points).max(axis=1), 0.05, rtol=1e-12)
    # Between its points as well: the cube's edges are not cut off by more than the tolerance.
    middles = np.abs(goal.virtual_points[goal.faces].mean(axis=1)).max(axis=1)
    assert 0.05 - middles.min() < 1.3 * 0.05e-3 * np.sqrt(2)
    assert goal.report["image_distance_max"] <= 0.05e-3
    assert goal.virtual_surface is CUBE


def test_the_direction_claim_rejects_another_centre() -> None:
    goal = made(sphere(0.06, facet_mm=0.2), CUBE, centre=(0.001, 0, 0))
    assert turned_by(goal, np.zeros(3), np.zeros(3)) > 1e-3


def test_a_ball_to_an_ellipsoid_has_a_closed_form() -> None:
    half = np.array([0.05, 0.03, 0.08])
    goal = made(sphere(0.04), ellipsoid(2 * half, facet_mm=0.005), centre=(0, 0, 0))
    directions = goal.prop_points / np.linalg.norm(goal.prop_points, axis=1)[:, None]
    exact = directions / np.linalg.norm(directions / half, axis=1)[:, None]
    # The ellipsoid's facets lie up to 0.005 mm inside of it, more along a slanting ray.
    assert np.linalg.norm(goal.virtual_points - exact, axis=1).max() < 1e-5
    assert np.linalg.norm(goal.virtual_points - 0.999 * exact, axis=1).max() > 5e-5


def test_a_centre_is_found_that_both_see() -> None:
    prop, virtual = moved(CUBE, 0.3, 0, 0), moved(cylinder(0.04, 0.06), 0.31, 0, 0)
    goal = made(prop, virtual)
    assert goal.report["centre"] == goal.report["virtual_centre"]
    assert star_kernel(prop, virtual).depth >= 0.0125  # half of what there is room for


def test_bodies_apart_have_a_centre_each() -> None:
    goal = made(CUBE, moved(sphere(0.03, facet_mm=0.2), 0.5, 0, 0))
    np.testing.assert_allclose(goal.report["centre"], 0, atol=1e-9)
    np.testing.assert_allclose(goal.report["virtual_centre"], [0.5, 0, 0], atol=1e-9)
    assert turned_by(goal, np.zeros(3), np.array([0.5, 0, 0])) < 1e-12


def test_the_kernel_is_where_all_faces_are_seen() -> None:
    slab = box((0.1, 0.04, 0.06))
    assert star_kernel(slab).depth == pytest.approx(0.02)
    np.testing.assert_allclose(star_kernel(slab).centre, 0, atol=1e-9)
    inside_out = Surface(slab.vertices, slab.faces[:, ::-1])
    assert star_kernel(inside_out).depth == pytest.approx(0.02)
    # An L has its kernel in the corner that both arms share.
    corners = np.array([(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]) * 0.01
    n = len(corners)
    low, high = np.c_[corners, np.zeros(n)], np.c_[corners, np.full(n, 0.02)]
    i = np.arange(n)
    j = (i + 1) % n
    sides = np.concatenate([np.c_[i, j, j + n], np.c_[i, j + n, i + n]])
    cap = np.array([(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)])
    ell = Surface(np.concatenate([low, high]), np.concatenate([sides, cap[:, ::-1], cap + n]))
    kernel = star_kernel(ell)
    assert kernel.depth > 0
    assert (kernel.centre > 0).all()
    assert (kernel.centre[:2] < 0.01).all()
    assert made(ell, sphere(0.03, facet_mm=0.5)).report["virtual_centre"] is not None


def test_a_mug_is_not_star_shaped() -> None:
    mug = make_shape("mug", {})
    assert star_kernel(mug).depth < 0
    with pytest.raises(
        GoalError,
        match=r"the prop is not star-shaped from \(.*\) mm: \d+.\d\d% of rays do not cross it just "
        r"once, one of them along \(.*\); no centre sees all of it: choose another kind of goal",
    ):
        made(mug, CUBE)
    with pytest.raises(GoalError, match="the virtual object is not star-shaped from"):
        made(CUBE, mug)


def test_a_centre_outside_is_refused_with_the_share_of_rays() -> None:
    with pytest.raises(
        GoalError, match=r"star-shaped from \(200, 0, 0\) mm: 100.00% of rays .*; choose another ce"
    ):
        made(CUBE, CUBE, centre=(0.2, 0, 0))
    with pytest.raises(GoalError, match=r"the centre \(50, 50, 50\) mm is a vertex of the prop"):
        made(CUBE, CUBE, centre=(0.05, 0.05, 0.05))


def test_an_open_bowl_s_share_of_rays_is_its_opening_s_solid_angle() -> None:
    ball = sphere(0.05, facet_mm=0.05)
    keep = ball.vertices[ball.faces].mean(axis=1)[:, 2] < 0.025  # a cap of 60° is cut away
    bowl = Surface(ball.vertices, ball.faces[keep])
    with pytest.raises(GoalError, match=r"the virtual object .*: 2[45].\d\d% of rays do not cross"):
        made(CUBE, bowl, centre=(0, 0, 0))


def test_a_hole_that_no_test_ray_finds_is_told_where_a_point_needs_it() -> None:
    ball = sphere(0.05, facet_mm=0.01)
    middles = ball.vertices[ball.faces].mean(axis=1)
    middles /= np.linalg.norm(middles, axis=1)[:, None]
    to_ray = cKDTree(even_directions(10_000)).query(middles)[0]
    hole = int(to_ray.argmax())
    pierced = Surface(ball.vertices, np.delete(ball.faces, hole, axis=0))
    # A tetrahedron with a corner in the hole's direction.
    first = np.cross(middles[hole], np.eye(3)[np.abs(middles[hole]).argmin()])
    first /= np.linalg.norm(first)
    second = np.cross(middles[hole], first)
    turns = 2 * np.pi * np.arange(3) / 3
    base = np.outer(np.cos(turns), first) + np.outer(np.sin(turns), second) - 0.5 * middles[hole]
    corners = 0.03 * np.concatenate([middles[hole : hole + 1], base])
    prop = Surface(corners, np.array([(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)]))
    with pytest.raises(
        GoalError,
        match=r"the ray from \(0, 0, 0\) mm along \(.*\) crosses the virtual object 0 times, and "
        r"so do 1 of 4; once is needed. Close holes in the mesh, or choose another centre",
    ):
        made(prop, pierced, centre=(0, 0, 0))
