"""A wrap lies on the surface to second order, and spans its holes."""

from __future__ import annotations

import numpy as np
import pytest

from tests.scan.scans import holed
from touchwarp.errors import SceneError
from touchwarp.scan.soundness import inspect, volume
from touchwarp.scan.wrap import wrap
from touchwarp.scene.shapes import box, sphere
from touchwarp.scene.surface import Surface

RADIUS = 0.05


def greatest_error(voxel: float, offset: float = 0.0) -> float:
    made = wrap(sphere(RADIUS, 0.01), voxel, offset)
    return float(np.abs(np.linalg.norm(made.vertices, axis=1) - RADIUS - offset).max())


def test_a_wrap_of_a_sphere_is_second_order() -> None:
    assert (
        greatest_error(4e-3) < 4e-3**2 / RADIUS
    )  # sagitta of a voxel: h²/8R; a diagonal's: 3 h²/8R
    assert greatest_error(2e-3) < 2e-3**2 / RADIUS


def test_the_claim_rejects_a_surface_half_a_voxel_off() -> None:
    made = wrap(sphere(RADIUS + 1e-3, 0.01), 2e-3)
    assert np.abs(np.linalg.norm(made.vertices, axis=1) - RADIUS).max() > 2e-3**2 / RADIUS


@pytest.mark.parametrize("offset", [0.004, -0.004])
def test_an_offset_wrap_lies_that_far_off(offset: float) -> None:
    assert greatest_error(2e-3, offset) < 3e-4


def test_a_hole_is_spanned() -> None:
    ball = sphere(RADIUS, 0.05)
    open_ball = holed(ball, np.array([[0.0, 0.0, RADIUS]]), 0.025)
    made = wrap(open_ball, 2e-3)
    assert inspect(made).sound
    assert inspect(made).genus == 0
    # the lid lies somewhere between the flat cap and the ball
    low, high = volume(open_ball), volume(ball)
    assert low < volume(made) < high


def test_a_sheet_has_no_inside() -> None:
    sheet = Surface(np.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]]), np.array([[0, 1, 2]]))
    with pytest.raises(SceneError, match="it has no inside"):
        wrap(sheet, 5e-3)


def test_a_voxel_too_small_is_refused_with_one_that_fits() -> None:
    with pytest.raises(SceneError, match=r"million corners.*use 0\.\d+ mm or more"):
        wrap(box([0.1, 0.1, 0.1]), 1e-5)
