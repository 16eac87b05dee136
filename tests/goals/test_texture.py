"""A displacement texture painted elsewhere displaces as it says."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from touchwarp.errors import GoalError
from touchwarp.goals import Goal, goals
from touchwarp.goals.texture import sample_texture
from touchwarp.scene import Prop, Scene, Surface, TextureGoal, UvMesh
from touchwarp.scene.shapes import box

SQUARE = np.array([[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0]])
SHEET = Surface(SQUARE, [[0, 1, 2], [0, 2, 3]])  # type: ignore[arg-type]
ATLAS = UvMesh(SHEET.vertices, SHEET.faces, SQUARE[:, :2] * 10)


def made(image: Any, atlas: UvMesh = ATLAS, prop: Surface = SHEET, **keys: Any) -> Goal:
    return goals(Scene([Prop("sheet", prop, TextureGoal(image, atlas, **keys))]))["sheet"]


def ramp(size: int) -> Any:
    """0.01 (u, v, u + v) at the texels' centres, the top row first."""
    u, v = np.meshgrid((np.arange(size) + 0.5) / size, 1 - (np.arange(size) + 0.5) / size)
    return 0.01 * np.stack([u, v, u + v], axis=-1)


def test_texels_are_read_bilinearly_with_v_up() -> None:
    image = ramp(16)
    uv = np.random.default_rng(0).uniform(1 / 32, 31 / 32, (1000, 2))
    expected = 0.01 * np.c_[uv, uv.sum(axis=1)]
    np.testing.assert_allclose(sample_texture(image, uv), expected, atol=1e-15)
    # Half a texel within the border is the last centre: beyond, the border's value holds.
    corner = sample_texture(image, np.array([[0.0, 0.0], [1.0, 1.0]]))
    np.testing.assert_allclose(corner[:, 0], [0.01 / 32, 0.01 * 31 / 32])
    np.testing.assert_allclose(
        sample_texture(image[:1, :1], uv), np.broadcast_to(image[0, 0], (1000, 3))
    )


def test_the_bilinear_claim_rejects_v_down() -> None:
    uv = np.array([[0.3, 0.2]])
    assert np.abs(sample_texture(ramp(16)[::-1], uv) - [[0.003, 0.002, 0.005]]).max() > 1e-3


def test_a_dent_finer_than_the_triangles_is_followed() -> None:
    size = 128
    image = np.zeros((size, size, 3))
    u, v = np.meshgrid((np.arange(size) + 0.5) / size, 1 - (np.arange(size) + 0.5) / size)
    image[..., 2] = -0.005 * np.exp(-((u - 0.3) ** 2 + (v - 0.6) ** 2) / 0.01)
    goal = made(image, tolerance_mm=0.05)
    deepest = goal.virtual_points[goal.virtual_points[:, 2].argmin()]
    np.testing.assert_allclose(deepest, [0.03, 0.06, -0.005], atol=1.2e-3)
    middles = goal.prop_points[goal.faces].mean(axis=1)
    shown = goal.virtual_points[goal.faces].mean(axis=1)
    expected = sample_texture(image, middles[:, :2] * 10)
    assert np.abs(shown - middles - expected).max() < 1e-4
    assert 100 < len(goal.faces) < 20_000
    assert goal.virtual_surface is None
    assert goal.report["image_distance_max"] <= 5e-5


def seamed(shift: float) -> tuple[Any, UvMesh]:
    """The sheet as two triangles with coordinates of their own; one is displaced by more."""
    image = np.zeros((32, 64, 3))
    image[:, :32, 2] = 0.002
    image[:, 32:, 2] = 0.002 + shift
    corners = SHEET.faces.ravel()
    uv = SQUARE[corners, :2] * 4 + 0.05
    uv[3:, 0] += 0.5
    return image, UvMesh(SQUARE[corners], np.arange(6).reshape(2, 3), uv)


def test_seams_are_joined() -> None:
    goal = made(*seamed(0.0005))
    assert len(goal.prop_points) == 4
    heights = goal.virtual_points[np.lexsort(goal.prop_points.T), 2]
    # (0, 0) and (0.1, 0.1) lie on the seam: the mean of both sides.
    np.testing.assert_allclose(heights, [0.00225, 0.002, 0.0025, 0.00225], atol=1e-12)
    assert goal.report["seam_max"] == pytest.approx(0.0005)


def test_what_does_not_fit_is_told() -> None:
    with pytest.raises(
        GoalError,
        match=r"prop 'sheet': the texture tears the surface open: at \(.*\) mm the sides of a seam "
        r"are displaced to places 5 mm apart; paint both",
    ):
        made(*seamed(0.005))
    in_mm = UvMesh(SQUARE * 1e3, SHEET.faces, ATLAS.uv)
    with pytest.raises(
        GoalError, match=r"the atlas lies off the prop: the point \(.*\) mm is .* mm"
    ):
        made(ramp(8), in_mm)
    half = UvMesh(SQUARE, SHEET.faces[:1], ATLAS.uv)
    with pytest.raises(
        GoalError, match=r"the atlas does not cover the prop: the point \(0, 100, 0"
    ):
        made(ramp(8), half)
    with pytest.raises(GoalError, match="the atlas does not cover the prop"):
        made(ramp(8), prop=box((0.2, 0.2, 0.2)).transformed(np.eye(4)), atlas=_bottom_of_box())


def _bottom_of_box() -> UvMesh:
    corners = (SQUARE - [0.05, 0.05, 0]) * 2 - [0, 0, 0.1]
    return UvMesh(corners, SHEET.faces, ATLAS.uv)
