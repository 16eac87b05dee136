"""Shapes have their stated sizes, are closed and turned outward, and facets stay small."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from touchwarp.errors import SceneError
from touchwarp.scene import Surface
from touchwarp.scene.shapes import (
    box,
    circle_segments,
    cylinder,
    ellipsoid,
    fillet_box,
    make_shape,
    polygon,
    sphere,
)
from touchwarp.scene.topology import bodies, edge_counts

# kind, keys, extent in mm, least z in mm, volume in mm³ or None
SHAPES: list[tuple[str, dict[str, Any], tuple[float, float, float], float, float | None]] = [
    ("box", {"size": (0.1, 0.2, 0.3)}, (100, 200, 300), -150, 6e6),
    ("sphere", {"radius": 0.05}, (100, 100, 100), -50, 4 / 3 * math.pi * 50**3),
    ("ellipsoid", {"size": (0.1, 0.06, 0.04)}, (100, 60, 40), -20, math.pi / 6 * 100 * 60 * 40),
    ("cylinder", {"radius": 0.04, "height": 0.1}, (80, 80, 100), 0, math.pi * 40**2 * 100),
    (
        "fillet_box",
        {"size": (0.1, 0.08, 0.06), "fillet": 0.03},
        (100, 80, 60),
        -30,
        (100 * 80 - (1 - math.pi / 4) * 30**2) * 60,
    ),
    ("mug", {}, (114.5, 80, 95), 0, None),
    ("tea_cup", {}, (123, 104, 58), 0, None),
]


def volume(surface: Surface) -> float:
    """m³; positive where faces are turned outward."""
    return float(np.linalg.det(surface.vertices[surface.faces]).sum() / 6)


def genus(surface: Surface) -> int:
    edges, counts = edge_counts(surface.faces)
    assert (counts == 2).all()
    assert bodies(surface.faces).max() == 0
    return (2 - (len(surface.vertices) - len(edges) + len(surface.faces))) // 2


def facet_error(surface: Surface, half: np.ndarray) -> float:
    """Greatest distance of facet centres and edge middles from an ellipsoid's surface, m."""
    corners = surface.vertices[surface.faces]
    inner = np.concatenate(
        [corners.mean(axis=1), (corners + np.roll(corners, 1, 1)).reshape(-1, 3) / 2]
    )
    on_unit = inner / half
    level = np.linalg.norm(on_unit, axis=1)
    gradient = np.linalg.norm(on_unit / half / level[:, None], axis=1)
    return float((np.abs(1 - level) / gradient).max())


@pytest.mark.parametrize(("kind", "keys", "extent", "low", "expected"), SHAPES)
def test_shapes_have_their_stated_size_and_place(
    kind: str,
    keys: dict[str, Any],
    extent: tuple[float, float, float],
    low: float,
    expected: float | None,
) -> None:
    surface = make_shape(kind, keys)
    bounds = surface.bounds * 1e3
    assert np.ptp(bounds, axis=0) == pytest.approx(extent, abs=0.15)
    assert bounds[0, 2] == pytest.approx(low, abs=1e-9 if kind != "sphere" else 0.02)
    assert genus(surface) == (1 if kind in ("mug", "tea_cup") else 0)
    assert volume(surface) > 0
    if expected is not None:
        assert volume(surface) * 1e9 == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize("size", [(0.1, 0.1, 0.1), (0.3, 0.1, 0.05), (0.02, 0.03, 0.04)])
@pytest.mark.parametrize("facet_mm", [0.02, 0.1])
def test_facets_stay_within_their_bound(size: tuple[float, ...], facet_mm: float) -> None:
    surface = ellipsoid(size, facet_mm)
    error = facet_error(surface, np.array(size) / 2)
    assert error <= facet_mm * 1e-3
    assert np.linalg.norm(surface.vertices / (np.array(size) / 2), axis=1) == pytest.approx(1.0)


def test_the_facet_claim_rejects_half_the_bound() -> None:
    assert facet_error(sphere(0.05, 0.02), np.full(3, 0.05)) > 0.01e-3


def test_a_hand_sized_sphere_has_a_moderate_count() -> None:
    assert len(sphere(0.05).faces) < 20_000


def test_circles_are_cut_finely_enough() -> None:
    n = circle_segments(0.04, 0.02)
    assert n % 4 == 0
    assert 0.04 * (1 - math.cos(math.pi / n)) <= 0.02e-3
    assert 0.04 * (1 - math.cos(math.pi / (n - 4))) > 0.02e-3


def test_only_one_edge_of_the_fillet_box_is_round() -> None:
    vertices = fillet_box((0.1, 0.1, 0.1), 0.02).vertices
    corners = {tuple(np.sign(v[:2])) for v in vertices if (np.abs(v[:2]) > 0.0499).all()}
    assert corners == {(-1, 1), (-1, -1), (1, -1)}


def test_the_handle_leaves_room_for_a_finger() -> None:
    vertices = make_shape("mug", {}).vertices * 1e3
    middle = vertices[(np.abs(vertices[:, 2] - 48.5) < 15) & (vertices[:, 0] > 41)]
    assert middle[:, 0].min() - 40 > 20


def test_a_polygon_closes_itself() -> None:
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    assert polygon(square).faces.tolist() == [[0, 1], [1, 2], [2, 3], [3, 0]]
    assert polygon([*square, square[0]]).faces.tolist() == polygon(square).faces.tolist()


@pytest.mark.parametrize(
    ("corners", "message"),
    [
        ([(0, 0), (1, 0), (0, 0)], "a polygon has 2 corners; at least 3 are needed"),
        ([(0, 0), (1, 0), (1, 0), (0, 1)], "corner 2 of a polygon is repeated by the next"),
        ([(0, 0, 0), (1, 0, 0)], r"a polygon has shape \(2, 3\); \(n, 2\) is needed"),
    ],
)
def test_bad_polygons_are_refused(corners: list[tuple[float, ...]], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        polygon(corners)


def test_bad_shapes_are_refused() -> None:
    with pytest.raises(SceneError, match=r"a shape's size is \[1.0, 0.0, 1.0\]; 3 finite numbers"):
        box((1, 0, 1))
    with pytest.raises(SceneError, match="a shape's radius is nan; a finite number > 0 is needed"):
        sphere(math.nan)
    with pytest.raises(SceneError, match=r"a shape's height is -1.0"):
        cylinder(1, -1)
    with pytest.raises(SceneError, match=r"the fillet is 0.1 m, but the box is 0.1 × 0.2 m"):
        fillet_box((0.1, 0.2, 0.3), 0.1)
    with pytest.raises(SceneError, match="'radius' is missing; a sphere needs it"):
        make_shape("sphere", {})
