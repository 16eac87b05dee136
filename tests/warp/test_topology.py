"""A table whose parts do not fit together is told apart from one that does."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.warp.tables import sphere_bricks, turned_bricks
from touchwarp.warp.bricks import Bricks
from touchwarp.warp.topology import placement, validate_bricks


@pytest.mark.parametrize("bricks", [sphere_bricks, turned_bricks])
def test_a_sound_table_is_valid_and_its_bricks_tile_the_box(bricks) -> None:
    table = bricks()
    where = validate_bricks(table)
    leaves = (table.child < 0).sum(axis=1)
    volume = (leaves / 8.0 * 8.0 ** -where.level.astype(float)).sum()
    assert volume == pytest.approx(table.root.size)
    assert (where.position < np.array(table.root.shape) << where.level[:, None]).all()


def changed(array: np.ndarray, place: Any, value: Any) -> np.ndarray:
    copy = array.copy()
    copy[place] = value
    return copy


def first_parent(bricks: Bricks) -> int:
    return int(np.argmax((bricks.child >= 0).any(axis=1) & (bricks.child < 0).any(axis=1)))


def damaged(what: str) -> Bricks:
    b = sphere_bricks()
    parent = first_parent(b)
    octant = int(np.argmax(b.child[parent] >= 0))
    some = b.child[parent, octant]
    changes: dict[str, Any] = {
        "frame scaled": lambda: {"T_scene_table": 2.0 * b.T_scene_table},
        "spacing negative": lambda: {"spacing": -b.spacing},
        "spacing NaN": lambda: {"spacing": b.spacing * np.nan},
        "root flat": lambda: {"root": b.root.reshape(-1)},
        "child narrow": lambda: {"child": b.child[:, :4]},
        "values narrow": lambda: {"values": b.values[:, :8]},
        "child of another type": lambda: {"child": b.child.astype(np.int64)},
        "values of another type": lambda: {"values": b.values.astype(np.float64)},
        "child out of range": lambda: {"child": changed(b.child, (parent, octant), 10_000)},
        "root out of range": lambda: {"root": changed(b.root, (0, 0, 0), -2)},
        "cycle": lambda: {"child": changed(b.child, (some, 0), 0)},
        "two parents": lambda: {"child": changed(b.child, (parent, octant), b.child[0].max())},
        "lost brick": lambda: {"child": changed(b.child, (parent, octant), -1)},
        "slot twice": lambda: {"slot": changed(b.slot, b.slot == 1, 0)},
        "slot below": lambda: {"slot": changed(b.slot, b.slot == 1, -2)},
        "no values": lambda: {
            "slot": changed(b.slot, len(b.slot) - 1, -1),
            "values": b.values[:-1],
        },
        "NaN": lambda: {"values": changed(b.values, (3, 0, 0, 0, 0), np.nan)},
        "infinite": lambda: {"values": changed(b.values, (3, 0, 0, 0, 0), np.inf)},
        "mirror": lambda: {"mirror_depth": -1.0},
        "mirror NaN": lambda: {"mirror_depth": np.nan},
    }
    return replace(b, **changes[what]())


@pytest.mark.parametrize(
    ("what", "told"),
    [
        ("frame scaled", "T_scene_table has the last row"),
        ("spacing negative", "The cell spacing is .*; three lengths > 0 are needed"),
        ("spacing NaN", "The cell spacing is .*; three lengths > 0 are needed"),
        ("root flat", r"The root index has shape \(8,\); \(nx, ny, nz\), none 0, is needed"),
        ("child narrow", r"The child index has shape \(\d+, 4\) and the slots"),
        ("values narrow", r"The values have shape .*; \(v, 9, 9, 9, C\) is needed"),
        ("child of another type", "The child index is of type int64; int32 is needed"),
        ("values of another type", "values are of type float64; float32 or float16 is needed"),
        ("child out of range", "The child index names bricks -1 to 10000, but the table has"),
        ("root out of range", "The root index names bricks -2 to"),
        ("cycle", r"names a brick of depth \d twice; every brick has one parent"),
        ("two parents", r"names a brick of depth \d twice; every brick has one parent"),
        ("lost brick", r"never names \d+ of \d+ bricks; every brick has one parent"),
        ("slot twice", "The slots do not name each of the .* rows of values once"),
        ("slot below", "The slots do not name each of the .* rows of values once"),
        ("no values", "has neither values nor all eight children"),
        ("NaN", "The values of 1 bricks hold NaN or infinity; finite is needed"),
        ("infinite", "The values of 1 bricks hold NaN or infinity; finite is needed"),
        ("mirror", r"The mirror depth is -1\.0; a length > 0, or none, is needed"),
        ("mirror NaN", "The mirror depth is nan; a length > 0, or none, is needed"),
    ],
)
def test_damage_is_told(what: str, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        validate_bricks(damaged(what))


def test_a_cycle_among_bricks_that_no_root_names_is_told() -> None:
    root = np.zeros((1, 1, 1), np.int32)
    child = np.full((3, 8), -1, np.int32)
    child[1, 0], child[2, 0] = 2, 1
    with pytest.raises(ValueError, match="never names 2 of 3 bricks"):
        placement(root, child)
