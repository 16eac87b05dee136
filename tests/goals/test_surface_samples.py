"""Samples are uniform in area, carry their goals, and find the sharp edges."""

from __future__ import annotations

import numpy as np
import pytest

from touchwarp.goals import Goal
from touchwarp.goals.surface_samples import find_sharp_edges, sample_surface
from touchwarp.scene.shapes import box, cylinder, polygon, sphere


def goal_of(surface, A=None) -> Goal:
    A = np.eye(surface.dimension) if A is None else A
    return Goal(surface.vertices, surface.vertices @ A.T, surface.faces)


def test_each_side_of_a_box_has_its_share() -> None:
    taken = sample_surface(goal_of(box([0.1, 0.2, 0.3])), 22_000, np.random.default_rng(0))
    on_x = np.isclose(np.abs(taken.points[:, 0]), 0.05)
    # 2 · 0.06 of 0.22 m²; stratified, so off by no more than a sample or two a face
    assert on_x.sum() == pytest.approx(12_000, abs=12)
    assert np.abs(taken.points[on_x, 1]).mean() == pytest.approx(0.05, rel=0.02)
    assert np.abs(np.einsum("ij,ij->i", taken.normals, np.sign(taken.points))).min() > 0.99


def test_targets_are_the_goals_at_the_points() -> None:
    A = np.array([[1.2, 0.1, 0], [0, 0.9, 0.3], [0.1, 0, 1.1]])
    taken = sample_surface(goal_of(sphere(0.05), A), 5000, np.random.default_rng(0))
    assert taken.targets == pytest.approx(taken.points @ A.T, abs=1e-15)


def test_the_same_seed_gives_the_same_points() -> None:
    one, two, other = (
        sample_surface(goal_of(sphere(0.05)), 2000, np.random.default_rng(seed)).points
        for seed in (3, 3, 4)
    )
    assert np.array_equal(one, two)
    assert not np.array_equal(one, other)


def test_a_box_has_twelve_sharp_edges_and_no_diagonals() -> None:
    surface = box([0.1, 0.2, 0.3])
    edges = find_sharp_edges(surface.vertices, surface.faces)
    assert len(edges.ends) == 12
    assert edges.length.sum() == pytest.approx(4 * 0.6)
    assert edges.turn == pytest.approx(np.full(12, np.pi / 2))
    assert not edges.rim.any()


def test_unwelded_triangles_share_their_edges() -> None:
    surface = box([0.1, 0.2, 0.3])
    soup = surface.vertices[surface.faces].reshape(-1, 3)
    edges = find_sharp_edges(soup, np.arange(36).reshape(12, 3))
    assert (len(edges.ends), int(edges.rim.sum())) == (12, 0)


def test_a_round_body_has_none_and_an_open_one_has_rims() -> None:
    ball = sphere(0.05, 0.1)
    assert len(find_sharp_edges(ball.vertices, ball.faces).ends) == 0
    upper = ball.faces[(ball.vertices[ball.faces][:, :, 2] > -1e-9).all(axis=1)]
    edges = find_sharp_edges(ball.vertices, upper)
    assert edges.rim.all()
    assert edges.length.sum() == pytest.approx(2 * np.pi * 0.05, rel=0.15)


def test_a_cylinders_caps_are_its_edges() -> None:
    surface = cylinder(0.04, 0.1)
    edges = find_sharp_edges(surface.vertices, surface.faces)
    assert edges.length.sum() == pytest.approx(4 * np.pi * 0.04, rel=1e-3)
    points, targets = edges.sample(goal_of(surface), 1000, np.random.default_rng(0))
    assert np.hypot(points[:, 0], points[:, 1]) == pytest.approx(np.full(1000, 0.04), rel=1e-3)
    assert np.array_equal(points, targets)


def test_neighbours_wound_against_each_other_are_not_sharp_for_that() -> None:
    flat = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    faces = np.array([[0, 1, 2], [0, 3, 2]])
    edges = find_sharp_edges(flat, faces)
    assert edges.rim.sum() == len(edges.ends) == 4


def test_polygons_have_corners() -> None:
    square = polygon([[0, 0], [0.1, 0], [0.1, 0.1], [0, 0.1]])
    edges = find_sharp_edges(square.vertices, square.faces)
    assert sorted(edges.ends[:, 0].tolist()) == [0, 1, 2, 3]
    taken = sample_surface(goal_of(square), 400, np.random.default_rng(0))
    assert np.isclose(taken.points[:, 1], 0).sum() == pytest.approx(100, abs=2)
    assert taken.normals[np.isclose(taken.points[:, 1], 0)][0] == pytest.approx([0, -1])
