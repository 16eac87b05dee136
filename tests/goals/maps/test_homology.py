"""Loops, forms and linking numbers against topology."""

from __future__ import annotations

import numpy as np
import pytest

from touchwarp.goals.maps.closed_mesh import closed_mesh
from touchwarp.goals.maps.homology import find_generators, linking_number, torus_forms
from touchwarp.scene.surface import Surface

from .conftest import ring_surface, two_holed_surface

ANGLE = 2 * np.pi * np.arange(40) / 40
CIRCLE = np.stack([np.cos(ANGLE), np.sin(ANGLE), 0 * ANGLE], axis=1)
ACROSS = np.stack([1 + np.cos(ANGLE), 0 * ANGLE, np.sin(ANGLE)], axis=1)


def test_linked_rings_have_linking_number_one() -> None:
    assert abs(linking_number(CIRCLE, ACROSS)) == pytest.approx(1, abs=1e-9)


def test_rings_apart_have_linking_number_zero() -> None:
    assert linking_number(CIRCLE, ACROSS + np.array([4, 0, 0])) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize(("surface", "loops"), [(ring_surface(), 2), (two_holed_surface(), 4)])
def test_there_are_two_closed_forms_a_handle(surface: Surface, loops: int) -> None:
    generators = find_generators(closed_mesh(surface, "x"))
    assert len(generators) == loops
    for generator in generators:
        assert (generator.form.reshape(3, -1).sum(axis=0) == 0).all()


def test_forms_count_turns_through_the_hole_and_around_the_tube() -> None:
    """Along a circle about the axis one form sums to ±1 and the other to 0; and the other way."""
    mesh = closed_mesh(ring_surface(around=28, across=14), "x")
    forms = torus_forms(mesh)
    halfedges = {
        (int(a), int(b)): row
        for a, b, row in zip(
            mesh.faces.T.ravel(), mesh.faces[:, [1, 2, 0]].T.ravel(), forms, strict=True
        )
    }
    # Vertices were welded in order of use: find the two circles by position.
    tube = np.hypot(np.hypot(mesh.vertices[:, 0], mesh.vertices[:, 1]) - 0.03, mesh.vertices[:, 2])
    assert tube == pytest.approx(0.012)
    longitude = np.arctan2(mesh.vertices[:, 1], mesh.vertices[:, 0])
    outer = np.flatnonzero(np.hypot(mesh.vertices[:, 0], mesh.vertices[:, 1]) > 0.042 - 1e-9)
    outer = outer[np.argsort(longitude[outer])]
    here = np.flatnonzero(np.abs(longitude) < 1e-9)
    inward = np.arctan2(mesh.vertices[here, 2], mesh.vertices[here, 0] - 0.03)
    here = here[np.argsort(inward)]
    sums = []
    for loop in (outer, here):
        pairs = zip(loop.tolist(), np.roll(loop, -1).tolist(), strict=True)
        sums.append(np.abs(sum(halfedges[pair] for pair in pairs)).tolist())
    assert sorted(sums) == [[0, 1], [1, 0]]
