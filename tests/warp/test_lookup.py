"""Reading a table at points."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from tests.exact.order import observed_order
from tests.exact.sample_bricks import near_sphere, sample_bricks
from tests.warp.tables import (
    BOX,
    MIRROR_DEPTH,
    SOURCES,
    SPHERE,
    environment,
    points_in,
    sliding_bricks,
    sphere_bricks,
    turned,
    turned_bricks,
    with_values,
)
from touchwarp.warp.bricks import Bricks
from touchwarp.warp.lookup import SHARE, Lookup, largest

SLOPE = np.array([[0.2, -0.1, 0.05], [0.0, 0.3, 0.1], [-0.2, 0.1, 0.4]])


def linear_bricks(T_scene_table: np.ndarray) -> Bricks:
    """A displacement that is linear in the scene's coordinates, on oblong cells, three levels."""
    return sample_bricks(
        lambda x: 0.01 + x @ SLOPE.T,
        [0.0, 0.0, 0.0],
        [0.4, 0.3, 0.2],
        root_shape=(2, 1, 1),
        depth=2,
        refine=near_sphere(0.1, 0.05),
        T_scene_table=T_scene_table,
        zero_outside=False,
    )


@pytest.mark.parametrize("T", [np.eye(4), turned()], ids=["plain", "turned"])
def test_a_linear_field_is_read_exactly(T: np.ndarray) -> None:
    bricks = linear_bricks(T)
    x = points_in(bricks, 500, margin=-0.001)
    lookup = Lookup.of(bricks)
    np.testing.assert_allclose(lookup.displacement(x), 0.01 + x @ SLOPE.T, atol=2e-7)
    assert np.abs(lookup.jacobian(x) - (np.eye(3) + SLOPE)).max() < 2e-5


@pytest.mark.parametrize("wrong", ["axes swapped", "half a cell off", "frame not turned"])
def test_the_linear_claim_rejects(wrong: str) -> None:
    bricks = linear_bricks(turned())
    x = points_in(bricks, 500, margin=-0.05)
    if wrong == "axes swapped":
        bricks = with_values(bricks, bricks.values.swapaxes(1, 3))
    elif wrong == "half a cell off":
        T = bricks.T_scene_table.copy()
        T[:3, 3] += T[:3, :3] @ (bricks.spacing / 2)
        bricks = replace(bricks, T_scene_table=T)
    else:
        T = np.eye(4)
        T[:3, 3] = bricks.T_scene_table[:3, 3]
        bricks = replace(bricks, T_scene_table=T)
    assert np.abs(Lookup.of(bricks).displacement(x) - (0.01 + x @ SLOPE.T)).max() > 1e-3


def order_on_spheres(shift: float) -> float:
    """The order seen where no cell crosses a sphere, with tables that stand `shift` cells off."""
    x = points_in(sphere_bricks(), 6000, margin=0.0)
    x = x[np.abs(np.linalg.norm(x, axis=1) - 0.13) < 0.02]
    errors, spacings = [], []
    for bricks_along in (3, 6, 12):
        bricks = sample_bricks(
            SPHERE.displacement, *BOX, root_shape=(bricks_along,) * 3, depth=0, refine=None
        )
        off = shift * bricks.spacing
        errors.append(
            np.abs(Lookup.of(bricks).displacement(x + off) - SPHERE.displacement(x)).max()
        )
        spacings.append(bricks.spacing[0])
    return observed_order(spacings, errors)


def test_a_table_of_spheres_is_second_order() -> None:
    assert order_on_spheres(shift=0.0) == pytest.approx(2.0, abs=0.15)


def test_the_order_claim_rejects_half_a_cell_off() -> None:
    assert order_on_spheres(shift=0.5) < 1.2


def slope_error(bricks: Bricks, x: np.ndarray) -> float:
    """The Jacobian against central differences that stay in one cell."""
    lookup, h = Lookup.of(bricks), 1e-7
    rotation = bricks.T_scene_table[:3, :3]
    local = (x - bricks.T_scene_table[:3, 3]) @ rotation
    finest = bricks.spacing / 16
    place = np.abs(local / finest - np.round(local / finest))
    x = x[(place > 0.01).all(axis=1) & (np.abs(local[:, 2] + MIRROR_DEPTH) > 1e-3)]
    assert len(x) > 300
    numeric = [
        (lookup.displacement(x + s, True) - lookup.displacement(x - s, True)) / (2 * h)
        for s in np.eye(3) * h
    ]
    return float(np.abs(lookup.jacobian(x) - np.stack(numeric, axis=-1)).max())


@pytest.mark.parametrize("bricks", [sphere_bricks, turned_bricks, sliding_bricks])
def test_the_jacobian_is_the_slope_also_under_a_sliding_plane(bricks) -> None:
    x = points_in(bricks(), 800, seed=3, margin=0.15)
    assert slope_error(bricks(), x) < 1e-7


def test_the_slope_claim_rejects_the_transpose() -> None:
    lookup, x = Lookup.of(sphere_bricks()), points_in(sphere_bricks(), 800)
    slope = lookup.jacobian(x)
    assert np.abs(slope - slope.swapaxes(-1, -2)).max() > 1e-2


def test_on_a_face_the_jacobian_is_that_of_the_greater_side() -> None:
    bricks = sphere_bricks()
    lookup, width = Lookup.of(bricks), bricks.spacing[0]
    # power-of-two places only, so that the face is met exactly
    on = np.array([[-0.2 + 0.2, 0.11, 0.13]])
    nudge = np.array([0.01 * width, 0.0, 0.0])
    np.testing.assert_allclose(lookup.jacobian(on), lookup.jacobian(on + 1e-9), atol=1e-6)
    assert np.abs(lookup.jacobian(on) - lookup.jacobian(on - nudge)).max() > 1e-3
    on_top = np.array([[0.2, 0.11, 0.13]])
    np.testing.assert_allclose(
        lookup.jacobian(on_top)[0], lookup.jacobian(on_top - nudge)[0], atol=2e-2
    )


def test_under_a_sliding_plane_the_field_is_mirrored_and_fades() -> None:
    lookup = Lookup.of(sliding_bricks())
    above = points_in(sliding_bricks(), 400, seed=5) * [1.0, 1.0, 0.0] + [0.0, 0.0, 0.02]
    under = above * [1.0, 1.0, -1.0]
    faded = lookup.displacement(above) * [1.0, 1.0, -1.0] * (1.0 - 0.02 / MIRROR_DEPTH)
    np.testing.assert_allclose(lookup.displacement(under), faded, atol=1e-16)
    assert (lookup.displacement(above - [0.0, 0.0, 0.02 + MIRROR_DEPTH]) == 0.0).all()


def sliding_error(bricks: Bricks) -> float:
    """The table against the exact field, faded, 15 mm under the plane and clear of the source."""
    depth = 0.015
    x = points_in(bricks, 400, seed=6) * [0.8, 0.8, 0.0] - [0.0, 0.0, depth]
    x = x[np.linalg.norm(x, axis=1) > 0.08]
    exact = SOURCES.displacement(x) * (1.0 - depth / MIRROR_DEPTH)
    return float(np.abs(Lookup.of(bricks).displacement(x) - exact).max())


def test_the_mirror_rule_continues_an_exact_sliding_field() -> None:
    assert sliding_error(sliding_bricks()) < 1e-4


@pytest.mark.parametrize("sign", [[1.0, 1.0, -1.0], [-1.0, 1.0, 1.0]])
def test_the_mirror_claim_rejects_a_wrong_sign(sign: list[float]) -> None:
    flipped = with_values(sliding_bricks(), sliding_bricks().values * np.array(sign))
    assert sliding_error(flipped) > 1e-3


def test_outside_and_where_no_root_brick_is_nothing_moves() -> None:
    bricks = sphere_bricks()
    root = bricks.root.copy()
    root[0, 0, 0] = -1
    lookup = Lookup.of(replace(bricks, root=root))
    x = np.array([[-0.1, -0.1, -0.1], [0.3, 0.0, 0.0], [np.inf, 0.0, 0.0], [0.0, -0.2001, 0.0]])
    assert (lookup.displacement(x) == 0.0).all()
    np.testing.assert_array_equal(lookup.displacement(x, displayed=True), x)
    np.testing.assert_array_equal(lookup.jacobian(x), np.broadcast_to(np.eye(3), (4, 3, 3)))
    assert (Lookup.of(bricks).displacement(x[:1]) != 0.0).any()


def test_shapes_are_kept_and_lost_joints_stay_lost() -> None:
    lookup = Lookup.of(sphere_bricks())
    hands = np.random.default_rng(0).uniform(-0.1, 0.1, (2, 26, 3))
    whole = lookup.displacement(hands, displayed=True)
    hands[1, 4, 2] = np.nan
    shown = lookup.displacement(hands, displayed=True)
    assert shown.shape == (2, 26, 3)
    assert lookup.jacobian(hands).shape == (2, 26, 3, 3)
    assert np.isnan(shown[1, 4]).all()
    assert np.isnan(lookup.jacobian(hands)[1, 4]).all()
    assert np.isnan(shown).sum() == 3
    np.testing.assert_array_equal(shown[0], whole[0])
    assert lookup.displacement(np.empty((0, 3))).shape == (0, 3)
    assert lookup.displacement([0.0, 0.0, 0.1]).shape == (3,)


@pytest.mark.parametrize("shape", [(), (2,), (3, 26, 2)])
def test_a_wrong_shape_raises(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"Points have shape .*; \(\.\.\., 3\) is needed"):
        Lookup.of(sphere_bricks()).displacement(np.zeros(shape))


def test_many_points_on_several_threads_are_the_same_as_few() -> None:
    lookup = Lookup.of(turned_bricks())
    x = points_in(turned_bricks(), 2 * SHARE + 17)
    some = slice(SHARE - 5, SHARE + 300)
    np.testing.assert_array_equal(lookup.displacement(x)[some], lookup.displacement(x[some]))
    np.testing.assert_array_equal(lookup.jacobian(x)[some], lookup.jacobian(x[some]))


def test_a_forked_process_looks_up_too() -> None:
    script = (
        "import os; from tests.warp.tables import *; from touchwarp.warp.lookup import *\n"
        "x = points_in(sphere_bricks(), 2 * SHARE); lookup = Lookup.of(sphere_bricks())\n"
        "lookup.displacement(x)\n"
        "child = os.fork()\n"
        "if child == 0: lookup.displacement(x); os._exit(7)\n"
        "assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True, timeout=600, env=environment())


def test_channels_are_mixed() -> None:
    bricks = sphere_bricks()
    mix = np.array([[0.0, 1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    x = points_in(bricks, 100)
    mixed, plain = Lookup.of(bricks, mix), Lookup.of(bricks)
    np.testing.assert_allclose(mixed.displacement(x), plain.displacement(x) @ mix, atol=1e-17)
    np.testing.assert_allclose(
        mixed.jacobian(x) - np.eye(3), mix.T @ (plain.jacobian(x) - np.eye(3)), atol=1e-13
    )


def test_a_warp_needs_three_channels() -> None:
    bricks = replace(sphere_bricks(), values=np.zeros((1, 9, 9, 9, 4), np.float32))
    with pytest.raises(ValueError, match="have 4 channels; the 3 components of u are needed"):
        Lookup.of(bricks)


def test_the_largest_displacement_bounds_all() -> None:
    bound = largest(sphere_bricks())
    u = Lookup.of(sphere_bricks()).displacement(points_in(sphere_bricks(), 20000))
    assert 0.8 * bound < np.linalg.norm(u, axis=1).max() <= bound
