"""The numbers of a plane table: displacement at the nodes of one rectilinear grid."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import WarpFileError
from touchwarp.solve.plane_cuts import Curves
from touchwarp.solve.plane_grid import PlaneGrid
from touchwarp.warp.plane_fit import sample_contact

TENSORS = ("T_scene_table", "x_lines", "y_lines", "values", "outer_segments")
OUT, WITHIN, CROSSED = range(3)


@dataclass(frozen=True, eq=False)
class PlaneTable:
    """The table's data; between nodes it is bilinear, and beyond ∂Ω1 it is 0.

    Attributes:
        T_scene_table: (3, 3) rigid, table frame to scene frame.
        x_lines: (nx,) float64 m, ascending, table frame.
        y_lines: (ny,) float64 m, ascending, table frame.
        values: (nx, ny, 2) float32 or float16, m, u in table axes; indices [x, y].
        outer: (k, 2, 2) float64 m, table frame: the segments of an outer polygon, or none where
            ∂Ω1 is the box of the lines.
        mirror_depth: None, or the depth D in m of the space under a sliding line y = 0. A point at
            depth 0 < d < D under it takes u from its mirror image above, with the sign of u_y
            turned, times 1 - d / D; below that u = 0.
    """

    T_scene_table: NDArray[np.float64]
    x_lines: NDArray[np.float64]
    y_lines: NDArray[np.float64]
    values: NDArray[np.float32] | NDArray[np.float16]
    outer: NDArray[np.float64]
    mirror_depth: float | None = None

    def to_tensors(self) -> dict[str, NDArray[Any]]:
        """The arrays of the table by name, for a file; `mirror_depth` goes beside them."""
        return {
            "T_scene_table": self.T_scene_table,
            "x_lines": self.x_lines,
            "y_lines": self.y_lines,
            "values": self.values,
            "outer_segments": self.outer,
        }

    @classmethod
    def from_tensors(
        cls, tensors: Mapping[str, NDArray[Any]], mirror_depth: float | None
    ) -> PlaneTable:
        """The table of `to_tensors`.

        Raises:
            WarpFileError: an array is missing, or its shape or numbers cannot be a table's.
        """
        missing = [name for name in TENSORS if name not in tensors]
        if missing:
            raise WarpFileError(
                f"The plane table lacks the array '{missing[0]}'; the file is damaged or not "
                "touchwarp's: write the warp again."
            )
        x_lines, y_lines = (np.asarray(tensors[k], np.float64) for k in ("x_lines", "y_lines"))
        if tensors["values"].dtype not in (np.float32, np.float16):
            raise WarpFileError(
                f"The plane table's values are of type {tensors['values'].dtype}; float32 or "
                "float16 is needed: write the warp again."
            )
        shapes: dict[str, tuple[int, ...]] = {
            "T_scene_table": (3, 3),
            "values": (len(x_lines), len(y_lines), 2),
            "outer_segments": (len(tensors["outer_segments"]), 2, 2),
        }
        for name, shape in shapes.items():
            if tensors[name].shape != shape:
                raise WarpFileError(
                    f"The plane table's array '{name}' has shape {tensors[name].shape}; {shape} "
                    "is needed: the file is damaged; write the warp again."
                )
        for name in TENSORS:
            if not np.isfinite(tensors[name]).all():
                raise WarpFileError(
                    f"The plane table's array '{name}' has NaN or infinite numbers; the file is "
                    "damaged: write the warp again."
                )
        for name, lines in (("x_lines", x_lines), ("y_lines", y_lines)):
            if lines.ndim != 1 or len(lines) < 2 or not (np.diff(lines) > 0).all():
                raise WarpFileError(
                    f"The plane table's array '{name}' does not ascend; the file is damaged: "
                    "write the warp again."
                )
        return cls(
            np.asarray(tensors["T_scene_table"], np.float64),
            x_lines,
            y_lines,
            np.asarray(tensors["values"]),
            np.asarray(tensors["outer_segments"], np.float64),
            mirror_depth,
        )


def classify_cells(table: PlaneTable) -> NDArray[np.uint8]:
    """Which cells lie within the outer polygon, beyond it, or across it."""
    count = len(table.outer)
    curves = Curves(
        table.outer.reshape(-1, 2), np.arange(2 * count).reshape(-1, 2), np.zeros((2 * count, 2))
    )
    crossed = sample_contact(PlaneGrid(table.x_lines, table.y_lines, 0.0), curves).cell
    columns, rows = (0.5 * (lines[1:] + lines[:-1]) for lines in (table.x_lines, table.y_lines))
    passed = np.zeros((len(columns), len(rows) + 1), dtype=np.int64)
    for start, stop in table.outer:
        low, high = sorted((start[0], stop[0]))
        spanned = np.arange(*np.searchsorted(columns, (low, high)))
        if len(spanned):
            slope = (stop[1] - start[1]) / (stop[0] - start[0])
            height = start[1] + slope * (columns[spanned] - start[0])
            np.add.at(passed, (spanned, np.searchsorted(rows, height)), 1)
    within = np.cumsum(passed, axis=1)[:, :-1] % 2 == 1
    side = np.where(within, WITHIN, OUT).astype(np.uint8)
    side[tuple(crossed.T)] = CROSSED
    return side
