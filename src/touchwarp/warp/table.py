"""The warp as a table: what `solve` returns and a warp file holds."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from touchwarp.solve.threads import pool, threads
from touchwarp.warp.bricks import CELLS, Bricks
from touchwarp.warp.inverse import as_inverse, find_inverse
from touchwarp.warp.lookup import SHARE, Lookup, frame_of, largest, rows
from touchwarp.warp.meta import WarpMeta
from touchwarp.warp.posed import rigid
from touchwarp.warp.protocol import Inverse
from touchwarp.warp.raster import RegularTable, rasterised
from touchwarp.warp.roots import RootSearch
from touchwarp.warp.topology import placement

Float = NDArray[np.float64]


class TableWarp:
    """A warp f(x) = x + u(x) whose u is read from a table of bricks by trilinear interpolation.

    It fulfils the `Warp` protocol. f is continuous; ∂f/∂x jumps on faces of cells and is there that
    of the cell on the greater side, in table axes.

    Args:
        bricks: the table, with the three components of u as channels; trusted: readers check it.
        meta: what the warp says of itself.
        solution: the solver's own record; None for a loaded or combined warp.
    """

    dimension = 3

    def __init__(self, bricks: Bricks, meta: WarpMeta, solution: Any | None = None) -> None:
        self._bricks = bricks
        self._meta = meta
        self._solution = solution
        self._lookup = Lookup.of(bricks)
        self._shared: dict[str, Any] = {}

    @property
    def bricks(self) -> Bricks:
        """The table itself."""
        return self._bricks

    @property
    def meta(self) -> WarpMeta:
        """What the warp says of itself."""
        return self._meta

    @property
    def solution(self) -> Any | None:
        """Residual history, error estimate and nodes; None after loading."""
        return self._solution

    @property
    def max_displacement(self) -> float:
        """The greatest |u| of the table, in m."""
        if "reach" not in self._shared:
            self._shared["reach"] = largest(self._bricks)
        return float(self._shared["reach"])

    @cached_property
    def outer_box(self) -> Float:
        """(2, 3) m, room frame: the box of ∂Ω1; where it has been turned, the box around it."""
        box = self._meta.outer_box
        T = self._meta.T_room_scene
        if box is None:
            counts = np.array(self._bricks.root.shape)
            box = np.stack([np.zeros(3), counts * CELLS * self._bricks.spacing])
            T = self._bricks.T_scene_table
        corners = np.stack(np.meshgrid(*np.asarray(box).T, indexing="ij"), axis=-1).reshape(-1, 3)
        moved = corners @ T[:3, :3].T + T[:3, 3]
        return np.stack([moved.min(axis=0), moved.max(axis=0)])

    def __call__(self, x: ArrayLike) -> Float:
        """Displayed positions f(x): (..., 3) m for x (..., 3) m."""
        return self._lookup.displacement(x, displayed=True)

    def displacement(self, x: ArrayLike) -> Float:
        """u(x): (..., 3) m for x (..., 3) m."""
        return self._lookup.displacement(x)

    def jacobian(self, x: ArrayLike) -> Float:
        """∂f/∂x: (..., 3, 3) for x (..., 3) m; one-sided on faces of cells, see the class."""
        return self._lookup.jacobian(x)

    def inverse(self, x: ArrayLike) -> Inverse:
        """Real positions whose displayed position is x; under folds the root nearest to x.

        The search is exhaustive, but for positions under a sliding plane, which are searched from
        many starts; no real hand can be there.
        """
        shown = rows(x)
        y = shown.reshape(-1, 3)
        u = self.displacement(y)
        points = np.full_like(y, np.nan)
        still = (u == 0.0).all(axis=-1)
        points[still] = y[still]
        T = self._bricks.T_scene_table
        table = (y - T[:3, 3]) @ T[:3, :3]
        todo = ~still & np.isfinite(u).all(axis=-1)
        under = todo & (table[:, 2] < 0.0)
        points[under] = find_inverse(self, y[under]).points
        above = np.flatnonzero(todo & ~under)
        points[above] = self._search(table[above]) @ T[:3, :3].T + T[:3, 3]
        return as_inverse(points.reshape(shown.shape))

    def _search(self, y: Float) -> Float:
        if "roots" not in self._shared:
            where = placement(self._bricks.root, self._bricks.child)
            table = self._lookup
            self._shared["roots"] = RootSearch(
                table.root,
                table.child,
                table.slot,
                *where,
                table.values,
                table.frame[12:15].copy(),
                self.max_displacement,
            )
        search: RootSearch = self._shared["roots"]
        if len(y) < SHARE // 64 or threads() == 1:
            return search(y)
        return np.concatenate(list(pool().map(search, np.array_split(y, 4 * threads()))))

    def at(self, T_room_scene: ArrayLike) -> TableWarp:
        """The warp carried rigidly along, x ↦ T f(T⁻¹ x); the table is shared, not copied.

        Raises:
            ValueError: T is not rigid.
        """
        T = rigid(T_room_scene, "T_room_scene")
        moved = TableWarp.__new__(TableWarp)
        moved._bricks = replace(self._bricks, T_scene_table=T @ self._bricks.T_scene_table)
        moved._meta = replace(self._meta, T_room_scene=T @ self._meta.T_room_scene)
        moved._solution = self._solution
        moved._lookup = replace(self._lookup, frame=frame_of(moved._bricks))
        moved._shared = self._shared
        return moved

    def resample(self, shape: tuple[int, int, int]) -> RegularTable:
        """The paper's regular lookup table over the outer box.

        Args:
            shape: nodes along x, y and z, two or more each.

        Raises:
            ValueError: the shape is not of three numbers ≥ 2.
        """
        counts = tuple(int(n) for n in shape)
        if len(counts) != 3 or min(counts) < 2:
            raise ValueError(
                f"A regular table of shape {tuple(shape)} was asked for; "
                "three numbers of nodes, each at least 2, are needed."
            )
        lo, hi = self.outer_box
        spacing = (hi - lo) / (np.array(counts) - 1)
        axes = [lo[d] + spacing[d] * np.arange(counts[d]) for d in range(3)]
        for d in range(3):
            axes[d][-1] = hi[d]
        T = self._bricks.T_scene_table
        if np.array_equal(T[:3, :3], np.eye(3)):
            table_axes = [axes[d] - T[d, 3] for d in range(3)]
            u = rasterised(self._lookup, *table_axes)
        else:
            points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
            u = self.displacement(points)
        return RegularTable(lo, spacing, u)

    def save(self, path: str | Path, dtype: Literal["float32", "float16"] = "float32") -> None:
        """Write a warp file; see docs/warp-file.md.

        Args:
            dtype: "float16" halves the file; what that costs is told in `meta` on loading.

        Raises:
            OutputError: the file cannot be written; nothing is left behind.
            ValueError: dtype is another.
        """
        from touchwarp.warp.file import write_warp

        write_warp(path, self._bricks, self._meta, dtype)
