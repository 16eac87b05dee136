"""Stretch, area and energy of linear maps on any triangles, against the maps themselves."""

from __future__ import annotations

import numpy as np
import pytest

from touchwarp.goals import Goal
from touchwarp.goals.surface_samples import face_areas, face_normals
from touchwarp.goals.tangent_map import displacement_gradients, stretches, tangent_maps

RNG = np.random.default_rng(0)
POINTS = RNG.normal(size=(60, 3))
FACES = np.arange(60).reshape(-1, 3)
A = RNG.normal(size=(3, 3))
TURN = np.linalg.qr(RNG.normal(size=(3, 3)))[0]


def goal(linear: np.ndarray) -> Goal:
    return Goal(POINTS, POINTS @ linear.T + [1.0, 2.0, 3.0], FACES)


def test_stretches_are_those_of_the_map_on_the_plane() -> None:
    found = stretches(tangent_maps(goal(A)))
    normals = face_normals(POINTS, FACES)
    for stretch, normal in zip(found, normals, strict=True):
        plane = np.linalg.svd(normal[None])[2][1:]
        assert stretch == pytest.approx(np.linalg.svd(A @ plane.T, compute_uv=False), rel=1e-9)


def test_their_product_is_the_ratio_of_areas() -> None:
    found = stretches(tangent_maps(goal(A))).prod(axis=1)
    image = face_areas(POINTS @ A.T, FACES)
    assert found == pytest.approx(image / face_areas(POINTS, FACES), rel=1e-9)


@pytest.mark.parametrize("least", [1.0, 1e-6])
def test_the_lesser_stretch_keeps_its_digits_beside_a_far_greater_one(least: float) -> None:
    maps = TURN[None, :, :2] * [1e3, least] @ np.array([[0.6, -0.8], [0.8, 0.6]])
    found = stretches(maps)[0]
    assert found == pytest.approx([1e3, least], rel=1e-6)
    # the twin: the roots of the Gram matrix lose the lesser one
    roots = np.sqrt(np.abs(np.linalg.eigvalsh(maps[0].T @ maps[0])))
    assert (roots[0] == pytest.approx(least, rel=1e-6)) == (least == 1.0)


def test_energies_of_linear_maps() -> None:
    given = goal(A)
    forward, backward = displacement_gradients(given, tangent_maps(given))
    normals, image_normals = face_normals(POINTS, FACES), face_normals(POINTS @ A.T, FACES)
    for k in range(len(FACES)):
        plane = np.eye(3) - np.outer(normals[k], normals[k])
        assert forward[k] == pytest.approx(((A - np.eye(3)) @ plane).__pow__(2).sum(), rel=1e-9)
        image_plane = np.eye(3) - np.outer(image_normals[k], image_normals[k])
        change = (np.linalg.inv(A) - np.eye(3)) @ image_plane
        assert backward[k] == pytest.approx((change**2).sum(), rel=1e-7)


def test_rigid_motions_stretch_nothing_and_translations_cost_nothing() -> None:
    turned = goal(TURN)
    assert stretches(tangent_maps(turned)) == pytest.approx(np.ones((20, 2)), rel=1e-9)
    assert min(displacement_gradients(turned, tangent_maps(turned))[0]) > 0.1
    moved = goal(np.eye(3))
    for energy in displacement_gradients(moved, tangent_maps(moved)):
        assert np.abs(energy).max() < 1e-20


def test_the_inverse_s_energy_is_that_of_the_inverse_map() -> None:
    there = goal(A)
    back = Goal(there.virtual_points, there.prop_points, FACES)
    _, backward = displacement_gradients(there, tangent_maps(there))
    forward, _ = displacement_gradients(back, tangent_maps(back))
    assert backward == pytest.approx(forward, rel=1e-7)


def test_faces_without_area_are_set_apart() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 0, 0], [0, 1, 0]], float)
    faces = np.array([[0, 1, 2], [0, 3, 1], [0, 1, 4]])
    found = stretches(tangent_maps(Goal(points, 2 * points, faces)))
    assert np.isnan(found[:2]).all()
    assert found[2] == pytest.approx([2, 2])


def test_a_collapsed_image_has_no_smooth_inverse() -> None:
    flat = goal(np.diag([1.0, 1.0, 0.0]) @ np.diag([1.0, 0.0, 0.0]))
    _, backward = displacement_gradients(flat, tangent_maps(flat))
    assert (backward > 1e12).all()
