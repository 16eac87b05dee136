"""Any displacement in closed form as a table of bricks on several levels.

This is the fixture by which lookup, file and browser are tested without a solver.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.warp.bricks import CELLS, NODES, Bricks
from touchwarp.warp.quantise import Conformer
from touchwarp.warp.topology import placement

Float = NDArray[np.float64]


def near_sphere(centre: Any, radius: float, reach: float = 0.8) -> Callable[[Float, Float], Any]:
    """Refine what comes closer to a sphere than `reach` times a brick's half diagonal."""

    def near(centres: Float, halves: Float) -> NDArray[np.bool_]:
        distance = np.abs(np.linalg.norm(centres - centre, axis=-1) - radius)
        return distance < (1.0 + reach) * np.linalg.norm(halves, axis=-1)

    return near


def sample_bricks(
    displacement: Callable[[Float], Float],
    lo: Any,
    hi: Any,
    *,
    root_shape: tuple[int, int, int] = (2, 2, 2),
    depth: int = 3,
    refine: Callable[[Float, Float], Any],
    T_scene_table: Float | None = None,
    mirror_depth: float | None = None,
    zero_outside: bool = True,
    conforming: bool = True,
) -> Bricks:
    """Bricks of the box from lo to hi, refined where asked, hanging nodes trilinear.

    Args:
        displacement: (n, 3) m, scene frame, to (n, 3) m, scene axes; or to (n, C) scalars.
        lo, hi: (3,) m, scene frame before `T_scene_table` turns the box; it turns about lo.
        root_shape: bricks along each axis.
        depth: levels below the root.
        refine: (centres, half widths), (n, 3) each, table frame + lo, to (n,) bool: whether a
            brick that lies there exists.
        T_scene_table: where the table's lowest corner is; a shift to `lo` when left out.
        mirror_depth: as in `Bricks`; the table's z = 0 is then a sliding plane.
        zero_outside: u = 0 on the border, as on ∂Ω1.
        conforming: False leaves hanging nodes at the values of the closed form.
    """
    lo, hi = np.asarray(lo, float), np.asarray(hi, float)
    if T_scene_table is None:
        T_scene_table = np.eye(4)
        T_scene_table[:3, 3] = lo
    width = (hi - lo) / root_shape
    root = np.arange(np.prod(root_shape), dtype=np.int32).reshape(root_shape)
    child = [np.full((root.size, 8), -1, np.int32)]
    places, count = np.argwhere(root >= 0), root.size
    for level in range(1, depth + 1):
        halves = np.array([[o >> 2 & 1, o >> 1 & 1, o & 1] for o in range(8)])
        candidates = (2 * places[:, None] + halves).reshape(-1, 3)
        half_width = np.broadcast_to(width * 0.5 / 2**level, candidates.shape)
        kept = np.asarray(refine(lo + (2 * candidates + 1) * half_width, half_width), bool)
        index = np.full(len(candidates), -1, np.int32)
        index[kept] = count + np.arange(kept.sum())
        child[-1][:] = index.reshape(-1, 8)
        child.append(np.full((int(kept.sum()), 8), -1, np.int32))
        places, count = candidates[kept], count + int(kept.sum())
    children = np.concatenate(child)
    covered = (children >= 0).all(axis=1)
    slot = np.where(covered, -1, np.cumsum(~covered) - 1).astype(np.int32)

    where = placement(root, children)
    kept_rows = ~covered
    nodes = np.stack(np.meshgrid(*[np.arange(NODES)] * 3, indexing="ij"), axis=-1)
    table = where.position[kept_rows][:, None, None, None] * CELLS + nodes
    table = table * (width / CELLS / 2.0 ** where.level[kept_rows][:, None])[:, None, None, None]
    scene = table @ T_scene_table[:3, :3].T + T_scene_table[:3, 3]
    exact = displacement(scene.reshape(-1, 3)).reshape(*scene.shape[:-1], -1)
    if exact.shape[-1] == 3:
        exact = exact @ T_scene_table[:3, :3]
    values = exact.astype(np.float32)
    if conforming:
        conformer = Conformer(root, children, slot, mirror_depth is not None)
        values, _ = conformer.round(exact.copy(), zero_outside)
    return Bricks(T_scene_table, width / CELLS, root, children, slot, values, mirror_depth)
