"""The solver's frame: axes along the outer box or the sliding plane, and the root grid in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

CELLS = 8
"""Cells along a brick's side, in the grid and in the table alike."""

ROOT_BRICKS = 4
"""Root bricks along the longest side of the domain."""


@dataclass(frozen=True, eq=False)
class Frame:
    """Where the grid lies.

    Attributes:
        T_scene_table: (4, 4) rigid, table frame (origin at the root grid's lowest corner) to scene.
        spacing: (3,) m, sides of a root cell; nearly, not exactly, equal, so that the root grid
            fills any box.
        root_bricks: (3,) int64, root bricks along each axis.
        mirrored: the grid's floor z = 0 is a sliding plane.
    """

    T_scene_table: NDArray[np.float64]
    spacing: NDArray[np.float64]
    root_bricks: NDArray[np.int64]
    mirrored: bool

    @property
    def root_cells(self) -> NDArray[np.int64]:
        """(3,) cells of the root grid along each axis."""
        return CELLS * self.root_bricks

    @property
    def size(self) -> NDArray[np.float64]:
        """(3,) m, sides of the root grid."""
        return self.spacing * self.root_cells

    def to_grid(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Root-grid coordinates (n, 3), in cells, of scene points (n, 3) m."""
        rotation, origin = self.T_scene_table[:3, :3], self.T_scene_table[:3, 3]
        return np.ascontiguousarray(((points - origin) @ rotation) / self.spacing)

    def to_scene(self, grid_points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Scene points (n, 3) m of root-grid coordinates (n, 3)."""
        rotation, origin = self.T_scene_table[:3, :3], self.T_scene_table[:3, 3]
        return (grid_points * self.spacing) @ rotation.T + origin

    def axes_from_scene(self, vectors: NDArray[np.float64]) -> NDArray[np.float64]:
        """Components along the table's axes (n, 3) of scene vectors (n, 3)."""
        return vectors @ self.T_scene_table[:3, :3]


def frame_of_box(
    box: NDArray[np.float64],
    rotation_scene_table: NDArray[np.float64] | None = None,
    origin: NDArray[np.float64] | None = None,
    *,
    mirrored: bool = False,
) -> Frame:
    """The frame whose root grid fills a box exactly.

    Args:
        box: (2, 3) m, least and greatest corner along the table's axes, about `origin`.
        rotation_scene_table: (3, 3), table axes to scene axes; the identity without it.
        origin: (3,) m, scene frame, what `box` is relative to; the scene's origin without it.
        mirrored: the box's floor is a sliding plane.
    """
    rotation = np.eye(3) if rotation_scene_table is None else rotation_scene_table
    start = np.zeros(3) if origin is None else origin
    sides = box[1] - box[0]
    target = sides.max() / (ROOT_BRICKS * CELLS)
    bricks = np.maximum(np.rint(sides / (target * CELLS)), 1).astype(np.int64)
    T_scene_table = np.eye(4)
    T_scene_table[:3, :3] = rotation
    T_scene_table[:3, 3] = start + rotation @ box[0]
    return Frame(T_scene_table, sides / (bricks * CELLS), bricks, mirrored)
