"""The warp as a table."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.warp.tables import (
    BOX,
    META,
    points_in,
    sliding_bricks,
    sphere_bricks,
    sphere_table,
    turned,
    turned_bricks,
)
from touchwarp.warp.meta import WarpMeta
from touchwarp.warp.protocol import Warp
from touchwarp.warp.raster import RegularTable
from touchwarp.warp.table import TableWarp


def test_a_table_is_a_warp() -> None:
    bricks = sphere_bricks()
    warp = TableWarp(bricks, META)
    assert isinstance(warp, Warp)
    assert warp.dimension == 3
    assert warp.solution is None
    assert TableWarp(bricks, META, solution="record").solution == "record"
    x = points_in(bricks, 50)
    np.testing.assert_allclose(warp(x), x + warp.displacement(x), atol=1e-16)
    assert warp.meta is META
    assert warp.bricks is bricks


def carrying_error(T: np.ndarray, inner: np.ndarray) -> float:
    """|f_T(x) − T f(T⁻¹ x)| at its greatest, T⁻¹ replaced by `inner`."""
    warp = sphere_table()
    x = points_in(sphere_bricks(), 300, margin=-0.1) @ T[:3, :3].T + T[:3, 3]
    shown = warp(x @ inner[:3, :3].T + inner[:3, 3]) @ T[:3, :3].T + T[:3, 3]
    return float(np.abs(warp.at(T)(x) - shown).max())


def test_a_carried_table_shows_what_the_table_shows() -> None:
    T = turned()
    assert carrying_error(T, np.linalg.inv(T)) < 1e-15


def test_the_carrying_claim_rejects_the_inverse_turn() -> None:
    T = turned()
    assert carrying_error(T, T) > 1e-3


def test_carrying_on_shares_the_table_and_remembers_where_it_is() -> None:
    T, warp = turned(), sphere_table()
    twice = warp.at(T).at(T)
    x = points_in(sphere_bricks(), 100)
    np.testing.assert_allclose(twice(x), warp.at(T @ T)(x), atol=1e-15)
    np.testing.assert_allclose(twice.meta.T_room_scene, T @ T)
    np.testing.assert_array_equal(warp.meta.T_room_scene, np.eye(4))
    assert twice.bricks.values is warp.bricks.values
    assert twice.solution is warp.solution
    slope = T[:3, :3] @ warp.jacobian(x) @ T[:3, :3].T
    there = x @ T[:3, :3].T + T[:3, 3]
    away = np.abs(warp.at(T).jacobian(there) - slope).max(axis=(1, 2))
    assert np.median(away) < 1e-14


@pytest.mark.parametrize(
    ("T", "told"),
    [
        (np.eye(3), r"T_room_scene has shape \(3, 3\); a \(4, 4\) matrix is needed"),
        (np.full((4, 4), np.nan), "T_room_scene has NaN or infinite entries"),
        (np.diag([2.0, 1.0, 1.0, 1.0]), "T_room_scene is not rigid: .* determinant 2 "),
        (np.diag([-1.0, 1.0, 1.0, 1.0]), "T_room_scene is not rigid: .* determinant -1 "),
        (turned().T, "T_room_scene has the last row .*pass the transpose"),
    ],
)
def test_only_rigid_carrying_is_accepted(T: np.ndarray, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        sphere_table().at(T)


def resampling_error(regular: RegularTable, warp: TableWarp) -> float:
    axes = [
        o + h * np.arange(n)
        for o, h, n in zip(
            regular.origin, regular.spacing, regular.displacement.shape, strict=False
        )
    ]
    x = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    return float(np.abs(warp.displacement(x) - regular.displacement).max())


def sliding_box() -> WarpMeta:
    return replace(META, outer_box=np.array([[-0.2, -0.2, -0.3], [0.2, 0.2, 0.4]]))


WARPS = {
    "plain": lambda: sphere_table(3),
    "sliding": lambda: TableWarp(sliding_bricks(), sliding_box()),
    "turned": lambda: TableWarp(turned_bricks(), WarpMeta()),
    "carried": lambda: sphere_table().at(turned()),
    "shifted": lambda: sphere_table().at(turned(angle=0.0)),
}


@pytest.mark.parametrize("name", WARPS)
@pytest.mark.parametrize("shape", [(33, 17, 65), (2, 3, 50), (48, 48, 48)])
def test_a_regular_table_holds_the_warp_at_its_nodes(name: str, shape: tuple) -> None:
    warp = WARPS[name]()
    regular = warp.resample(shape)
    assert regular.displacement.shape == (*shape, 3)
    np.testing.assert_array_equal(regular.origin, warp.outer_box[0])
    np.testing.assert_allclose(
        regular.origin + regular.spacing * (np.array(shape) - 1), warp.outer_box[1]
    )
    assert resampling_error(regular, warp) < 1e-13


@pytest.mark.parametrize("wrong", ["swapped", "half a cell", "mirrored"])
def test_the_resampling_claim_rejects(wrong: str) -> None:
    warp = WARPS["sliding"]()
    regular = warp.resample((32, 32, 32))
    u = regular.displacement
    changed = {
        "swapped": replace(regular, displacement=u.swapaxes(0, 1)),
        "half a cell": replace(regular, origin=regular.origin + regular.spacing / 2),
        "mirrored": replace(regular, displacement=u * [1.0, 1.0, -1.0]),
    }
    assert resampling_error(changed[wrong], warp) > 1e-3


@pytest.mark.parametrize("shape", [(4, 4), (1, 4, 4), (0, 2, 2), (4, 4, 4, 3)])
def test_a_regular_table_needs_two_nodes_each_way(shape: tuple) -> None:
    with pytest.raises(ValueError, match="three numbers of nodes, each at least 2, are needed"):
        sphere_table().resample(shape)


def test_the_outer_box_is_that_of_the_scene_or_of_the_table() -> None:
    np.testing.assert_array_equal(sphere_table().outer_box, BOX)
    np.testing.assert_allclose(TableWarp(sphere_bricks(), WarpMeta()).outer_box, BOX)
    quarter = turned(axis=(0, 0, 1), angle=np.pi / 4, shift=(1.0, 0.0, 0.0))
    around = np.sqrt(2.0) * 0.2
    np.testing.assert_allclose(
        sphere_table().at(quarter).outer_box,
        [[1.0 - around, -around, -0.2], [1.0 + around, around, 0.2]],
    )


def test_the_largest_displacement_is_told_also_when_carried() -> None:
    warp = sphere_table()
    assert 0.01 < warp.max_displacement < 0.04
    assert warp.at(turned()).max_displacement == warp.max_displacement
