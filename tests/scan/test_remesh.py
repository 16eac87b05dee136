"""A remeshed surface is the same surface, in even triangles."""

from __future__ import annotations

import numpy as np
import pytest

from touchwarp.errors import SceneError
from touchwarp.scan.deviation import deviation, distances
from touchwarp.scan.remesh import edge_length_for, remesh
from touchwarp.scan.soundness import inspect, volume
from touchwarp.scene.shapes import box, cylinder, make_shape
from touchwarp.scene.surface import Surface


def smallest_angles_deg(surface: Surface) -> np.ndarray:
    corners = surface.vertices[surface.faces]
    angles = []
    for k in range(3):
        a, b = corners[:, k - 2] - corners[:, k], corners[:, k - 1] - corners[:, k]
        cosine = (a * b).sum(axis=1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)
        angles.append(np.degrees(np.arccos(np.clip(cosine, -1, 1))))
    return np.asarray(np.min(angles, axis=0))


def test_a_mug_keeps_its_handle_and_its_shape() -> None:
    mug = make_shape("mug", {})
    even = remesh(mug, 2.5e-3)
    assert inspect(even).sound
    assert inspect(even).genus == 1
    assert distances(even.vertices, mug).max() < 1e-8
    assert deviation(mug, even).p99_mm < 0.8
    assert np.quantile(smallest_angles_deg(even), 0.01) > 30
    assert np.quantile(smallest_angles_deg(mug), 0.01) < 15  # the twin: the mug's own slivers fail
    assert len(even.faces) == pytest.approx(
        len(mug.faces) * edge_length_for(mug, len(mug.faces)) ** 2 / 2.5e-3**2, rel=0.1
    )


@pytest.mark.parametrize("turned", [False, True])
def test_a_box_keeps_its_edges(turned: bool) -> None:
    cube = box([0.1, 0.08, 0.05])
    if turned:
        angle = np.eye(4)
        angle[:2, :2] = [[0.6, -0.8], [0.8, 0.6]]
        cube = cube.transformed(angle)
    even = remesh(cube, 6e-3)
    assert volume(even) == pytest.approx(0.1 * 0.08 * 0.05, rel=1e-12)
    assert deviation(cube, even).max_mm < 1e-9


def test_without_creases_the_edges_are_lost() -> None:
    even = remesh(box([0.1, 0.08, 0.05]), 6e-3, sharp_deg=180)
    assert volume(even) < 0.1 * 0.08 * 0.05 * (1 - 1e-4)


def test_a_cylinder_s_rim_stays_a_rim() -> None:
    can = cylinder(0.03, 0.1)
    even = remesh(can, 4e-3)
    heights = even.vertices[:, 2]
    assert heights.max() == pytest.approx(0.1, abs=1e-12)
    # sagitta of 5.3 mm on 30 mm, 0.12 mm, at most
    assert deviation(can, even).max_mm < 0.25


def test_coarse_becomes_fine_and_fine_becomes_coarse() -> None:
    coarse = box([0.1, 0.1, 0.1])
    fine = remesh(coarse, 3e-3)
    back = remesh(fine, 2e-2)
    assert len(fine.faces) > 10_000
    assert len(back.faces) < 600
    assert volume(back) == pytest.approx(1e-3, rel=1e-9)


def test_an_open_surface_is_refused() -> None:
    cube = box([0.1, 0.1, 0.1])
    with pytest.raises(SceneError, match="a mesh with 1 hole cannot be remeshed"):
        remesh(Surface(cube.vertices, cube.faces[1:]), 0.01)


@pytest.mark.parametrize(
    ("edge_length", "message"),
    [(0.0, "edge length is 0.0 m"), (float("nan"), "edge length is nan m"), (1e-6, "make about")],
)
def test_an_edge_length_out_of_range(edge_length: float, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        remesh(box([0.1, 0.1, 0.1]), edge_length)
