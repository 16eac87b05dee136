"""Rotations and rigid poses as matrices."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray


def rotation_matrix(rotation_deg: Sequence[float] | float) -> NDArray[np.float64]:
    """R = Rz·Ry·Rx: (3, 3) from three angles about x, y, z; (2, 2) from one angle.

    Angles are in degrees, about the axes of the frame that the rotation acts in.
    """
    if np.ndim(rotation_deg) == 0:
        c, s = _cos_sin(float(np.asarray(rotation_deg)))
        return np.array([[c, -s], [s, c]])
    (cx, sx), (cy, sy), (cz, sz) = (_cos_sin(float(a)) for a in np.asarray(rotation_deg))
    R_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    R_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    R_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    R: NDArray[np.float64] = R_z @ R_y @ R_x
    return R


def pose_matrix(
    position: Sequence[float], rotation_deg: Sequence[float] | float
) -> NDArray[np.float64]:
    """The rigid (d+1, d+1) matrix x ↦ R x + position; position in m, angles in degrees."""
    d = len(position)
    T = np.eye(d + 1)
    T[:d, :d] = rotation_matrix(rotation_deg)
    T[:d, d] = position
    return T


def angles_deg(R: NDArray[np.float64]) -> tuple[float, float, float]:
    """The three angles that `rotation_matrix` makes R (3, 3) of, the second within ±90°.

    Where the second is ±90° only a sum of the others is decided; the third is then 0.
    """
    from scipy.spatial.transform import Rotation

    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Gimbal lock", UserWarning)  # any of the answers will do
        x, y, z = Rotation.from_matrix(R).as_euler("xyz", degrees=True)
    return float(x), float(y), float(z)


def _cos_sin(angle_deg: float) -> tuple[float, float]:
    # Quarter turns are exact, so that a box turned by 90° keeps its faces on the grid.
    quarters, rest = divmod(angle_deg, 90.0)
    if rest == 0.0:
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarters) % 4]
    angle = np.deg2rad(angle_deg)
    return float(np.cos(angle)), float(np.sin(angle))
