"""Inside or outside, by rays, agrees with closed forms and with the solid angle."""

from __future__ import annotations

import igl
import numpy as np
import pytest

from touchwarp.check.winding import Windings
from touchwarp.scene.shapes import box, cylinder, make_shape, polygon, sphere

RNG = np.random.default_rng(1)
POINTS = RNG.uniform(-0.07, 0.07, (20_000, 3))


def test_inside_of_a_box_is_exact() -> None:
    surface = box([0.1, 0.08, 0.06])
    inside = Windings(surface.vertices, surface.faces).at(POINTS)
    assert np.array_equal(inside, (np.abs(POINTS) < [0.05, 0.04, 0.03]).all(axis=1).astype(float))


def test_points_level_with_vertices_and_edges_are_decided() -> None:
    surface = box([0.1, 0.1, 0.1])
    # rays through these meet diagonals, edges and corners
    points = np.array([[0, 0, 0], [0.01, 0.01, 0], [0.05, 0.0, 0.06], [0.06, 0.05, 0.05]])
    assert Windings(surface.vertices, surface.faces).at(points).tolist() == [1, 1, 0, 0]


def test_a_body_turned_inside_out_winds_the_other_way() -> None:
    surface = sphere(0.05, 0.1)
    winding = Windings(surface.vertices, surface.faces[:, ::-1]).at(POINTS)
    r = np.linalg.norm(POINTS, axis=1)
    assert (winding[r < 0.049] == -1).all()
    assert (winding[r > 0.051] == 0).all()


def test_bodies_that_overlap_count_twice() -> None:
    one = sphere(0.05, 0.1)
    vertices = np.concatenate([one.vertices, one.vertices + np.array([0.03, 0, 0])])
    faces = np.concatenate([one.faces, one.faces + len(one.vertices)])
    winding = Windings(vertices, faces).at(np.array([[0.015, 0, 0], [-0.04, 0, 0], [0.09, 0, 0]]))
    assert winding.tolist() == [2, 1, 0]


@pytest.mark.parametrize("shape", ["mug", "tea_cup"])
def test_a_mug_agrees_with_the_solid_angle(shape: str) -> None:
    surface = make_shape(shape, {})
    low, high = surface.bounds
    points = RNG.uniform(low, high, (1000, 3))
    mine = Windings(surface.vertices, surface.faces).at(points) > 0.5
    exact = igl.fast_winding_number(surface.vertices, surface.faces, points) > 0.5
    assert np.array_equal(mine, exact)


def test_a_hole_is_bridged_by_the_solid_angle() -> None:
    surface = cylinder(0.04, 0.1, 0.2)
    turn = np.arctan2(*surface.vertices[surface.faces].mean(axis=1).T[[1, 0]])
    holed = surface.faces[
        ~(
            (np.abs(turn) < 0.2)
            & (np.abs(surface.vertices[surface.faces].mean(axis=1)[:, 2] - 0.05) < 0.04)
        )
    ]
    assert len(holed) < len(surface.faces)
    winding = Windings(surface.vertices, holed).at(
        np.array([[-0.02, 0.0, 0.05], [-0.045, 0.0, 0.05], [0.0, 0.03, 0.09]])
    )
    assert (winding > 0.5).tolist() == [True, False, True]


def test_polygons_in_the_plane() -> None:
    ell = polygon([[0, 0], [0.1, 0], [0.1, 0.03], [0.03, 0.03], [0.03, 0.1], [0, 0.1]])
    points = np.array([[0.01, 0.01], [0.09, 0.01], [0.05, 0.05], [0.2, 0.01]])
    assert Windings(ell.vertices, ell.faces).at(points) == pytest.approx([1, 1, 0, 0])


def test_no_points_no_windings() -> None:
    surface = box([1, 1, 1])
    assert Windings(surface.vertices, surface.faces).at(np.empty((0, 3))).shape == (0,)
