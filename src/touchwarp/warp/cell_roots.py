"""The root of f(x) = y in one cell of a table that is nearest to y.

In a cell f = x + u is trilinear, so over any box in it f stays in the hull of its values at the
box's corners. A box is halved until its hull leaves y out or f is provably one-to-one in it:
|I − J₀⁻¹J| ≤ ½ at the corners bounds it inside, as J is multi-affine. There a contraction that
never leaves the box finds the root, or stops where there is none.
"""

from __future__ import annotations

import numpy as np
from numba import njit

SLACK = 1e-12
"""m, by which hulls are widened against rounding."""

DEEPEST = 12
"""A part of a cell that has been halved so often is not halved again."""

_MOST_PARTS = 4096
_ACCEPT = 1e-10


@njit(cache=True, nogil=True)
def distance2(y, x0, x1, x2, s0, s1, s2):
    """Squared distance from y to the box with lowest corner x and sides s."""
    a = max(x0 - y[0], 0.0, y[0] - x0 - s0)
    b = max(x1 - y[1], 0.0, y[1] - x1 - s1)
    c = max(x2 - y[2], 0.0, y[2] - x2 - s2)
    return a * a + b * b + c * c


@njit(cache=True, nogil=True)
def _trilinear(corner, a, b, c, g):
    for d in range(3):
        e00 = corner[0, d] * (1.0 - c) + corner[1, d] * c
        e01 = corner[2, d] * (1.0 - c) + corner[3, d] * c
        e10 = corner[4, d] * (1.0 - c) + corner[5, d] * c
        e11 = corner[6, d] * (1.0 - c) + corner[7, d] * c
        g[d] = (1.0 - a) * ((1.0 - b) * e00 + b * e01) + a * ((1.0 - b) * e10 + b * e11)


@njit(cache=True, nogil=True)
def _slope(corner, a, b, c, J):
    """∂/∂(place in the cell) of the trilinear map with these corner values."""
    for d in range(3):
        v = corner[:, d]
        e00, e01 = v[0] * (1.0 - c) + v[1] * c, v[2] * (1.0 - c) + v[3] * c
        e10, e11 = v[4] * (1.0 - c) + v[5] * c, v[6] * (1.0 - c) + v[7] * c
        J[d, 0] = (1.0 - b) * (e10 - e00) + b * (e11 - e01)
        J[d, 1] = (1.0 - a) * (e01 - e00) + a * (e11 - e10)
        J[d, 2] = (1.0 - a) * ((1.0 - b) * (v[1] - v[0]) + b * (v[3] - v[2]))
        J[d, 2] += a * ((1.0 - b) * (v[5] - v[4]) + b * (v[7] - v[6]))


@njit(cache=True, nogil=True)
def _inverted(J, K):
    """K = J⁻¹; False where J is all but singular."""
    K[0, 0] = J[1, 1] * J[2, 2] - J[1, 2] * J[2, 1]
    K[0, 1] = J[0, 2] * J[2, 1] - J[0, 1] * J[2, 2]
    K[0, 2] = J[0, 1] * J[1, 2] - J[0, 2] * J[1, 1]
    K[1, 0] = J[1, 2] * J[2, 0] - J[1, 0] * J[2, 2]
    K[1, 1] = J[0, 0] * J[2, 2] - J[0, 2] * J[2, 0]
    K[1, 2] = J[0, 2] * J[1, 0] - J[0, 0] * J[1, 2]
    K[2, 0] = J[1, 0] * J[2, 1] - J[1, 1] * J[2, 0]
    K[2, 1] = J[0, 1] * J[2, 0] - J[0, 0] * J[2, 1]
    K[2, 2] = J[0, 0] * J[1, 1] - J[0, 1] * J[1, 0]
    determinant = J[0, 0] * K[0, 0] + J[0, 1] * K[1, 0] + J[0, 2] * K[2, 0]
    size = 0.0
    for d in range(3):
        for e in range(3):
            size = max(size, abs(J[d, e]))
    if not abs(determinant) > 1e-12 * size**3:
        return False
    for d in range(3):
        for e in range(3):
            K[d, e] /= determinant
    return True


@njit(cache=True, nogil=True)
def _settle(corner, K, lo, size, newton, place, g, J, to):
    """Iterate to the root in a part of a cell, never leaving it; whether there is one.

    K is the inverse slope in the middle; where `newton`, it is renewed at every step.
    """
    for d in range(3):
        place[d] = lo[d] + 0.5 * size
    for step in range(60):
        _trilinear(corner, place[0], place[1], place[2], g)
        if newton or step % 4 == 3:
            _slope(corner, place[0], place[1], place[2], J)
            if not _inverted(J, K):
                break
        moved = 0.0
        for d in range(3):
            to[d] = place[d] - (K[d, 0] * g[0] + K[d, 1] * g[1] + K[d, 2] * g[2])
            to[d] = min(max(to[d], lo[d]), lo[d] + size)
        for d in range(3):
            moved = max(moved, abs(to[d] - place[d]))
            place[d] = to[d]
        if moved < 1e-14:
            break
    _trilinear(corner, place[0], place[1], place[2], g)
    return max(abs(g[0]), abs(g[1]), abs(g[2])) < _ACCEPT


@njit(cache=True, nogil=True)
def search_cell(corner, y, x0, side, best, nearest, work, stack):
    """The root in one cell nearest to y, if nearer than `best`; the new least squared distance.

    Args:
        corner: (8, 3) f − y at the corners. x0: lowest corner; side: (3,) its sides.
        nearest: (3,) written with the root. work, stack: working space.
    """
    g, place, lo, to = work[0], work[1], work[2], work[9]
    J, K = work[3:6], work[6:9]
    stack[0, :3] = 0.0
    stack[0, 3] = 1.0
    top, parts = 1, 0
    while top > 0 and parts < _MOST_PARTS:
        top -= 1
        parts += 1
        lo[0], lo[1], lo[2], size = stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3]
        if (
            distance2(
                y,
                x0[0] + lo[0] * side[0],
                x0[1] + lo[1] * side[1],
                x0[2] + lo[2] * side[2],
                size * side[0],
                size * side[1],
                size * side[2],
            )
            >= best
        ):
            continue
        low0 = low1 = low2 = np.inf
        high0 = high1 = high2 = -np.inf
        for n in range(8):
            _trilinear(
                corner,
                lo[0] + size * (n >> 2),
                lo[1] + size * (n >> 1 & 1),
                lo[2] + size * (n & 1),
                g,
            )
            low0, high0 = min(low0, g[0]), max(high0, g[0])
            low1, high1 = min(low1, g[1]), max(high1, g[1])
            low2, high2 = min(low2, g[2]), max(high2, g[2])
        if max(low0, low1, low2) > SLACK or min(high0, high1, high2) < -SLACK:
            continue
        middle = 0.5 * size
        _slope(corner, lo[0] + middle, lo[1] + middle, lo[2] + middle, J)
        single = _inverted(J, K)
        if single:
            departure = 0.0
            for n in range(8):
                _slope(
                    corner,
                    lo[0] + size * (n >> 2),
                    lo[1] + size * (n >> 1 & 1),
                    lo[2] + size * (n & 1),
                    J,
                )
                for d in range(3):
                    total = 0.0
                    for e in range(3):
                        entry = K[d, 0] * J[0, e] + K[d, 1] * J[1, e] + K[d, 2] * J[2, e]
                        total += abs((1.0 if d == e else 0.0) - entry)
                    departure = max(departure, total)
            single = departure <= 0.5
        if single or size <= 2.0**-DEEPEST:
            if _settle(corner, K, lo, size, not single, place, g, J, to):
                distance = 0.0
                for d in range(3):
                    distance += (x0[d] + place[d] * side[d] - y[d]) ** 2
                if distance < best:
                    best = distance
                    for d in range(3):
                        nearest[d] = x0[d] + place[d] * side[d]
            continue
        for n in range(8):
            stack[top, 0] = lo[0] + middle * (n >> 2)
            stack[top, 1] = lo[1] + middle * (n >> 1 & 1)
            stack[top, 2] = lo[2] + middle * (n & 1)
            stack[top, 3] = middle
            top += 1
    return best
