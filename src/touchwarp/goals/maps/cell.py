"""Where two triangles meet: a convex cell, told by signs alone.

A cell's corners are corners of the one triangle inside the other, and crossings of their edges;
each of the six edges that takes part holds one side of the cell, from its first corner to its last,
and so the cell's outline is found without measuring anything. All is read off two tables of signed
determinants: `of_prop[e, i]` tells on which side of the prop's edge e, from corner e to the next,
the virtual triangle's corner i lies; `of_virtual[k, j]` the same of the virtual triangle's edge k
and the prop's corner j.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Float = NDArray[np.float64]
Int = NDArray[np.int64]

MOST_CORNERS = 6
PROP_CORNER, VIRTUAL_CORNER, CROSSING = 0, 1, 2


class Cells(NamedTuple):
    """Where pairs of triangles meet: convex polygons, counter-clockwise seen from outside.

    Attributes:
        corners: (q,) how many each cell has, 3 to 6.
        kind: (q, 6) PROP_CORNER, VIRTUAL_CORNER or CROSSING.
        place: (q, 6, 2) which corner of its own triangle it is, or which edges of the prop's and
            of the virtual triangle cross, edge k from corner k to the next.
        part: (q, 6, 3) barycentric coordinates of a corner in the other triangle; for a crossing,
            how far along the two edges it is.
        closed: every outline was.
    """

    corners: Int
    kind: Int
    place: Int
    part: Float
    closed: bool

    @property
    def there(self) -> NDArray[np.bool_]:
        """(q, 6): which of the corners exist."""
        return np.arange(MOST_CORNERS) < self.corners[:, None]


def no_cells(pairs: int) -> Cells:
    """Room for the cells of so many pairs."""
    return Cells(
        np.zeros(pairs, np.int64),
        np.zeros((pairs, MOST_CORNERS), np.int64),
        np.zeros((pairs, MOST_CORNERS, 2), np.int64),
        np.zeros((pairs, MOST_CORNERS, 3)),
        True,
    )


@njit(cache=True, error_model="numpy")
def edge_meets(of_prop, of_virtual, i):
    """Whether the virtual edge i meets the prop's triangle; and whether no sign was zero."""
    j = (i + 1) % 3
    i_inside, j_inside, crosses = True, True, False
    for e in range(3):
        at_i, at_j = of_prop[e, i], of_prop[e, j]
        if at_i == 0.0 or at_j == 0.0:
            return False, False
        i_inside, j_inside = i_inside and at_i > 0, j_inside and at_j > 0
        if (at_i > 0) != (at_j > 0):
            at_a, at_b = of_virtual[i, e], of_virtual[i, (e + 1) % 3]
            if at_a == 0.0 or at_b == 0.0:
                return False, False
            # the third comparison tells a crossing from one on the far side of the sphere
            crosses = crosses or ((at_a > 0) != (at_b > 0) and (at_a > 0) != (at_i > 0))
    return i_inside or j_inside or crosses, True


@njit(cache=True, error_model="numpy")
def cut_cell(of_prop, of_virtual, kind, place, part):
    """Fill in one cell, (6,), (6, 2) and (6, 3); how many corners it has, and whether it closes."""
    first, last = np.full(6, -1, np.int64), np.full(6, -1, np.int64)
    kinds, places, parts = np.empty(15, np.int64), np.zeros((15, 2), np.int64), np.empty((15, 3))
    n = 0
    for which, side in ((PROP_CORNER, of_virtual), (VIRTUAL_CORNER, of_prop)):
        for j in range(3):
            if side[0, j] > 0 and side[1, j] > 0 and side[2, j] > 0:
                total = side[0, j] + side[1, j] + side[2, j]
                kinds[n], places[n, 0] = which, j
                for d in range(3):
                    parts[n, d] = side[(d + 1) % 3, j] / total
                first[3 * which + j] = n
                last[3 * which + (j + 2) % 3] = n
                n += 1
    for e in range(3):
        for k in range(3):
            at_a, at_b = of_virtual[k, e], of_virtual[k, (e + 1) % 3]
            at_u, at_w = of_prop[e, k], of_prop[e, (k + 1) % 3]
            if (at_a > 0) == (at_b > 0) or (at_u > 0) == (at_w > 0) or (at_a > 0) == (at_u > 0):
                continue
            kinds[n], places[n, 0], places[n, 1] = CROSSING, e, k
            parts[n, 0], parts[n, 1] = at_a / (at_a - at_b), at_u / (at_u - at_w)
            if at_a < 0:  # the prop's edge comes into the virtual triangle here
                first[e], last[3 + k] = n, n
            else:
                last[e], first[3 + k] = n, n
            n += 1
    closed, after = True, np.full(15, -1, np.int64)
    for edge in range(6):
        if (first[edge] < 0) != (last[edge] < 0):
            closed = False
        elif first[edge] >= 0:
            after[first[edge]] = last[edge]
    here, done = 0, 0
    while done < n and done < MOST_CORNERS and here >= 0:
        kind[done], place[done], part[done] = kinds[here], places[here], parts[here]
        done += 1
        here = after[here]
    return done, closed and here == 0 and done == n and n >= 3
