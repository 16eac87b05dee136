"""A cap for a small hole whose rim is not flat: in a curved wall, or around a lip.

Of all triangulations of the rim with no new vertices, the one of least area (Barequet and Sharir
1995), found by dynamic programming over the rim's chords.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]
Int = NDArray[np.int64]

MOST_CORNERS = 300
"""Of a rim: the work grows as the cube, a second at so many."""


def least_area_cap(rim: Float, barred: NDArray[np.bool_]) -> Int | None:
    """Triangles (n − 2, 3) on the corners of a rim, turned as it runs; None where there are none.

    Args:
        rim: (n, 3) m, its corners in order.
        barred: (n, n): chords that may not be used, as the mesh has an edge there already.
    """
    n = len(rim)
    if n > MOST_CORNERS:
        return None
    least = np.full((n, n), np.inf)  # the area that closes the rim's part from i to j
    apex = np.zeros((n, n), dtype=np.int64)
    least[np.arange(n - 1), np.arange(1, n)] = 0.0
    for gap in range(2, n):
        i = np.arange(n - gap)[:, None]
        k = i + np.arange(1, gap)
        j = i + gap
        area = 0.5 * np.linalg.norm(np.cross(rim[k] - rim[i], rim[j] - rim[i]), axis=2)
        total = least[i, k] + least[k, j] + area
        best = total.argmin(axis=1)
        first, last = i[:, 0], j[:, 0]
        least[first, last] = np.take_along_axis(total, best[:, None], axis=1)[:, 0]
        apex[first, last] = first + 1 + best
        if gap < n - 1:
            least[first, last] = np.where(barred[first, last], np.inf, least[first, last])
    if not np.isfinite(least[0, n - 1]):
        return None
    triangles, parts = [], [(0, n - 1)]
    while parts:
        a, b = parts.pop()
        if b - a > 1:
            middle = int(apex[a, b])
            triangles.append((a, middle, b))
            parts += [(a, middle), (middle, b)]
    return np.array(triangles)
