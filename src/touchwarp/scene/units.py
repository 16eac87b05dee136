"""Units of length and up axes of mesh files."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import SceneError
from touchwarp.scene.nearest import suggest

METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254, "ft": 0.3048}

# The rows say which file axis becomes scene x, y and z; each matrix is a proper rotation.
UP_AXES: dict[str, list[list[int]]] = {
    "x": [[0, 1, 0], [0, 0, 1], [1, 0, 0]],
    "y": [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
    "z": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "-x": [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
    "-y": [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
    "-z": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
}


def metres_per_unit(unit: str | float) -> float:
    """Metres in one unit; a number is taken as metres itself, for files in no unit at all."""
    if isinstance(unit, str):
        if unit not in METRES:
            raise SceneError(f"unknown unit '{unit}'. {suggest(unit, METRES)}")
        return METRES[unit]
    if isinstance(unit, bool) or not isinstance(unit, (int, float)):
        raise SceneError(
            f"the unit is {unit!r}; one of {', '.join(METRES)}, or a number of metres, is needed."
        )
    if not math.isfinite(unit) or unit <= 0:
        raise SceneError(f"the unit is {unit} m; a finite number of metres > 0 is needed.")
    return float(unit)


def up_rotation(up: str) -> NDArray[np.float64]:
    """The (3, 3) rotation that turns a file's `up` axis to the scene's z."""
    if up not in UP_AXES:
        raise SceneError(f"unknown up axis '{up}'. {suggest(up, UP_AXES)}")
    return np.array(UP_AXES[up], dtype=np.float64)
