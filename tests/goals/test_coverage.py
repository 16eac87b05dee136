"""Flips, holes and double layers are found, each with its size."""

from __future__ import annotations

import math

import numpy as np
import pytest

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
from touchwarp.goals.coverage import Coverage, cover
from touchwarp.goals.surface_tree import SurfaceTree
from touchwarp.scene.shapes import make_shape

MAPS = {"ellipsoid": ellipsoid_map(), "cube": cube_map()}


def covering(goal: Goal, samples: int = 20_000) -> Coverage:
    virtual = goal.virtual_surface
    assert virtual is not None
    return cover(goal, virtual, SurfaceTree(virtual.vertices, virtual.faces), samples, 0)


@pytest.mark.parametrize("name", MAPS)
def test_a_bijection_covers_all_and_flips_nothing(name: str) -> None:
    found = covering(MAPS[name])
    assert found.covered.all()
    assert not found.flipped.any()
    assert found.handedness == 1.0


@pytest.mark.parametrize("name", MAPS)
def test_one_flipped_face_is_found(name: str) -> None:
    found = covering(with_one_flip(MAPS[name]))
    assert found.flipped[0]
    assert 1 <= found.flipped.sum() <= 4


def test_a_collapsed_face_counts_as_flipped() -> None:
    goal = ellipsoid_map()
    images = goal.virtual_points.copy()
    a, b, _ = goal.faces[7]
    images[a] = images[b]
    found = covering(
        Goal(goal.prop_points, images, goal.faces, virtual_surface=goal.virtual_surface)
    )
    assert found.flipped[7]


@pytest.mark.parametrize("radius", [0.03, 0.004])
def test_a_hole_in_coverage_has_its_area(radius: float) -> None:
    # a cap of a sphere has the area π c², c the distance from its pole to its rim
    goal = with_a_hole(identity_map(ball(0.01)), np.array([0.0, 0.0, RADIUS]), radius)
    found = covering(goal, 200_000)
    share = math.pi * radius**2 / (4 * math.pi * RADIUS**2)
    spread = 2 * math.sqrt(share / 200_000) + 2 * radius * 6e-4 / (4 * RADIUS**2)
    assert 1 - found.covered.mean() == pytest.approx(share, abs=spread)
    assert (
        np.linalg.norm(found.points[~found.covered] - [0, 0, RADIUS], axis=1).max() < radius + 2e-3
    )


def test_a_mirrored_map_is_no_flip_but_of_the_other_hand() -> None:
    surface = ball()
    mirrored = Goal(
        surface.vertices, surface.vertices * [-1, 1, 1], surface.faces, virtual_surface=surface
    )
    found = covering(mirrored)
    assert found.handedness == -1.0
    assert not found.flipped.any()
    assert found.covered.mean() > 0.9999


def test_a_map_onto_half_covers_half() -> None:
    """The lower half is folded up onto the upper one: a closed image that covers one half only."""
    surface = ball(0.02)
    images = surface.vertices.copy()
    images[:, 2] = np.abs(images[:, 2])
    found = covering(Goal(surface.vertices, images, surface.faces, virtual_surface=surface))
    assert found.covered.mean() == pytest.approx(0.5, abs=0.01)
    assert found.flipped.mean() == pytest.approx(0.5, abs=0.02)


def test_the_other_side_of_a_thin_wall_does_not_cover() -> None:
    """Only the outer half of a cup's wall is mapped; the inner one, 3 mm behind, is not covered."""
    cup = make_shape("tea_cup", {})
    inside = np.hypot(*cup.vertices[cup.faces].mean(axis=1)[:, :2].T) < 0.6 * cup.bounds[1, 1]
    goal = identity_map(cup)
    found = covering(
        Goal(goal.prop_points, goal.virtual_points, cup.faces[~inside], virtual_surface=cup)
    )
    near = SurfaceTree(cup.vertices, cup.faces).nearest(found.points).elements
    # but for a seam beside the mapped half
    assert found.covered[inside[near]].mean() < 0.02
    assert found.covered[~inside[near]].mean() > 0.999


def test_winding_twice_round_is_no_flip_and_no_hole() -> None:
    # what tells is the area: see test_measure
    found = covering(doubled(identity_map(ball(0.01))))
    assert found.covered.mean() > 0.99
    assert found.flipped.mean() < 0.01
