"""Probes fill Ω: their volumes add up, and sums over them are integrals."""

from __future__ import annotations

import numpy as np
import pytest

from tests.check.stand_ins import BOX, Still, ball, ball_scene, ball_warp, block_scene, case_of
from touchwarp.check.probes import determinants, singular_values
from touchwarp.check.region import make_body
from touchwarp.goals import Goal
from touchwarp.goals.surface_samples import sample_surface
from touchwarp.scene import Outer
from touchwarp.scene.shapes import sphere

BALL_VOLUME = 4 / 3 * np.pi * 0.05**3


def test_volumes_add_up_to_the_region() -> None:
    probes = case_of(ball_scene(), ball_warp()).probes
    assert probes.volume.sum() == pytest.approx(np.ptp(BOX, axis=0).prod() - BALL_VOLUME, rel=1e-3)
    r = np.linalg.norm(probes.points, axis=1)
    assert r.min() > 0.0495
    # half of the points are within a tenth or so of the ball's size
    assert np.median(r) < 0.056


def test_a_mesh_as_outer_boundary_and_a_plane_cut_the_region() -> None:
    scene = ball_scene(outer=Outer(surface=sphere(0.2, 0.2)))
    probes = case_of(scene, ball_warp()).probes
    assert probes.volume.sum() == pytest.approx(4 / 3 * np.pi * 0.2**3 - BALL_VOLUME, rel=5e-3)
    case = case_of(block_scene(), Still())
    assert (case.probes.points[:, 2] > 0).all()


def test_an_integral_over_the_region() -> None:
    probes = case_of(ball_scene(), ball_warp()).probes
    r = np.linalg.norm(probes.points, axis=1)
    within = r < 0.2
    # ∫ 1/r² over the shell from 0.05 to 0.2 is 4π · 0.15
    assert (probes.volume[within] @ r[within] ** -2) == pytest.approx(4 * np.pi * 0.15, rel=3e-3)


def test_determinants_and_singular_values_agree_with_numpy() -> None:
    rng = np.random.default_rng(0)
    for d in (2, 3):
        J = rng.standard_normal((50, d, d))
        assert determinants(J) == pytest.approx(np.linalg.det(J))
        assert singular_values(J) == pytest.approx(np.linalg.svd(J, compute_uv=False))


def body_of(vertices, faces):
    still = Goal(vertices, vertices, faces)
    return make_body("it", vertices, faces, sample_surface(still, 2000, np.random.default_rng(0)))


def test_an_open_bowl_has_no_inside() -> None:
    surface = ball()
    bowl = surface.faces[(surface.vertices[surface.faces][:, :, 2] < 1e-9).all(axis=1)]
    body = body_of(surface.vertices, bowl)
    assert not body.closed
    assert not body.inside(np.array([[0, 0, -0.03]])).any()


def test_a_small_hole_leaves_the_inside() -> None:
    body = body_of(ball().vertices, ball().faces[3:])
    assert body.closed
    assert body.inside(np.array([[0, 0, -0.03]])).all()


def test_inward_normals_are_noticed() -> None:
    assert body_of(ball().vertices, ball().faces).outward == 1.0
    assert body_of(ball().vertices, ball().faces[:, ::-1].copy()).outward == -1.0


def test_distances_rays_and_segments() -> None:
    body = body_of(ball().vertices, ball().faces)
    distance, nearest, _ = body.nearest(np.array([[0.1, 0, 0], [0, 0.02, 0]]))
    assert distance == pytest.approx([0.05, 0.03], abs=3e-4)
    assert nearest[0] == pytest.approx([0.05, 0, 0], abs=1e-3)
    hit = body.first_hit(
        np.array([[0.2, 0.001, 0], [0.2, 0.001, 0]]), np.array([[-1.0, 0, 0], [1, 0, 0]])
    )
    assert hit == pytest.approx([0.15, np.inf], abs=3e-4)
