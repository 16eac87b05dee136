"""What a surface map takes, and what it refuses with a way out."""

from __future__ import annotations

import numpy as np
import pytest

from touchwarp.errors import GoalError
from touchwarp.goals.maps.closed_mesh import closed_mesh
from touchwarp.goals.maps.parameterise import check_topology
from touchwarp.scene.shapes import box, polygon, sphere
from touchwarp.scene.surface import Surface

from .conftest import ring_surface, two_holed_surface

BOX = box([0.1, 0.08, 0.06])


@pytest.mark.parametrize(
    ("surface", "genus"), [(BOX, 0), (ring_surface(), 1), (two_holed_surface(), 2)]
)
def test_genus_is_that_of_the_shape(surface: Surface, genus: int) -> None:
    assert closed_mesh(surface, "the prop").genus == genus


def test_a_mesh_turned_inward_is_turned_outward() -> None:
    mesh = closed_mesh(Surface(BOX.vertices, BOX.faces[:, ::-1]), "the prop")
    outward = (mesh.face_normals * mesh.vertices[mesh.faces].mean(axis=1)).sum(axis=1)
    assert (outward > 0).all()


def test_areas_and_angles_are_those_of_the_box() -> None:
    mesh = closed_mesh(BOX, "the prop")
    assert mesh.area == pytest.approx(2 * (0.1 * 0.08 + 0.1 * 0.06 + 0.08 * 0.06))
    assert mesh.corner_angles.sum(axis=1) == pytest.approx(np.pi)
    assert mesh.vertex_areas.sum() == pytest.approx(mesh.area)


def test_neighbours_share_the_edge_opposite_their_corner() -> None:
    mesh = closed_mesh(BOX, "the prop")
    for face, across in enumerate(mesh.neighbours):
        for k in range(3):
            edge = {int(mesh.faces[face, k - 2]), int(mesh.faces[face, k - 1])}
            assert edge <= set(mesh.faces[across[k]].tolist())


def pinched() -> Surface:
    other = -BOX.vertices + 2 * BOX.vertices[7]
    return Surface(
        np.concatenate([BOX.vertices, other]), np.concatenate([BOX.faces, BOX.faces[:, ::-1] + 8])
    )


@pytest.mark.parametrize(
    ("surface", "message"),
    [
        (polygon([(0, 0), (1, 0), (0, 1)]), "a plane curve; surface maps need triangles"),
        (Surface(BOX.vertices, BOX.faces[1:]), "not closed: 3 open edges, in 1 hole, where"),
        (
            Surface(BOX.vertices, np.concatenate([BOX.faces, BOX.faces[:1]])),
            "not manifold: 3 edges have more than two faces",
        ),
        (
            Surface(
                np.concatenate([BOX.vertices, BOX.vertices + 1]),
                np.concatenate([BOX.faces, BOX.faces + 8]),
            ),
            "in 2 pieces, where one is needed",
        ),
        (
            Surface(BOX.vertices, np.concatenate([BOX.faces[:1, ::-1], BOX.faces[1:]])),
            "neighbouring faces that are turned opposite ways",
        ),
        (pinched(), "at 1 vertices separate parts of it touch"),
    ],
)
def test_what_cannot_be_mapped_is_told(surface: Surface, message: str) -> None:
    with pytest.raises(GoalError, match=message):
        closed_mesh(surface, "the prop")


def test_different_genus_is_refused_with_the_handles_place() -> None:
    ring, ball = (closed_mesh(s, "x") for s in (ring_surface(), sphere(0.03, 0.5)))
    with pytest.raises(GoalError, match=r"the prop has genus 1 \(a handle about .* mm\) and the"):
        check_topology(ring, ball, "match")
