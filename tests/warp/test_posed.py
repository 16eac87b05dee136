"""Warps of any kind carried along."""

from __future__ import annotations

import numpy as np
import pytest

from tests.warp.tables import SPHERE, points_in, sphere_bricks, sphere_table, turned
from touchwarp.warp.posed import PosedWarp, rigid
from touchwarp.warp.protocol import Warp


class PlaneShift:
    """A warp of the plane that shifts a disc."""

    dimension = 2

    def __call__(self, x):
        return np.asarray(x) + self.displacement(x)

    def displacement(self, x):
        inside = np.linalg.norm(x, axis=-1, keepdims=True) < 1.0
        return np.where(inside, [0.1, 0.0], 0.0)

    def jacobian(self, x):
        return np.broadcast_to(np.eye(2), (*np.shape(x), 2))

    def inverse(self, x):
        raise NotImplementedError

    def at(self, T):
        return PosedWarp(self, T)


def test_a_posed_warp_is_a_warp_and_agrees_with_a_posed_table() -> None:
    T, table = turned(), sphere_table()
    posed = PosedWarp(table, T)
    assert isinstance(posed, Warp)
    x = points_in(sphere_bricks(), 200) @ T[:3, :3].T + T[:3, 3]
    np.testing.assert_allclose(posed(x), table.at(T)(x), atol=1e-15)
    np.testing.assert_allclose(posed.displacement(x), table.at(T).displacement(x), atol=1e-15)
    np.testing.assert_allclose(posed.jacobian(x), table.at(T).jacobian(x), atol=1e-12)
    again = posed.at(T)
    np.testing.assert_allclose(again(x), table.at(T @ T)(x), atol=1e-15)
    np.testing.assert_allclose(again.T_room_scene, T @ T)
    assert posed.max_displacement == table.max_displacement
    assert PosedWarp(PlaneShift(), np.eye(3)).max_displacement is None


def test_the_posed_slope_is_the_slope() -> None:
    posed, h = SPHERE.at(turned()), 1e-6
    x = turned()[:3, 3] + np.array([[0.05, 0.06, 0.01], [-0.09, 0.02, 0.05]])
    numeric = np.stack([(posed(x + s) - posed(x - s)) / (2 * h) for s in np.eye(3) * h], axis=-1)
    np.testing.assert_allclose(posed.jacobian(x), numeric, atol=1e-7)
    assert np.abs(SPHERE.jacobian(x - turned()[:3, 3]) - numeric).max() > 1e-2


def test_a_posed_inverse_is_a_root() -> None:
    T = turned()
    shown = T[:3, 3] + np.random.default_rng(0).uniform(-0.12, 0.12, (40, 3))
    shown[3] = np.nan
    inverse = SPHERE.at(T).inverse(shown)
    assert inverse.found.sum() == 39
    assert not inverse.found[3]
    np.testing.assert_allclose(
        SPHERE.at(T)(inverse.points)[inverse.found], shown[inverse.found], atol=1e-8
    )


def test_plane_warps_are_carried_too() -> None:
    quarter = np.array([[0.0, -1.0, 5.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(PlaneShift().at(quarter)([5.0, 0.2]), [5.0, 0.3])
    with pytest.raises(ValueError, match=r"shape \(3,\); \(\.\.\., 2\) is needed"):
        PlaneShift().at(quarter)([5.0, 0.0, 0.0])
    with pytest.raises(ValueError, match=r"shape \(4, 4\); a \(3, 3\) matrix is needed"):
        PlaneShift().at(np.eye(4))
    with pytest.raises(ValueError, match="2 × 2 part has determinant 4"):
        rigid(np.diag([2.0, 2.0, 1.0]), "T", 2)
