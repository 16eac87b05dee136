"""Subdivision follows a curved image as closely as asked, and leaves the prop as it is."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from touchwarp.goals.subdivision import Subdivided, subdivide
from touchwarp.goals.surface_samples import face_areas
from touchwarp.scene import Surface
from touchwarp.scene.shapes import box, sphere
from touchwarp.scene.topology import open_edge_count

CUBE = box((0.1, 0.1, 0.1))
BALL = sphere(0.06, facet_mm=0.002)


def onto_ball(faces: Any, places: Any) -> Any:
    points = np.einsum("kc,kcd->kd", places, CUBE.vertices[CUBE.faces[faces]])
    return 0.06 * points / np.linalg.norm(points, axis=1)[:, None]


def strays(fine: Subdivided) -> float:
    """The greatest distance of the straight image from the true ball, at many points."""
    rng = np.random.default_rng(1)
    weights = rng.dirichlet((1, 1, 1), 20)
    at = np.einsum("pc,fcd->fpd", weights, fine.virtual_points[fine.faces])
    return float(np.abs(np.linalg.norm(at, axis=2) - 0.06).max())


@pytest.mark.parametrize("virtual", [BALL, None])
@pytest.mark.parametrize("tolerance", [5e-4, 5e-5])
def test_the_image_lies_on_the_virtual_surface(virtual: Surface | None, tolerance: float) -> None:
    fine = subdivide(CUBE.vertices, CUBE.faces, onto_ball, virtual, tolerance)
    assert fine.distance <= tolerance
    assert not fine.capped
    assert strays(fine) <= 1.3 * tolerance + 2e-6  # between the places that it looked at
    assert strays(fine) > 0.3 * tolerance  # no finer than needed


def test_the_claim_rejects_the_cube_as_it_was() -> None:
    fine = subdivide(CUBE.vertices, CUBE.faces, onto_ball, BALL, 0.1)
    assert len(fine.faces) == 12
    assert strays(fine) > 1e-2


def test_the_prop_keeps_its_shape_and_stays_closed() -> None:
    fine = subdivide(CUBE.vertices, CUBE.faces, onto_ball, BALL, 1e-4)
    np.testing.assert_array_equal(fine.points[:8], CUBE.vertices)
    np.testing.assert_allclose(np.abs(fine.points).max(axis=1), 0.05, rtol=1e-12)
    assert open_edge_count(fine.faces) == 0
    area = np.bincount(fine.parents, face_areas(fine.points, fine.faces))
    np.testing.assert_allclose(area, 0.005, rtol=1e-12)
    # The angles of a halved right triangle never fall below half of 45°, by Rivara's bound.
    corners = fine.points[fine.faces]
    sides = np.roll(corners, -1, axis=1) - corners
    sides /= np.linalg.norm(sides, axis=2)[..., None]
    cosines = -(sides * np.roll(sides, 1, axis=1)).sum(axis=2)
    assert np.rad2deg(np.arccos(cosines.max())) > 22.4


def test_every_point_s_image_is_g_there() -> None:
    fine = subdivide(CUBE.vertices, CUBE.faces, onto_ball, BALL, 1e-4)
    expected = 0.06 * fine.points / np.linalg.norm(fine.points, axis=1)[:, None]
    np.testing.assert_allclose(fine.virtual_points, expected, atol=1e-15)


def test_a_linear_goal_needs_no_subdivision() -> None:
    def stretched(faces: Any, places: Any) -> Any:
        return 1.5 * np.einsum("kc,kcd->kd", places, CUBE.vertices[CUBE.faces[faces]])

    for virtual in (box((0.15, 0.15, 0.15)), None):
        fine = subdivide(CUBE.vertices, CUBE.faces, stretched, virtual, 1e-6)
        assert len(fine.faces) == 12
        assert fine.distance < 1e-15


def test_the_number_of_faces_is_bounded_and_the_bound_is_told() -> None:
    fine = subdivide(CUBE.vertices, CUBE.faces, onto_ball, BALL, 1e-5, most_faces=1000)
    assert fine.capped
    assert len(fine.faces) <= 1000
    assert fine.distance == pytest.approx(strays(fine), rel=0.3)
    assert fine.report == {"image_distance_max": fine.distance, "subdivision_capped": True}


def test_a_torn_goal_is_not_halved_for_ever() -> None:
    def torn(faces: Any, places: Any) -> Any:
        points = np.einsum("kc,kcd->kd", places, CUBE.vertices[CUBE.faces[faces]])
        return points + 0.05 * (points[:, :1] > 0.013)

    fine = subdivide(CUBE.vertices, CUBE.faces, torn, None, 2e-3)
    assert fine.distance > 2e-3


def test_unused_points_stay_where_they_are() -> None:
    points = np.concatenate([CUBE.vertices, [[7.0, 8.0, 9.0]]])
    fine = subdivide(points, CUBE.faces, onto_ball, BALL, 1e-3)
    np.testing.assert_array_equal(fine.virtual_points[8], [7, 8, 9])
