"""The table's data: displacement on a sparse octree of bricks.

A brick has 8³ cells and 9³ nodes; faces shared by neighbours are stored in both. Root bricks
stand side by side on a dense grid; a brick may have up to eight children, each half its size. The
deepest brick that contains a point decides, by trilinear interpolation in its cell.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

CELLS = 8
NODES = CELLS + 1


@dataclass(frozen=True, eq=False)
class Bricks:
    """A sparse table of C scalar channels in space.

    The *table frame* has its origin at the lowest corner of the root grid and its axes along it.

    Attributes:
        T_scene_table: (4, 4) rigid, table frame to scene frame.
        spacing: (3,) m, the side lengths of one cell of a root brick.
        root: (nx, ny, nz) int32, the index of each root brick, or -1 where there is none (u = 0).
        child: (b, 8) int32, child bricks by octant 4·ix + 2·iy + iz (0 low half, 1 high half), or
            -1 where a brick has no such child.
        slot: (b,) int32, a brick's row in `values`, or -1 for a brick all of whose children exist.
        values: (v, 9, 9, 9, C) float32 or float16, m, in table axes; indices [x, y, z].
        mirror_depth: None, or the depth D in m of the space under a sliding plane. The plane is
            z = 0 of the table frame. A point at depth 0 < d < D under it takes u from its mirror
            image above, with the normal component's sign turned, times 1 - d / D; below that u = 0.
    """

    T_scene_table: NDArray[np.float64]
    spacing: NDArray[np.float64]
    root: NDArray[np.int32]
    child: NDArray[np.int32]
    slot: NDArray[np.int32]
    values: NDArray[np.float32] | NDArray[np.float16]
    mirror_depth: float | None = None
