"""What every warp can do, whatever it is made of."""

from __future__ import annotations

from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray


class Inverse(NamedTuple):
    """Where the real hand must be for given displayed positions.

    Attributes:
        points: (..., d) m, scene frame; NaN rows where none was found.
        found: (...) bool.
    """

    points: NDArray[np.float64]
    found: NDArray[np.bool_]


@runtime_checkable
class Warp(Protocol):
    """A map of space f(x) = x + u(x) from real to displayed positions (eq. 1, 2).

    Arrays are (..., d) m in the scene's frame, d = `dimension`. A NaN row in is a NaN row out (a
    lost joint must not raise at 90 Hz); a wrong last axis raises ValueError; outside ∂Ω1 u = 0.
    """

    @property
    def dimension(self) -> int:
        """3 in space, 2 in a plane scene."""
        ...

    def __call__(self, x: ArrayLike) -> NDArray[np.float64]:
        """Displayed positions f(x): (..., d) m for x (..., d) m."""
        ...

    def displacement(self, x: ArrayLike) -> NDArray[np.float64]:
        """u(x) = f(x) − x: (..., d) m for x (..., d) m."""
        ...

    def jacobian(self, x: ArrayLike) -> NDArray[np.float64]:
        """∂f/∂x: (..., d, d), entry [i, j] = ∂f_i/∂x_j, for x (..., d) m."""
        ...

    def inverse(self, x: ArrayLike) -> Inverse:
        """Real positions whose displayed position is x; under folds the root nearest to x."""
        ...

    def at(self, T_room_scene: ArrayLike) -> Warp:
        """The warp re-posed rigidly, x ↦ T f(T⁻¹ x), with no solve; T is (d+1, d+1)."""
        ...
