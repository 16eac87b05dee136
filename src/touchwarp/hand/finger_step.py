"""One finger in a Newton step of the whole hand: its angles leave the palm's equations.

With the force f = w (target − tip) of the last step, the energy's second derivatives are those of
springs and squared miss, w FᵀF (F the motion of the tip by the angles), less f · ∂²tip: how the
tip's path bends. That force has settled long before the miss has, whose own is far too great at
first. Where springs do not outweigh it, |f| times the lengths of the arms does as damping.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from touchwarp.hand.kinematics import factor, half_solve, other_half

FLEX, ABDUCT = 6e-3, 1e-2
"""m/rad: what bending a joint costs, as the miss of a fingertip that costs as much."""

LIMIT = 0.2
"""m/rad: the spring beyond a limit."""


@njit(cache=True, nogil=True, error_model="numpy")
def linearise(joints, axes, q, bounds, arm, F, P, reach, stiffness, pull):
    """Where the finger is: springs and slopes.

    Args:
        joints: (4, 3) m and axes: (4, 3), as displayed now. q: (4,), bounds: (4, 2) rad.
        arm: (3,) m, from the palm's centre to the tip.
        F: (4, 3) m/rad, the tip's motion by the angles, and P: (6, 3) by the palm's shift and turn;
            reach: (4,) m from each joint to the tip; stiffness: (4,) and pull: (4,) of the springs;
            all written.
    """
    for n in range(4):
        beyond = q[n] - min(max(q[n], bounds[n, 0]), bounds[n, 1])
        spring = ABDUCT * ABDUCT if n == 1 else FLEX * FLEX
        stiffness[n] = spring if beyond == 0.0 else spring + LIMIT * LIMIT
        pull[n] = spring * q[n] + LIMIT * LIMIT * beyond
        j = max(n - 1, 0)
        x, y, z = (
            joints[3, 0] - joints[j, 0],
            joints[3, 1] - joints[j, 1],
            joints[3, 2] - joints[j, 2],
        )
        reach[n] = math.sqrt(x * x + y * y + z * z)
        F[n, 0] = axes[n, 1] * z - axes[n, 2] * y
        F[n, 1] = axes[n, 2] * x - axes[n, 0] * z
        F[n, 2] = axes[n, 0] * y - axes[n, 1] * x
    P[:] = 0.0
    P[0, 0] = P[1, 1] = P[2, 2] = 1.0
    P[3, 1], P[3, 2] = -arm[2], arm[1]
    P[4, 0], P[4, 2] = arm[2], -arm[0]
    P[5, 0], P[5, 1] = -arm[1], arm[0]


@njit(cache=True, nogil=True, error_model="numpy")
def eliminate(
    weight, curved, axes, force, miss, arm, F, P, reach, stiffness, pull, H, halves, A, b
):
    """Add what the finger leaves to the palm's equations A δ = b (lower half of A).

    Args:
        curved: whether paths bend, or are damped instead.
        H: (4, 4) and halves: (7, 4), written: the angles' factor, and the palm's six columns and
            the right side by half of its inverse.

    Returns:
        False where springs do not outweigh the bending; A and b are then not to be used.
    """
    K = np.zeros((3, 3))
    _set_curvature(curved, axes, force, arm, F, reach, H, halves, K)
    for n in range(4):
        for m in range(n + 1):
            total = 0.0
            for d in range(3):
                total += weight * F[n, d] * F[m, d]
            H[n, m] += total
        H[n, n] += stiffness[n]
        for m in range(7):
            total = 0.0
            for d in range(3):
                total += weight * F[n, d] * (miss[d] if m == 6 else P[m, d])
            halves[m, n] += total
        halves[6, n] -= pull[n]
    if not factor(H, stiffness):
        return False
    for m in range(7):
        half_solve(H, halves[m])
    for m in range(6):
        for n in range(m + 1):
            own, gone = 0.0, 0.0
            for d in range(3):
                own += weight * P[m, d] * P[n, d]
            for k in range(4):
                gone += halves[m, k] * halves[n, k]
            A[m, n] += own - gone + (K[m - 3, n - 3] if n >= 3 else 0.0)
        own, gone = 0.0, 0.0
        for d in range(3):
            own += weight * P[m, d] * miss[d]
        for k in range(4):
            gone += halves[m, k] * halves[6, k]
        b[m] += own - gone
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def follow(weight, delta, miss, F, P, H, halves, bend, force):
    """What the palm's step δ (6,) leaves: bend (4,) rad and force (3,), both written."""
    for n in range(4):
        bend[n] = halves[6, n]
        for m in range(6):
            bend[n] -= halves[m, n] * delta[m]
    other_half(H, bend)
    for d in range(3):
        left = miss[d]
        for m in range(6):
            left -= P[m, d] * delta[m]
        for n in range(4):
            left -= F[n, d] * bend[n]
        force[d] = weight * left


@njit(cache=True, nogil=True, error_model="numpy")
def _set_curvature(curved, axes, f, arm, F, reach, H, halves, K):
    """−f · ∂²tip: by two angles into H, by angle and turn into halves, by the turn into K."""
    H[:] = 0.0
    halves[:] = 0.0
    if not curved:
        size = math.sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2])
        for n in range(4):
            H[n, n] = size * reach[n]
        length = math.sqrt(arm[0] * arm[0] + arm[1] * arm[1] + arm[2] * arm[2])
        K[0, 0] = K[1, 1] = K[2, 2] = size * length
        return
    for n in range(4):
        for d in range(3):
            i, j = (d + 1) % 3, (d + 2) % 3
            halves[3 + d, n] = f[i] * F[n, j] - f[j] * F[n, i]
        for m in range(n + 1):
            for d in range(3):
                H[n, m] += axes[m, d] * halves[3 + d, n]
    for d in range(3):
        i, j = (d + 1) % 3, (d + 2) % 3
        K[d, d] = f[i] * arm[i] + f[j] * arm[j]
        for e in range(d):
            K[d, e] = -0.5 * (f[d] * arm[e] + f[e] * arm[d])
