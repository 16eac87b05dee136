"""A layout with whole numbers for coordinates, whose triangles are told left from right exactly.

Which triangles of two layouts meet, and where their edges cross, must be answered without
contradiction, however thin the triangles are. So points of the domain are rounded to multiples of
2⁻²⁸, half a nanometre on a thing of the size of a hand, and the sign of det(a, b, c) is that of
integer arithmetic in two limbs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.maps.layout import Layout

Int = NDArray[np.int64]

BITS = 28
ONE = 1 << BITS
"""The torus's period, and the sphere's radius."""
MOST = 4 * ONE
"""Coordinates below this keep all sums of `determinant` within 64 bits."""
LIMB = 31


@dataclass(frozen=True, eq=False)
class LatticeLayout:
    """A layout's triangles in whole numbers.

    Attributes:
        layout: what was rounded.
        corners: (m, 3, 3) in units of 2⁻²⁸; on a torus, each triangle near the origin.
        shift: (m, 3, 2) periods: a corner's vertex, so shifted, is that corner; zero on the sphere.
        jumps: (m, 3, 2) periods: what to add to a point when going across the edge opposite k.
    """

    layout: Layout
    corners: Int
    shift: Int
    jumps: Int


def on_lattice(layout: Layout, jitter: Int | None = None) -> LatticeLayout:
    """The layout rounded, its points first moved by jitter (n, 3), if given, in units of 2⁻²⁸.

    Raises:
        GoalError: a triangle is so thin that rounding turns it over.
    """
    points = np.rint(layout.points * ONE).astype(np.int64)
    if jitter is not None:
        points = points + jitter
    faces = layout.mesh.faces
    shift = layout.corner_shift.astype(np.int64)
    jumps = np.rint(layout.jumps).astype(np.int64)
    corners = points[faces]
    if layout.flat:
        corners[:, :, :2] += shift * ONE
        home = corners[:, 0, :2] >> BITS
        corners[:, :, :2] -= home[:, None] * ONE
        shift = shift - home[:, None]
        jumps = jumps + home[:, None] - home[layout.mesh.neighbours]
    if np.abs(corners).max() >= MOST or not _all_turned(corners):
        raise GoalError(
            "a map has triangles too thin to be told from turned ones; remesh the prop and the "
            "virtual object to even triangles."
        )
    return LatticeLayout(layout, np.ascontiguousarray(corners), shift, jumps)


@njit(cache=True, error_model="numpy")
def determinant(a, b, c):
    """det(a, b, c) of integer vectors below `MOST`: the sign exactly, the value to rounding."""
    high, low = np.int64(0), np.int64(0)
    for d in range(3):
        e, g = (d + 1) % 3, (d + 2) % 3
        minor = b[e] * c[g] - b[g] * c[e]
        top = minor >> LIMB
        high += top * a[d]
        low += (minor - (top << LIMB)) * a[d]
    carry = low >> LIMB
    return float(high + carry) * 2.0**LIMB + float(low - (carry << LIMB))


@njit(cache=True, error_model="numpy")
def _all_turned(corners):
    for f in range(len(corners)):
        if determinant(corners[f, 0], corners[f, 1], corners[f, 2]) <= 0.0:
            return False
    return True
