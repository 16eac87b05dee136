"""The table of a scan is found and cut away; a thing's own foot is no table."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from tests.scan.scans import fine_mug, noisy, on_table
from touchwarp.scan.deviation import deviation
from touchwarp.scan.preparation import prepare
from touchwarp.scan.tabletop import crop_tabletop
from touchwarp.scene.pose import pose_matrix
from touchwarp.scene.shapes import box, make_shape
from touchwarp.scene.surface import Surface

T = pose_matrix((0.3, 0.1, 0.05), (8, -5, 20))


@pytest.fixture(scope="module")
def mug() -> Surface:
    return fine_mug(4e-3)


def test_a_tilted_table_is_found_and_cut_away(mug: Surface) -> None:
    scan = noisy(on_table(mug), 1e-4).transformed(T)
    found = crop_tabletop(scan)
    assert found is not None
    np.testing.assert_allclose(found.normal, T[:3, 2], atol=2e-3)
    assert abs((found.point - T[:3, 3]) @ T[:3, 2]) < 2e-4
    # what lies less than four standard deviations, 0.4 mm, above the table is drawn down onto it
    assert deviation(found.surface, mug.transformed(T)).max_mm < 1.0
    assert deviation(found.surface, mug.transformed(T)).p99_mm < 0.6
    assert 0.5 < found.share < 0.8


def test_a_small_thing_on_a_wide_table_is_found(mug: Surface) -> None:
    found = crop_tabletop(noisy(on_table(mug, 1.4, 1e-2), 1e-4).transformed(T))
    assert found is not None
    assert found.share > 0.95
    assert deviation(found.surface, mug.transformed(T)).max_mm < 1.0


def test_the_prop_is_set_on_z_0_and_keeps_its_handle(mug: Surface) -> None:
    ready = prepare(noisy(on_table(mug), 5e-5).transformed(T))
    assert ready.found.sound
    assert ready.found.genus == 1
    assert ready.surface.bounds[0, 2] == pytest.approx(0, abs=1e-9)
    assert ready.surface.bounds[1, 2] == pytest.approx(0.095, abs=1e-3)
    # the same place in the scan's frame
    back = ready.surface.transformed(np.linalg.inv(ready.T_scene_file))
    assert deviation(back, mug.transformed(T)).p99_mm < 1.0


def test_a_thin_floor_is_no_table() -> None:
    profile = [(0.04, 0), (0.04, 0.08), (0.037, 0.08), (0.037, 0.0025), (0, 0.0025)]
    beaker = trimesh.creation.revolve(profile, sections=64)
    scan = noisy(on_table(Surface(beaker.vertices, beaker.faces)), 1e-4)
    found = crop_tabletop(scan)
    assert found is not None
    # its middle is still 2.5 mm above the table
    floor = np.linalg.norm(found.surface.vertices[:, :2], axis=1) < 1e-3
    np.testing.assert_allclose(found.surface.vertices[floor, 2], 0.0025, atol=5e-4)
    assert floor.any()


@pytest.mark.parametrize("kind", ["mug", "box"])
def test_without_a_table_nothing_is_cut(kind: str) -> None:
    surface = make_shape("mug", {}) if kind == "mug" else box([0.1, 0.08, 0.02])
    assert crop_tabletop(surface) is None


def test_a_table_alone_is_no_object() -> None:
    sheet = Surface(
        np.array([[0.0, 0, 0], [0.3, 0, 0], [0.3, 0.3, 0], [0, 0.3, 0]]),
        np.array([[0, 1, 2], [0, 2, 3]]),
    )
    assert crop_tabletop(sheet) is None
