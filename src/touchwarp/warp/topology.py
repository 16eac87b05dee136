"""The tree of bricks: where each brick lies, and whether the indices form a tree at all."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from touchwarp.warp.bricks import NODES, Bricks
from touchwarp.warp.posed import rigid


class Placement(NamedTuple):
    """Where bricks lie.

    Attributes:
        level: (b,) int32, 0 for root bricks; a brick of level l is 2^-l times as wide.
        position: (b, 3) int32, the brick's place on the dense grid of its own level.
    """

    level: NDArray[np.int32]
    position: NDArray[np.int32]


def placement(root: NDArray[np.int32], child: NDArray[np.int32]) -> Placement:
    """Level and position of every brick, from the indices of `Bricks`.

    Raises:
        ValueError: an index is out of range, or a brick is named twice or never.
    """
    count = len(child)
    for name, index in (("root", root), ("child", child)):
        if index.size and (index.min() < -1 or index.max() >= count):
            raise ValueError(
                f"The {name} index names bricks {index.min()} to {index.max()}, but the table has "
                f"bricks 0 to {count - 1}; -1 means none."
            )
    level = np.full(count, -1, np.int32)
    position = np.zeros((count, 3), np.int32)
    places: NDArray[np.int64] = np.argwhere(root >= 0)
    bricks: NDArray[np.int32] = root[root >= 0]
    depth = 0
    while len(bricks):
        if (level[bricks] >= 0).any() or len(np.unique(bricks)) < len(bricks):
            raise ValueError(
                f"The brick index names a brick of depth {depth} twice; every brick has one parent."
            )
        level[bricks] = depth
        position[bricks] = places
        rows, octants = np.nonzero(child[bricks] >= 0)
        halves = np.stack([octants >> 2 & 1, octants >> 1 & 1, octants & 1], axis=-1)
        places = 2 * position[bricks[rows]].astype(np.int64) + halves
        bricks = child[bricks[rows], octants]
        depth += 1
    if (level < 0).any():
        raise ValueError(
            f"The brick index never names {int((level < 0).sum())} of {count} bricks; "
            "every brick has one parent."
        )
    return Placement(level, position)


def validate_bricks(bricks: Bricks) -> Placement:
    """Where the bricks lie, once everything that `Bricks` promises has been checked.

    Raises:
        ValueError: shapes, types or indices disagree, or a number is not finite.
    """
    rigid(bricks.T_scene_table, "T_scene_table")
    spacing, root, child = bricks.spacing, bricks.root, bricks.child
    slot, values = bricks.slot, bricks.values
    if spacing.shape != (3,) or not (np.isfinite(spacing).all() and (spacing > 0).all()):
        raise ValueError(f"The cell spacing is {spacing.tolist()}; three lengths > 0 are needed.")
    if root.ndim != 3 or root.size == 0:
        raise ValueError(f"The root index has shape {root.shape}; (nx, ny, nz), none 0, is needed.")
    if child.shape != (len(slot), 8) or slot.ndim != 1:
        raise ValueError(
            f"The child index has shape {child.shape} and the slots {slot.shape}; "
            "(b, 8) and (b,) are needed."
        )
    if values.ndim != 5 or values.shape[1:4] != (NODES,) * 3 or values.shape[4] == 0:
        raise ValueError(f"The values have shape {values.shape}; (v, 9, 9, 9, C) is needed.")
    for name, array in (("root", root), ("child", child), ("slot", slot)):
        if array.dtype != np.int32:
            raise ValueError(f"The {name} index is of type {array.dtype}; int32 is needed.")
    if values.dtype not in (np.dtype(np.float32), np.dtype(np.float16)):
        raise ValueError(f"The values are of type {values.dtype}; float32 or float16 is needed.")
    where = placement(root, child)
    used = slot[slot >= 0]
    if not np.array_equal(np.sort(used), np.arange(len(values))) or (slot < -1).any():
        raise ValueError(
            f"The slots do not name each of the {len(values)} rows of values once; "
            "they must, with -1 for bricks that have no values."
        )
    bare = (slot < 0) & (child < 0).any(axis=1)
    if bare.any():
        raise ValueError(
            f"Brick {int(np.argmax(bare))} has neither values nor all eight children; "
            "one of them is needed."
        )
    if not np.isfinite(values).all():
        rows = int((~np.isfinite(values).all(axis=(1, 2, 3, 4))).sum())
        raise ValueError(f"The values of {rows} bricks hold NaN or infinity; finite is needed.")
    depth = bricks.mirror_depth
    if depth is not None and not (np.isfinite(depth) and depth > 0.0):
        raise ValueError(f"The mirror depth is {depth}; a length > 0, or none, is needed.")
    return where
