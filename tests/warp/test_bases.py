"""Instant goals: sums of basis fields are the warps of affine goals."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.warp.basis_tables import same_grid, sliding_bases, sphere_bases, sphere_of
from tests.warp.tables import META, points_in, sphere_bricks, turned
from touchwarp.errors import GoalError
from touchwarp.warp.bases import AffineBases
from touchwarp.warp.file import load_warp
from touchwarp.warp.lookup import Lookup
from touchwarp.warp.protocol import Warp
from touchwarp.warp.table import TableWarp


def goal(shift=(0.01, -0.02, 0.015), angle=0.3, scale=(1.2, 0.9, 1.1)) -> np.ndarray:
    """A turn, a stretch and a shift of the ball, scene to scene."""
    centre = sphere_of(sphere_bases().bricks.T_scene_table, np.eye(4)).centre
    T = turned(angle=angle, shift=(0.0, 0.0, 0.0)) @ np.diag([*scale, 1.0])
    T[:3, 3] = centre + np.asarray(shift) - T[:3, :3] @ centre
    return T


SHEAR = np.array([[1.0, 0.3, 0, 0.02], [0, 1, 0.1, 0], [0, 0, 0.7, 0], [0, 0, 0, 1.0]])


@pytest.mark.parametrize("matrix", [goal(), SHEAR, np.eye(4)], ids=["turn", "shear", "none"])
def test_a_combination_is_a_same_grid_solve_to_a_micrometre(matrix: np.ndarray) -> None:
    bases = sphere_bases()
    solved = Lookup.of(same_grid(bases, matrix))
    x = points_in(bases.bricks, 3000)
    for warp in (bases.warp({"ball": matrix}), bases.table({"ball": matrix})):
        assert isinstance(warp, Warp)
        assert np.abs(warp.displacement(x) - solved.displacement(x)).max() < 1e-6
        assert np.abs(warp.jacobian(x) - solved.jacobian(x)).max() < 1e-4


@pytest.mark.parametrize(
    "wrong",
    [
        lambda T: np.vstack([np.column_stack([T[:3, :3].T, T[:3, 3]]), T[3]]),
        lambda T: np.linalg.inv(T),
        lambda T: T @ turned(angle=0.0, shift=(1e-4, 0.0, 0.0)),
    ],
    ids=["transposed", "inverted", "0.1 mm off"],
)
def test_the_micrometre_claim_rejects(wrong) -> None:
    bases = sphere_bases()
    solved = Lookup.of(same_grid(bases, goal()))
    x = points_in(bases.bricks, 3000)
    warp = bases.warp({"ball": wrong(goal())})
    assert np.abs(warp.displacement(x) - solved.displacement(x)).max() > 2e-5


def test_a_combination_holds_the_goal_on_the_prop() -> None:
    bases = sphere_bases(4)
    exact = sphere_of(bases.bricks.T_scene_table, goal())
    random = np.random.default_rng(0).normal(size=(500, 3))
    x = exact.centre + 0.05 * random / np.linalg.norm(random, axis=1, keepdims=True)
    shown = x @ goal()[:3, :3].T + goal()[:3, 3]
    # the bricks are sampled, not fitted: their 1.6 mm cells cut the bend at the surface
    assert np.abs(bases.warp({"ball": goal()})(x) - shown).max() < 8e-4
    assert np.abs(bases.warp({"ball": SHEAR})(x) - shown).max() > 8e-3


def test_props_that_are_not_named_stay() -> None:
    bases = sphere_bases()
    x = points_in(bases.bricks, 200)
    assert not bases.warp({}).displacement(x).any()
    assert not bases.table({}).displacement(x).any()
    np.testing.assert_array_equal(bases.table({}).meta.goals["ball"], np.eye(4))


def by_hand(bases: AffineBases, goals: dict[str, np.ndarray], x: np.ndarray) -> np.ndarray:
    """The formula of docs/warp-file.md, lane by lane, above a sliding plane."""
    channels = [
        Lookup.of(bases.bricks, np.eye(16)[:, [m, m, m]]).displacement(x)[:, 0] for m in range(16)
    ]
    T = bases.bricks.T_scene_table
    R, o = T[:3, :3], T[:3, 3]
    u = np.zeros((len(x), 3))
    for p, name in enumerate(bases.prop_names):
        A, t = goals[name][:3, :3], goals[name][:3, 3]
        B, b = R.T @ (A - np.eye(3)) @ R, R.T @ ((A - np.eye(3)) @ o + t)
        basis = bases.meta.basis[name]
        for k in range(3):
            first = 4 * p + (8 if k == 2 else 0)
            u[:, k] += (B @ basis.centre + b)[k] * channels[first]
            for j in range(3):
                u[:, k] += basis.half_diagonal * B[k, j] * channels[first + 1 + j]
    return u @ R.T


def test_over_a_sliding_plane_the_normal_component_has_lanes_of_its_own() -> None:
    bases = sliding_bases()
    goals = {"mug": SHEAR, "cup": goal()}
    x = np.random.default_rng(0).uniform([0, 0, 0], [0.4, 0.4, 0.4], (300, 3))
    warp, table = bases.warp(goals), bases.table(goals)
    assert np.abs(warp.displacement(x) - by_hand(bases, goals, x)).max() < 1e-15
    assert np.abs(table.displacement(x) - warp.displacement(x)).max() < 1e-6
    under = x * [1.0, 1.0, -0.1]
    mirrored = by_hand(bases, goals, x * [1.0, 1.0, 0.1])
    mirrored *= [1.0, 1.0, -1.0] * np.maximum(1.0 + under[:, 2:] / 0.05, 0.0)
    assert np.abs(warp.displacement(under) - mirrored).max() < 1e-15
    assert np.abs(warp.displacement(x * [1.0, 1.0, 0.0])[:, 2]).max() == 0.0


def test_the_lane_claim_rejects_swapped_sets_and_props() -> None:
    bases = sliding_bases()
    goals = {"mug": SHEAR, "cup": goal()}
    x = np.random.default_rng(0).uniform([0, 0, 0], [0.4, 0.4, 0.4], (300, 3))
    for roll in (8, 4, 1):
        values = np.roll(bases.bricks.values, roll, axis=-1)
        rolled = AffineBases(replace(bases.bricks, values=values), bases.meta)
        difference = rolled.warp(goals).displacement(x) - by_hand(bases, goals, x)
        assert np.abs(difference).max() > 1e-3


def test_a_lazy_combination_is_inverted_and_carried() -> None:
    bases = sphere_bases()
    T = turned(shift=(0.5, 0.0, -0.2))
    warp = bases.warp({"ball": goal()})
    x = points_in(bases.bricks, 60, margin=-0.2)
    moved = warp.at(T)
    there = x @ T[:3, :3].T + T[:3, 3]
    np.testing.assert_allclose(moved(there), warp(x) @ T[:3, :3].T + T[:3, 3], atol=1e-14)
    np.testing.assert_allclose(
        moved.at(T)(there @ T[:3, :3].T + T[:3, 3]),
        moved(there) @ T[:3, :3].T + T[:3, 3],
        atol=1e-14,
    )
    inverse = moved.inverse(there)
    assert inverse.found.all()
    np.testing.assert_allclose(moved(inverse.points), there, atol=2e-7)
    assert moved.table().max_displacement == warp.max_displacement
    with pytest.raises(ValueError, match="T_room_scene is not rigid"):
        warp.at(np.diag([2.0, 1.0, 1.0, 1.0]))


def test_the_error_bound_grows_outside_the_stated_range() -> None:
    bases = sphere_bases()
    inside, far = goal(), goal(shift=(0.3, 0.0, 0.0))
    wide = goal(shift=(0, 0, 0), angle=0.0, scale=(3.0, 1.0, 1.0))
    assert bases.warp({"ball": inside}).within_range
    assert bases.warp({"ball": inside}).error_bound_mm == pytest.approx(0.05)
    assert not bases.warp({"ball": far}).within_range
    assert bases.warp({"ball": far}).error_bound_mm == pytest.approx(0.15)
    assert bases.warp({"ball": wide}).error_bound_mm == pytest.approx(0.10)
    assert bases.error_bound_mm({"ball": far}) == pytest.approx(0.15)
    assert bases.table({"ball": far}).meta.estimated_error_max_mm == pytest.approx(0.15)
    assert bases.table({"ball": far}).meta.estimated_error_rms_mm == pytest.approx(0.03)
    bare = AffineBases(bases.bricks, replace(bases.meta, estimated_error_max_mm=None))
    assert bare.warp({"ball": far}).error_bound_mm is None
    assert bare.error_bound_mm({"ball": far}) is None


def test_a_combined_table_tells_its_goals_and_draws_its_object() -> None:
    meta = sphere_bases().table({"ball": SHEAR}).meta
    assert meta.kind == "warp"
    np.testing.assert_array_equal(meta.goals["ball"], SHEAR)
    outline = META.outlines["ball"]
    np.testing.assert_allclose(
        meta.outlines["ball"].virtual.vertices, outline.prop.transformed(SHEAR).vertices
    )
    assert meta.scene_text == META.scene_text
    np.testing.assert_array_equal(
        sphere_bases().warp({"ball": SHEAR}).goals["ball"], meta.goals["ball"]
    )


def test_bases_are_saved_and_loaded_like_a_warp(tmp_path: Path) -> None:
    for bases in (sphere_bases(), sliding_bases()):
        bases.save(tmp_path / "bases.warp")
        loaded = load_warp(tmp_path / "bases.warp")
        assert isinstance(loaded, AffineBases)
        assert loaded.meta.basis == bases.meta.basis
        assert loaded.prop_names == bases.prop_names
        x = points_in(bases.bricks, 200)
        goals = dict.fromkeys(bases.prop_names, SHEAR)
        np.testing.assert_array_equal(loaded.warp(goals)(x), bases.warp(goals)(x))
        bases.table(goals).save(tmp_path / "table.warp")
        table = load_warp(tmp_path / "table.warp")
        assert isinstance(table, TableWarp)
        np.testing.assert_array_equal(table(x), bases.table(goals)(x))


@pytest.mark.parametrize(
    ("goals", "told"),
    [
        ({"bowl": np.eye(4)}, "There is no prop 'bowl' in these bases; they have 'ball'"),
        ({"ball": np.eye(3)}, r"The goal of 'ball' has shape \(3, 3\); a finite \(4, 4\)"),
        ({"ball": np.full((4, 4), np.nan)}, "has shape .* and is not finite; a finite"),
        ({"ball": np.ones((4, 4))}, "has the last row .*; an affine one, .* is needed"),
    ],
)
def test_goals_that_are_none_are_told(goals, told: str) -> None:
    for combine in (sphere_bases().warp, sphere_bases().table, sphere_bases().error_bound_mm):
        with pytest.raises(GoalError, match=told):
            combine(goals)


def test_the_meta_of_bases_has_a_range_and_no_goals() -> None:
    basis = sphere_bases().meta.basis
    meta = META.as_bases(basis, 0.2, 0.5, 0.4, 0.3, None)
    assert (meta.kind, meta.goals, meta.basis) == ("bases", {}, basis)
    assert (meta.range_shift, meta.range_stretch) == (0.2, 0.5)
    assert meta.tolerance_mm == 0.4
    assert (meta.estimated_error_max_mm, meta.estimated_error_rms_mm) == (0.3, None)
    assert meta.scene_text == META.scene_text


def test_channels_must_fit_the_props() -> None:
    meta = sphere_bases().meta
    with pytest.raises(ValueError, match="Bases of 1 props have 3 channels; 4 a prop are needed"):
        AffineBases(sphere_bricks(), meta)
    mirrored = replace(sphere_bases().bricks, mirror_depth=0.1)
    with pytest.raises(ValueError, match="Bases of 1 props have 4 channels; 8 a prop are needed"):
        AffineBases(mirrored, meta)
    with pytest.raises(ValueError, match=r"have scalings for \[\]; one for each prop is needed"):
        AffineBases(sphere_bases().bricks, replace(meta, basis={}))


def test_a_new_goal_is_ready_at_once() -> None:
    """Nothing of a table's size is made; `benchmarks/instant.py` measures what is left."""
    bases = sphere_bases()
    bases.warp({"ball": SHEAR})
    table = bases.bricks.values.nbytes
    assert memory_of(lambda: bases.warp({"ball": SHEAR})) < 0.01 * table
    assert memory_of(lambda: bases.table({"ball": SHEAR})) > 0.5 * table  # the twin


def memory_of(make: Callable[[], object]) -> int:
    """Bytes at the peak while something is made."""
    tracemalloc.start()
    try:
        make()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
