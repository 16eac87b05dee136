"""Gaps between surfaces against answers known by construction."""

from __future__ import annotations

import numpy as np
import pytest

from touchwarp.scene import Prop, Scene, Surface, closest_props, pose_matrix
from touchwarp.scene.distance import body_points, inside, surface_gap
from touchwarp.scene.shapes import box, polygon, sphere


def moved(surface: Surface, *position: float, turn: object = None) -> Surface:
    angles = turn if turn is not None else (0.0 if len(position) == 2 else (0, 0, 0))
    return surface.transformed(pose_matrix(position, angles))  # type: ignore[arg-type]


CUBE = box((0.1, 0.1, 0.1))
SQUARE = polygon([(0, 0), (1, 0), (1, 1), (0, 1)])


@pytest.mark.parametrize(
    ("other", "gap"),
    [
        (moved(CUBE, 0.15, 0, 0), 0.05),
        (moved(CUBE, 0.13, 0.14, 0), 0.05),
        (moved(CUBE, 0.1, 0, 0), 0.0),
        (moved(CUBE, 0.05, 0.02, 0.01), 0.0),
        (box((0.06, 0.06, 0.06)), 0.02),  # inside: measured like any other
        (moved(sphere(0.02), 0.08, 0, 0), 0.01),
        (moved(CUBE, 0.05 + 0.05 * np.sqrt(2) + 1e-4, 0, 0, turn=(0, 0, 45)), 1e-4),
    ],
)
def test_gaps_in_space(other: Surface, gap: float) -> None:
    assert surface_gap(CUBE, other) == pytest.approx(gap, abs=2e-5 if gap == 0.01 else 1e-9)
    assert surface_gap(other, CUBE) == pytest.approx(surface_gap(CUBE, other), abs=1e-9)


@pytest.mark.parametrize(
    ("other", "gap"),
    [
        (moved(SQUARE, 1.5, 0.2), 0.5),
        (moved(SQUARE, 1.3, 1.4), 0.5),
        (moved(SQUARE, 1.0, 0.5), 0.0),
        (moved(SQUARE, 0.5, 0.5), 0.0),
        (polygon([(0.2, 0.3), (0.6, 0.3), (0.4, 0.6)]), 0.2),
    ],
)
def test_gaps_in_the_plane(other: Surface, gap: float) -> None:
    assert surface_gap(SQUARE, other) == pytest.approx(gap, abs=1e-12)


def test_the_closest_pair_is_found_among_many() -> None:
    places = {"a": 0.0, "b": 0.2, "c": 0.31, "d": 0.5}
    scene = Scene([Prop(name, moved(CUBE, x, 0, 0)) for name, x in places.items()])
    name_a, name_b, gap = closest_props(scene) or ("", "", -1.0)
    assert (name_a, name_b) == ("b", "c")
    assert gap == pytest.approx(0.01)
    assert closest_props(scene, limit=0.009) is None
    assert closest_props(scene, limit=0.011) is not None


def test_a_limit_saves_work_but_changes_no_gap_below_it() -> None:
    near = moved(CUBE, 0.15, 0, 0)
    assert surface_gap(CUBE, near, limit=0.06) == pytest.approx(0.05)
    assert surface_gap(CUBE, near, limit=0.04) > 0.04
    assert surface_gap(CUBE, box((0.06, 0.06, 0.06)), limit=0.001) > 0.001


def test_one_prop_has_no_gap() -> None:
    assert closest_props(Scene([Prop("a", CUBE)])) is None


def test_points_inside_a_closed_surface() -> None:
    points = np.array([[0, 0, 0], [0.049, 0.049, 0.049], [0.051, 0, 0], [1, 1, 1]])
    turned_in = Surface(CUBE.vertices, CUBE.faces[:, ::-1])
    for surface in (CUBE, turned_in):
        assert inside(points, surface).tolist() == [True, True, False, False]
    assert inside(np.array([[0.5, 0.1], [1.1, 0.5]]), SQUARE).tolist() == [True, False]


def test_every_body_gives_a_point() -> None:
    two = Surface(
        np.concatenate([CUBE.vertices, CUBE.vertices + 1]),
        np.concatenate([CUBE.faces, CUBE.faces + 8]),
    )
    assert body_points(two).shape == (2, 3)
    assert sorted(body_points(two)[:, 0] > 0.5) == [False, True]
