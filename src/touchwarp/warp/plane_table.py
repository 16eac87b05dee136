"""The warp of a plane scene, as a table: what `solve` returns for a scene of dimension 2."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from touchwarp.solve.plane import encloses
from touchwarp.warp.inverse import find_inverse
from touchwarp.warp.meta import WarpMeta
from touchwarp.warp.plane_values import CROSSED, OUT, PlaneTable, classify_cells
from touchwarp.warp.posed import rigid
from touchwarp.warp.protocol import Inverse
from touchwarp.warp.raster import RegularTable


class PlaneTableWarp:
    """A warp of the plane, read from a table; it fulfils the `Warp` protocol with d = 2.

    Args:
        table: the numbers.
        meta: what is told of them.
        solution: how they were made; None after loading.
    """

    def __init__(self, table: PlaneTable, meta: WarpMeta, solution: Any | None = None) -> None:
        self.table = table
        self.meta = meta
        self.solution = solution
        self._rotation = table.T_scene_table[:2, :2]
        self._origin = table.T_scene_table[:2, 2]
        self._lines = (table.x_lines, table.y_lines)
        self._side = classify_cells(table) if len(table.outer) else None

    @property
    def dimension(self) -> int:
        """2."""
        return 2

    @property
    def max_displacement(self) -> float:
        """A bound on |u|, m."""
        return float(np.linalg.norm(self.table.values.astype(np.float64), axis=-1).max())

    def __call__(self, x: ArrayLike) -> NDArray[np.float64]:
        """Displayed positions f(x): (..., 2) m for x (..., 2) m."""
        points = _points(x)
        return points + self.displacement(points)

    def displacement(self, x: ArrayLike) -> NDArray[np.float64]:
        """u(x) = f(x) − x: (..., 2) m for x (..., 2) m."""
        points = _points(x)
        u, _ = self._look_up(points.reshape(-1, 2), gradient=False)
        return np.asarray(u @ self._rotation.T).reshape(points.shape)

    def jacobian(self, x: ArrayLike) -> NDArray[np.float64]:
        """∂f/∂x: (..., 2, 2), entry [i, j] = ∂f_i/∂x_j, for x (..., 2) m.

        On a grid line it is that of the cell with the greater coordinate.
        """
        points = _points(x)
        _, gradient = self._look_up(points.reshape(-1, 2), gradient=True)
        turned = np.eye(2) + self._rotation @ gradient @ self._rotation.T
        return np.asarray(turned).reshape(*points.shape, 2)

    def inverse(self, x: ArrayLike) -> Inverse:
        """Real positions whose displayed position is x; under folds the root nearest to x."""
        return find_inverse(self, x)

    def at(self, T_room_scene: ArrayLike) -> PlaneTableWarp:
        """The warp carried rigidly along, x ↦ T f(T⁻¹ x), with no solve; T is (3, 3).

        Raises:
            ValueError: T is not rigid.
        """
        T = rigid(T_room_scene, "T_room_scene", 2)
        table = replace(self.table, T_scene_table=T @ self.table.T_scene_table)
        meta = replace(self.meta, T_room_scene=T @ self.meta.T_room_scene)
        return PlaneTableWarp(table, meta, self.solution)

    @property
    def outer_box(self) -> NDArray[np.float64]:
        """(2, 2) m, room frame: the box around the table, mirrored part included."""
        low = np.array([lines[0] for lines in self._lines])
        high = np.array([lines[-1] for lines in self._lines])
        low[1] -= self.table.mirror_depth or 0.0
        corners = np.array([low, [low[0], high[1]], [high[0], low[1]], high])
        moved = corners @ self._rotation.T + self._origin
        return np.stack([moved.min(axis=0), moved.max(axis=0)])

    def resample(self, shape: tuple[int, int]) -> RegularTable:
        """The paper's regular lookup table over the outer box.

        Args:
            shape: nodes along x and y, two or more each.

        Raises:
            ValueError: the shape is not of two numbers ≥ 2.
        """
        counts = tuple(int(n) for n in shape)
        if len(counts) != 2 or min(counts) < 2:
            raise ValueError(
                f"A regular table of shape {tuple(shape)} was asked for; "
                "two numbers of nodes, each at least 2, are needed."
            )
        low, high = self.outer_box
        axes = [np.linspace(low[d], high[d], counts[d]) for d in range(2)]
        points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
        spacing = (high - low) / (np.array(counts) - 1)
        return RegularTable(low, spacing, self.displacement(points))

    def save(self, path: str | Path, dtype: Literal["float32", "float16"] = "float32") -> None:
        """Write a warp file; see docs/warp-file.md.

        Args:
            dtype: "float16" halves the file; what that costs is told in `meta` on loading.

        Raises:
            OutputError: the file cannot be written; nothing is left behind.
            ValueError: dtype is another.
        """
        from touchwarp.warp.plane_file import write_plane

        write_plane(path, self.table, self.meta, dtype)

    def _look_up(
        self, points: NDArray[np.float64], gradient: bool
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """u (n, 2) and, if asked for, ∂u/∂x (n, 2, 2), in table axes, at scene points (n, 2)."""
        local = (points - self._origin) @ self._rotation
        depth = self.table.mirror_depth
        if depth is None:
            return self._interpolate(local, gradient)
        under = local[:, 1] < 0.0
        sign = np.where(under[:, None], np.array([1.0, -1.0]), 1.0)
        u, slope = self._interpolate(local * sign, gradient)
        fade = np.ones(len(local))
        fade[under] = np.maximum(1.0 + local[under, 1] / depth, 0.0) if depth > 0.0 else 0.0
        if len(self.table.outer):
            fade[under] *= encloses(self.table.outer, local[under])
        u *= sign
        slope *= sign[:, :, None] * sign[:, None, :] * fade[:, None, None]
        fading = under & (fade > 0.0)
        if depth > 0.0:
            slope[fading, :, 1] += u[fading] / depth
        return u * fade[:, None], slope

    def _interpolate(
        self, local: NDArray[np.float64], gradient: bool
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The same, at table-frame points, without the mirror."""
        inside = np.ones(len(local), dtype=bool)
        cell, part, width = [], [], []
        for axis, lines in enumerate(self._lines):
            place = local[:, axis]
            inside &= (place >= lines[0]) & (place <= lines[-1])
            index = np.clip(np.searchsorted(lines, place, side="right") - 1, 0, len(lines) - 2)
            cell.append(index)
            width.append((lines[index + 1] - lines[index])[:, None])
            part.append((place - lines[index])[:, None] / width[-1])
        i, j = cell
        if self._side is not None:
            side = self._side[i, j]
            inside &= side != OUT
            crossed = inside & (side == CROSSED)
            inside[crossed] = encloses(self.table.outer, local[crossed])
        (s, t), (h, k) = part, width
        low_low, low_high, high_low, high_high = (
            self.table.values[i + a, j + b].astype(np.float64) for a in (0, 1) for b in (0, 1)
        )
        u = (1 - s) * ((1 - t) * low_low + t * low_high) + s * ((1 - t) * high_low + t * high_high)
        nan = np.isnan(local).any(axis=1)
        u[~inside] = 0.0
        u[nan] = np.nan
        slope = np.zeros((len(local), 2, 2))
        if gradient:
            slope[:, :, 0] = ((1 - t) * (high_low - low_low) + t * (high_high - low_high)) / h
            slope[:, :, 1] = ((1 - s) * (low_high - low_low) + s * (high_high - high_low)) / k
            slope[~inside] = 0.0
            slope[nan] = np.nan
        return u, slope


def _points(x: ArrayLike) -> NDArray[np.float64]:
    points = np.asarray(x, dtype=np.float64)
    if points.ndim == 0 or points.shape[-1] != 2:
        raise ValueError(f"Points have shape {points.shape}; (..., 2) is needed.")
    return points
