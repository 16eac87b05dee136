"""Tables that can be used level by level, while the finer ones are still on their way.

A brick all of whose children exist needs no values of its own, and a table usually stores none: a
reader near a prop then has to wait for the finest level. Here every brick holds, where it has
children, what they hold at the shared nodes. Lookups of the whole table never see these values;
they cost an eighth of the file at most. A table cut off below any level is continuous, like the
whole.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.warp.bricks import CELLS, NODES, Bricks
from touchwarp.warp.file import coarse_first
from touchwarp.warp.topology import validate_bricks

_HALF = CELLS // 2


def with_coarse_values(bricks: Bricks) -> Bricks:
    """The same table with values for every brick, in order of level.

    Raises:
        ValueError: the bricks are inconsistent.
    """
    ordered, where = coarse_first(bricks, validate_bricks(bricks))
    count = len(ordered.slot)
    shape = (count, NODES, NODES, NODES, ordered.values.shape[-1])
    values = np.zeros(shape, ordered.values.dtype)
    own = ordered.slot >= 0
    values[own] = ordered.values[ordered.slot[own]]
    for level in range(int(where.level.max(initial=0)) - 1, -1, -1):
        parents = np.flatnonzero(where.level == level)
        for octant, block in enumerate(_BLOCKS):
            having = parents[ordered.child[parents, octant] >= 0]
            children = ordered.child[having, octant]
            values[(having, *block)] = values[children, ::2, ::2, ::2]
    return replace(ordered, slot=np.arange(count, dtype=np.int32), values=values)


def level_errors(bricks: Bricks, measure: Callable[[NDArray[np.float64]], float]) -> list[float]:
    """Bounds on what is missing while only some levels are there.

    The bound of a level is the sum, over all finer ones, of the greatest step from one level to the
    next; a step is greatest at a node.

    Args:
        bricks: of `with_coarse_values`.
        measure: the greatest error in u, in any unit, that errors (n, C) of the channels make.

    Returns:
        One for each level, 0 for the finest.

    Raises:
        ValueError: the bricks are inconsistent.
    """
    level = validate_bricks(bricks).level
    steps = [0.0]
    for finer in range(int(level.max(initial=0)), 0, -1):
        step = 0.0
        parents = np.flatnonzero(level == finer - 1)
        for octant, block in enumerate(_BLOCKS):
            having = parents[bricks.child[parents, octant] >= 0]
            child = bricks.values[bricks.child[having, octant]].astype(np.float64)
            lost = child - _refined(bricks.values[(having, *block)].astype(np.float64))
            step = max(step, measure(lost.reshape(-1, lost.shape[-1])) if lost.size else 0.0)
        steps.append(steps[-1] + step)
    return steps[::-1]


def _refined(block: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 9, 9, 9, C) trilinear between the nodes of (n, 5, 5, 5, C)."""
    for axis in (1, 2, 3):
        fine = np.repeat(block, 2, axis=axis)
        before = np.take(block, np.arange(_HALF), axis=axis)
        after = np.take(block, np.arange(1, _HALF + 1), axis=axis)
        middle: list[Any] = [slice(None)] * 5
        middle[axis] = slice(1, CELLS, 2)
        fine = np.take(fine, np.arange(NODES), axis=axis)
        fine[tuple(middle)] = 0.5 * (before + after)
        block = fine
    return block


_SIDES = (slice(0, _HALF + 1), slice(_HALF, NODES))
_BLOCKS = [(_SIDES[o >> 2], _SIDES[o >> 1 & 1], _SIDES[o & 1]) for o in range(8)]
"""Which of a brick's nodes are its children's, by octant."""
