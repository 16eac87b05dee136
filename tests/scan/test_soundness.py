"""Faults are counted as they were made."""

from __future__ import annotations

import numpy as np
import pytest

from tests.scan.scans import holed, with_duplicates, with_speck
from touchwarp.scan.soundness import inspect, volume
from touchwarp.scene.shapes import box, make_shape, sphere
from touchwarp.scene.surface import Surface


@pytest.mark.parametrize(("kind", "genus"), [("mug", 1), ("tea_cup", 1)])
def test_the_genus_of_vessels(kind: str, genus: int) -> None:
    assert inspect(make_shape(kind, {})).genus == genus


def test_a_hole_does_not_change_the_genus() -> None:
    ball = sphere(0.05, 0.2)
    found = inspect(holed(ball, np.array([[0, 0, 0.05], [0, 0, -0.05]]), 0.02))
    assert (found.holes, found.genus, found.closed) == (2, 0, False)


def test_a_sound_box_turned_inside_out() -> None:
    cube = box([0.1, 0.1, 0.1])
    assert inspect(cube).sound
    assert inspect(cube).faults() == "nothing"
    turned = inspect(Surface(cube.vertices, cube.faces[:, ::-1]))
    assert turned.closed
    assert not turned.sound
    assert turned.faults() == "normals that point inward"
    assert volume(cube) == pytest.approx(1e-3)


def test_faults_are_told() -> None:
    cube = box([0.1, 0.1, 0.1])
    assert (
        inspect(with_duplicates(cube, 1)).faults() == "3 edges of over two faces, 1 duplicate face"
    )
    assert "2 bodies" in inspect(with_speck(cube)).faults()
    one = Surface(cube.vertices, np.concatenate([cube.faces[:1, ::-1], cube.faces[1:]]))
    assert inspect(one).turned_edges == 3
    assert inspect(one).genus is None


def test_a_pinched_vertex() -> None:
    cube = box([0.1, 0.1, 0.1])
    other = cube.faces + 8
    other[other == 8] = 7  # the second cube's first corner is the first cube's last
    both = Surface(
        np.concatenate([cube.vertices, cube.vertices + 0.1]), np.concatenate([cube.faces, other])
    )
    found = inspect(both)
    assert found.pinched_vertices == 1
    assert found.genus is None
