"""All surfaces where u is given."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Boundary:
    """All surfaces where u is given, as one set of triangles.

    Attributes:
        corners: (v, 3) root-grid coordinates.
        faces: (t, 3) int32.
        owner: (t,) int16: the prop's number, -1 for a held surface, -2 for the outer surface.
    """

    corners: NDArray[np.float64]
    faces: NDArray[np.int32]
    owner: NDArray[np.int16]
