"""A warp carried along: whatever its kind, with no solve."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from touchwarp.warp.protocol import Inverse, Warp


class PosedWarp:
    """x ↦ T f(T⁻¹ x): a warp that goes along with a prop in the room.

    Args:
        warp: f, of any kind.
        T_room_scene: (d+1, d+1) rigid.

    Raises:
        ValueError: T_room_scene is not rigid.
    """

    def __init__(self, warp: Warp, T_room_scene: ArrayLike) -> None:
        self._warp = warp
        self._T = rigid(T_room_scene, "T_room_scene", warp.dimension)

    @property
    def dimension(self) -> int:
        """3 in space, 2 in a plane scene."""
        return self._warp.dimension

    @property
    def max_displacement(self) -> float | None:
        """A bound on |u| in m, where the carried warp knows one."""
        return getattr(self._warp, "max_displacement", None)

    @property
    def T_room_scene(self) -> NDArray[np.float64]:
        """(d+1, d+1), where the scene stands in the room."""
        return self._T.copy()

    def __call__(self, x: ArrayLike) -> NDArray[np.float64]:
        """f(x): (..., d) m, room frame."""
        return np.asarray(x, dtype=np.float64) + self.displacement(x)

    def displacement(self, x: ArrayLike) -> NDArray[np.float64]:
        """u(x): (..., d) m, room axes."""
        return self._warp.displacement(self._to_scene(x)) @ self._rotation.T

    def jacobian(self, x: ArrayLike) -> NDArray[np.float64]:
        """∂f/∂x: (..., d, d), room axes."""
        inner = self._warp.jacobian(self._to_scene(x))
        turned: NDArray[np.float64] = self._rotation @ inner @ self._rotation.T
        return turned

    def inverse(self, x: ArrayLike) -> Inverse:
        """Real positions whose displayed position is x; (..., d) m, room frame."""
        inner = self._warp.inverse(self._to_scene(x))
        d = self.dimension
        return Inverse(inner.points @ self._rotation.T + self._T[:d, d], inner.found)

    def at(self, T_room_scene: ArrayLike) -> PosedWarp:
        """The warp carried on: T takes this warp's frame to a new one."""
        further = rigid(T_room_scene, "T_room_scene", self.dimension)
        return PosedWarp(self._warp, further @ self._T)

    @property
    def _rotation(self) -> NDArray[np.float64]:
        return self._T[: self.dimension, : self.dimension]

    def _to_scene(self, x: ArrayLike) -> NDArray[np.float64]:
        points = np.asarray(x, dtype=np.float64)
        d = self.dimension
        if points.ndim == 0 or points.shape[-1] != d:
            raise ValueError(f"Points have shape {points.shape}; (..., {d}) is needed.")
        return (points - self._T[:d, d]) @ self._rotation


def rigid(transform: ArrayLike, name: str, dimension: int = 3) -> NDArray[np.float64]:
    """`transform` as a float64 array, if it is a rotation with a translation.

    Args:
        transform: (dimension + 1, dimension + 1).
        name: what to call it in messages.

    Raises:
        ValueError: it has another shape, is not finite, or scales, shears or mirrors.
    """
    d = dimension
    matrix = np.array(transform, dtype=np.float64)
    if matrix.shape != (d + 1, d + 1):
        raise ValueError(f"{name} has shape {matrix.shape}; a ({d + 1}, {d + 1}) matrix is needed.")
    if not np.isfinite(matrix).all():
        raise ValueError(f"{name} has NaN or infinite entries; finite numbers are needed.")
    last = [0.0] * d + [1.0]
    if not np.allclose(matrix[d], last, rtol=0.0, atol=1e-9):
        raise ValueError(
            f"{name} has the last row {matrix[d].tolist()}; {last} is needed "
            "(matrices act on columns: pass the transpose if yours act on rows)."
        )
    rotation = matrix[:d, :d]
    departure = float(np.abs(rotation @ rotation.T - np.eye(d)).max())
    determinant = float(np.linalg.det(rotation))
    if departure > 1e-6 or determinant < 0.0:
        raise ValueError(
            f"{name} is not rigid: its {d} × {d} part has determinant {determinant:.6g} and "
            f"departs from a rotation by {departure:.2g}; a rotation and a translation are "
            "needed. To scale or shear, change the goal instead."
        )
    return matrix
