"""Tables cut off below a level: continuous, and as wrong as is told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.warp.tables import points_in, sliding_bricks, sphere_bricks, turned_bricks
from touchwarp.warp.bricks import Bricks
from touchwarp.warp.coarse_values import level_errors, with_coarse_values
from touchwarp.warp.lookup import Lookup
from touchwarp.warp.quantise import Conformer
from touchwarp.warp.topology import validate_bricks

TABLES = [sphere_bricks, turned_bricks, sliding_bricks]


def greatest(lost: np.ndarray) -> float:
    return float(np.linalg.norm(lost, axis=-1).max())


def cut_off(bricks: Bricks, finest: int) -> Bricks:
    """The table without the levels beyond one."""
    count = int((validate_bricks(bricks).level <= finest).sum())
    child = np.where(bricks.child[:count] >= count, -1, bricks.child[:count])
    return replace(
        bricks, child=child.astype(np.int32), slot=bricks.slot[:count], values=bricks.values[:count]
    )


def test_some_of_these_tables_have_bricks_without_values() -> None:
    assert [bool((make().slot < 0).any()) for make in TABLES] == [False, True, True]


@pytest.mark.parametrize("make", TABLES)
def test_the_whole_table_stays_as_it_is(make) -> None:
    bricks = make()
    full = with_coarse_values(bricks)
    assert (full.slot >= 0).all()
    x = points_in(bricks, 3000)
    u = Lookup.of(bricks).displacement(x)
    np.testing.assert_array_equal(Lookup.of(full).displacement(x), u)
    assert full.values.size <= 1.2 * bricks.values.size


@pytest.mark.parametrize("make", TABLES)
def test_what_is_missing_is_bounded_as_told(make) -> None:
    full = with_coarse_values(make())
    errors = level_errors(full, greatest)
    x = points_in(full, 20000, margin=0.0)
    u = Lookup.of(full).displacement(x)
    seen = []
    for level in range(len(errors)):
        away = Lookup.of(cut_off(full, level)).displacement(x) - u
        seen.append(float(np.linalg.norm(away, axis=-1).max()))
        assert seen[-1] <= errors[level] + 1e-12
    assert errors[-1] == seen[-1] == 0.0
    assert seen[0] > 0.1 * errors[0]  # the bound is not idle


def test_that_claim_rejects_children_in_the_wrong_octants() -> None:
    full = with_coarse_values(sphere_bricks())
    wrong = replace(full, values=full.values[:, ::-1])
    assert level_errors(wrong, greatest)[0] > 2 * level_errors(full, greatest)[0]


@pytest.mark.parametrize("make", TABLES)
def test_a_table_cut_off_below_a_level_is_continuous(make) -> None:
    full = with_coarse_values(make())
    for level in range(int(validate_bricks(full).level.max())):
        part = cut_off(full, level)
        conformer = Conformer(part.root, part.child, part.slot, part.mirror_depth is not None)
        assert conformer.jump(part.values) < 1e-9
