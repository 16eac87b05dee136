"""f is continuous across every brick and level face, in what is stored."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.exact.sample_bricks import sample_bricks
from tests.warp.tables import BOX, SPHERE, sliding_bricks, sphere_bricks, turned_bricks
from touchwarp.warp.bricks import CELLS, Bricks
from touchwarp.warp.lookup import Lookup
from touchwarp.warp.quantise import Conformer, normal_channels
from touchwarp.warp.topology import placement


def greatest_jump(bricks: Bricks, per_brick: int = 24) -> float:
    """Greatest |f(x + n ε) − f(x − n ε)| over points on all faces of all bricks.

    ε is 1e-13 of the root grid; what u itself changes over it is below 1e-11 m.
    """
    where = placement(bricks.root, bricks.child)
    size = bricks.spacing * CELLS / 2.0 ** where.level[:, None]
    low = where.position * size
    random = np.random.default_rng(0)
    extent = np.array(bricks.root.shape) * bricks.spacing * CELLS
    # read in the table's own frame: turning would move points by 1e-17 across faces
    plain = Lookup.of(replace(bricks, T_scene_table=np.eye(4)))
    worst = 0.0
    for axis in range(3):
        for side in (0.0, 1.0):
            place = random.uniform(0.0, 1.0, (len(low), per_brick, 3))
            # edges and corners too
            place[:, : per_brick // 3] = np.round(place[:, : per_brick // 3] * 16) / 16
            place[..., axis] = side
            x = (low[:, None] + place * size[:, None]).reshape(-1, 3)
            nudge = np.zeros(3)
            nudge[axis] = 1e-13 * extent[axis]
            inside = (x[:, axis] > 0.0) & (x[:, axis] < extent[axis] * (1 - 1e-9))
            jump = plain.displacement(x[inside] + nudge) - plain.displacement(x[inside] - nudge)
            worst = max(worst, float(np.linalg.norm(jump, axis=1).max(initial=0.0)))
    return worst


def ragged(centres: np.ndarray, halves: np.ndarray) -> np.ndarray:
    """Refinement that leaps two levels across faces and leaves single octants out."""
    distance = np.linalg.norm(centres - [0.03, 0.02, -0.04], axis=-1)
    return (distance < 0.06) | (np.sin(997.0 * centres.sum(axis=-1)) > 0.8)


def ragged_bricks(**options) -> Bricks:
    return sample_bricks(
        SPHERE.displacement, *BOX, root_shape=(3, 2, 2), depth=4, refine=ragged, **options
    )


TABLES = {
    "sphere": sphere_bricks,
    "turned": turned_bricks,
    "sliding": sliding_bricks,
    "ragged": ragged_bricks,
}


@pytest.mark.parametrize("table", TABLES)
def test_f_is_continuous_across_bricks_and_levels(table: str) -> None:
    assert greatest_jump(TABLES[table]()) < 1e-10


@pytest.mark.parametrize("table", ["sphere", "ragged"])
def test_continuity_rejects_hanging_nodes_at_their_own_values(table: str) -> None:
    bricks = {"sphere": sphere_bricks, "ragged": ragged_bricks}[table](conforming=False)
    assert greatest_jump(bricks) > 1e-5


def test_continuity_rejects_means_rounded_to_float32() -> None:
    """Trilinear hanging values of unrounded nodes: a bit in the last place, too much for 1e-9."""
    bricks = sphere_bricks(conforming=False)
    conformer = Conformer(bricks.root, bricks.child, bricks.slot)
    flat = bricks.values.astype(np.float64).reshape(len(bricks.values), 729, 3)
    conformer._run(flat, np.empty((0, 729), np.int8), True, True)
    jump = greatest_jump(replace(bricks, values=flat.reshape(bricks.values.shape).astype("f4")))
    assert 2e-10 < jump < 1e-7


@pytest.mark.parametrize("table", TABLES)
def test_stored_values_are_multiples_of_a_step_that_leaves_room(table: str) -> None:
    bricks = TABLES[table]()
    conformer = Conformer(bricks.root, bricks.child, bricks.slot, bricks.mirror_depth is not None)
    values, rounding = conformer.round(bricks.values.astype(np.float64), zero_outside=False)
    np.testing.assert_array_equal(values, bricks.values)
    assert rounding.jump == 0.0
    parts = bricks.values.astype(np.float64) / (rounding.step * 2.0**-rounding.bits)
    assert (parts == np.round(parts)).all()
    assert np.abs(parts).max() <= 2**24


def test_balanced_trees_need_few_places() -> None:
    bricks = sphere_bricks(4)
    assert 2 <= Conformer(bricks.root, bricks.child, bricks.slot).bits <= 4


def test_rounding_moves_no_value_by_more_than_half_a_step_but_hanging_ones() -> None:
    bricks = sphere_bricks(conforming=False)
    exact = bricks.values.astype(np.float64)
    conformer = Conformer(bricks.root, bricks.child, bricks.slot)
    values, rounding = conformer.round(exact.copy())
    moved = np.abs(values - exact)
    assert np.median(moved) < rounding.step
    assert (moved[:, 1:-1, 1:-1, 1:-1] <= rounding.step / 2).all()
    assert rounding.step < 1e-7


def test_nothing_but_zero_on_the_outer_border() -> None:
    shifted = lambda x: SPHERE.displacement(x) + 0.001  # noqa: E731
    options = {"root_shape": (2, 2, 2), "depth": 2, "refine": ragged}
    bricks = sample_bricks(shifted, *BOX, **options)
    border = np.random.default_rng(0).uniform(-0.2, 0.2, (200, 3))
    border[np.arange(200), np.arange(200) % 3] = np.where(np.arange(200) % 2, 0.2, -0.2)
    u = Lookup.of(bricks).displacement(border)
    assert np.abs(u).max() < 1e-15
    kept = sample_bricks(shifted, *BOX, **options, zero_outside=False)
    assert np.abs(Lookup.of(kept).displacement(border)).min() > 1e-5


def test_the_normal_component_is_zero_on_a_sliding_plane_and_only_it() -> None:
    plane = sample_bricks(
        lambda x: np.full_like(x, 0.01),
        [-0.2, -0.2, 0.0],
        [0.2, 0.2, 0.4],
        depth=1,
        refine=ragged,
        mirror_depth=0.1,
    )
    u = Lookup.of(plane).displacement(np.array([[0.01, 0.02, 0.0], [-0.1, 0.07, 0.0]]))
    np.testing.assert_allclose(u, [[0.01, 0.01, 0.0]] * 2, atol=1e-6)
    assert normal_channels(3) == slice(2, 3)
    assert normal_channels(16) == slice(8, None)


def test_float16_jumps_are_measured() -> None:
    bricks = sphere_bricks()
    half = replace(bricks, values=bricks.values.astype(np.float16))
    told = Conformer(bricks.root, bricks.child, bricks.slot).jump(half.values)
    seen = greatest_jump(half, per_brick=200)
    assert 0.1 * seen < told <= 3e-5
    assert seen <= np.sqrt(3.0) * 2.0 * told


def test_places_beyond_the_most_are_given_up_and_told() -> None:
    beside = np.array([-1e-4, 0.03, 0.03])
    deep = sample_bricks(
        lambda x: 0.0125 + 0.002 * np.sin(200.0 * x[:, 1:2] + x) * np.cos(170.0 * x[:, 2:] + x),
        *BOX,
        root_shape=(2, 1, 1),
        depth=6,
        refine=lambda centres, halves: (np.abs(centres - beside) < halves).all(axis=1),
    )
    conformer = Conformer(deep.root, deep.child, deep.slot)
    assert conformer.bits == 12
    _, rounding = conformer.round(deep.values.astype(np.float64))
    assert rounding.bits == 8
    assert 0.0 < rounding.jump < 1e-9
    assert rounding.jump <= 2.0 * greatest_jump(deep, per_brick=300)


def test_a_table_of_zeros_stays_one() -> None:
    bricks = sphere_bricks()
    zeros = np.zeros(bricks.values.shape)
    values, rounding = Conformer(bricks.root, bricks.child, bricks.slot).round(zeros)
    assert not values.any()
    assert rounding.jump == 0.0
