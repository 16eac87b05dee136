"""The skin that touches: where a fingertip, which has a size, should be displayed.

A tracked fingertip is a point inside the finger, a radius r away from the skin. `centre` warps that
point itself. `pad` warps one point of the skin, which stands still in the fingertip's frame. `skin`
takes the point of the skin nearest to the prop, p = c − r m, with m the direction out of the prop
there, and displays the centre at f(p) + r m′, where m′ ∝ cof(∂f) m is what ∂f makes of the tangent
plane's normal: a ball that touches the prop at p is displayed as a ball that touches the virtual
surface at f(p). The farther the finger is from the prop, the more `skin` becomes `centre`.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.hand.kinematics import turn_by, turn_on

NEAR, FAR = 5e-3, 30e-3
"""m between skin and prop: up to NEAR the skin is displayed, from FAR on the centre."""

STENCIL = 5e-3
"""m: half the width over which ∂f is averaged, since it jumps between cells and f does not."""

_MELD = 5e-4
_SWEEPS = 20

Float = NDArray[np.float64]


class NearestSurface(Protocol):
    """The props' surface, for `contact="skin"`."""

    def __call__(self, points: Float) -> tuple[Float, Float]:
        """Nearest points of the surface and its outward unit normals there.

        Args:
            points: (n, 3) m, room frame; NaN for lost fingers, whose results do not matter.

        Returns:
            (n, 3) m, room frame, and (n, 3).
        """
        ...


@njit(cache=True, nogil=True, error_model="numpy")
def write_stencil(centre, width, points):
    """points (6, 3): a step of `width` back and forth along each axis."""
    for n in range(6):
        for d in range(3):
            points[n, d] = centre[d]
        points[n, n // 2] += width if n % 2 else -width


@njit(cache=True, nogil=True, error_model="numpy")
def slope_of(shown, width, J):
    """J (3, 3) = ∂f/∂x by central differences of f (6, 3) at `write_stencil`'s points."""
    for d in range(3):
        for e in range(3):
            J[d, e] = (shown[2 * e + 1, d] - shown[2 * e, d]) / (2.0 * width)


@njit(cache=True, nogil=True, error_model="numpy")
def turn_of(J, R):
    """R (3, 3): the rotation nearest to J, by turning on from the identity (Müller et al. 2016).

    Every sweep is continuous in J, so R is, also where J is singular; only where J mirrors, by more
    than it stretches elsewhere, is there no one nearest rotation.
    """
    R[:] = 0.0
    R[0, 0] = R[1, 1] = R[2, 2] = 1.0
    step, work, vector = np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    for _ in range(_SWEEPS):
        vector[:] = 0.0
        along = 0.0
        for n in range(3):
            vector[0] += R[1, n] * J[2, n] - R[2, n] * J[1, n]
            vector[1] += R[2, n] * J[0, n] - R[0, n] * J[2, n]
            vector[2] += R[0, n] * J[1, n] - R[1, n] * J[0, n]
            along += R[0, n] * J[0, n] + R[1, n] * J[1, n] + R[2, n] * J[2, n]
        vector /= abs(along) + 1e-9
        if vector @ vector < 1e-24:
            break
        turn_by(vector, step)
        turn_on(R, step, work)


@njit(cache=True, nogil=True, error_model="numpy")
def touch_directions(centres, nearest, normals, radii, outward, points, share):
    """Where the skin of each fingertip is nearest to the prop.

    Args:
        centres: (n, 3) m; nearest, normals: (n, 3), the surface there; radii: (n,) m.
        outward: (n, 3), written: m; points: (n, 3) m, written: p.
        share: (n,), written: 1 near the surface, 0 far from it.
    """
    for n in range(len(centres)):
        away = 0.0
        side = 0.0
        for d in range(3):
            v = centres[n, d] - nearest[n, d]
            away += v * v
            side += v * normals[n, d]
        sign = 1.0 if side >= 0.0 else -1.0
        length = 0.0
        for d in range(3):
            # at the surface itself the way to it has no direction: the normal takes over
            v = sign * (centres[n, d] - nearest[n, d]) + _MELD * normals[n, d]
            outward[n, d] = v
            length += v * v
        length = math.sqrt(length)
        gap = sign * math.sqrt(away) - radii[n]
        part = min(max((FAR - gap) / (FAR - NEAR), 0.0), 1.0)
        share[n] = part * part * (3.0 - 2.0 * part)
        for d in range(3):
            outward[n, d] /= length
            points[n, d] = centres[n, d] - radii[n] * outward[n, d]


@njit(cache=True, nogil=True, error_model="numpy")
def place_skin(shown_centre, shown_point, J, outward, radius, share, goal):
    """goal (3,): where to display the centre of a fingertip, see the module."""
    length = 0.0
    for d in range(3):
        i, j = (d + 1) % 3, (d + 2) % 3
        goal[d] = 0.0
        for e in range(3):
            g, h = (e + 1) % 3, (e + 2) % 3
            goal[d] += (J[i, g] * J[j, h] - J[i, h] * J[j, g]) * outward[e]
        length += goal[d] * goal[d]
    length = math.sqrt(length)
    for d in range(3):
        # where ∂f is singular there is no tangent plane: keep the direction
        direction = goal[d] / length if length > 1e-9 else outward[d]
        skin = shown_point[d] + radius * direction
        goal[d] = shown_centre[d] + share * (skin - shown_centre[d])
