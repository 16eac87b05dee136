"""One finger in a Newton step of the whole hand: its angles leave the palm's equations.

With the force f = w (target − tip) of the last step, the energy's second derivatives are those of
springs and squared miss, w FᵀF (F the motion of the tip by the angles), less f · ∂²tip: how the
tip's path bends. That force has settled long before the miss has, whose own is far too great at
first. Where springs do not outweigh it, |f| times the lengths of the arms does as damping.

The palm's turn moves the tip by θ × a, a the arm, and what angle and turn bend together goes with
f × F: so both come in as g = w a + f, and what the angles leave to the palm by F H⁻¹ Fᵀ alone.
"""

from __future__ import annotations

import math

from numba import njit

from touchwarp.hand.kinematics import factor, half_solve, other_half

FLEX, ABDUCT = 6e-3, 1e-2
"""m/rad: what bending a joint costs, as the miss of a fingertip that costs as much."""

LIMIT = 0.2
"""m/rad: the spring beyond a limit."""


@njit(cache=True, nogil=True, error_model="numpy")
def linearise(joints, axes, q, bounds, F, reach, stiffness, pull):
    """Where the finger is: springs and slopes.

    Args:
        joints: (4, 3) m and axes: (4, 3), as displayed now. q: (4,), bounds: (4, 2) rad.
        F: (4, 3) m/rad, the tip's motion by the angles; reach: (4,) m from each joint to the tip;
            stiffness: (4,) and pull: (4,) of the springs; all written.
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


@njit(cache=True, nogil=True, error_model="numpy")
def eliminate(
    weight, curved, axes, force, miss, arm, F, reach, stiffness, pull, moment, H, halves, A, b
):
    """Add what the finger leaves to the palm's equations A δ = b (lower half of A).

    With N = F H⁻¹ Fᵀ and r = F H⁻¹ p, p the angles' right side, shift and turn are left with

        w I − w² N,  w [a] − w [g] N,  w [a][a]ᵀ + K − [g] N [g]ᵀ;
        w (miss − r),  w a × miss − g × r,

    [a] the matrix of a ×. w [a][a]ᵀ + K, K how the path by the turn bends, is the symmetric part of
    g·a I − g aᵀ.

    Args:
        curved: whether paths bend, or are damped instead.
        arm: (3,) m: a, from the palm's centre to the tip.
        moment: (3,): g, H: (4, 4) and halves: (4, 4), written: the angles' factor, and F's columns
            and the angles' right side by half of its inverse.

    Returns:
        False where springs do not outweigh the bending; A and b are then not to be used.
    """
    damping = _set_curvature(weight, curved, axes, force, arm, F, reach, moment, H)
    for n in range(4):
        for m in range(n + 1):
            H[n, m] += weight * _dot(F[n], F[m])
        H[n, n] += stiffness[n]
        for d in range(3):
            halves[d, n] = F[n, d]
        halves[3, n] = weight * _dot(F[n], miss) - pull[n]
    if not factor(H, stiffness):
        return False
    for m in range(4):
        half_solve(H, halves[m])
    h0, h1, h2, p = halves[0], halves[1], halves[2], halves[3]
    n00, n10, n11 = _dot4(h0, h0), _dot4(h1, h0), _dot4(h1, h1)
    n20, n21, n22 = _dot4(h2, h0), _dot4(h2, h1), _dot4(h2, h2)
    r0, r1, r2 = _dot4(h0, p), _dot4(h1, p), _dot4(h2, p)
    A[0, 0] += weight - weight * weight * n00
    A[1, 0] -= weight * weight * n10
    A[1, 1] += weight - weight * weight * n11
    A[2, 0] -= weight * weight * n20
    A[2, 1] -= weight * weight * n21
    A[2, 2] += weight - weight * weight * n22
    a0, a1, a2 = arm[0], arm[1], arm[2]
    g0, g1, g2 = moment[0], moment[1], moment[2]
    x00, x01, x02 = g1 * n20 - g2 * n10, g1 * n21 - g2 * n11, g1 * n22 - g2 * n21  # [g] N
    x10, x11, x12 = g2 * n00 - g0 * n20, g2 * n10 - g0 * n21, g2 * n20 - g0 * n22
    x20, x21, x22 = g0 * n10 - g1 * n00, g0 * n11 - g1 * n10, g0 * n21 - g1 * n20
    A[3, 0] -= weight * x00
    A[3, 1] -= weight * (a2 + x01)
    A[3, 2] += weight * (a1 - x02)
    A[4, 0] += weight * (a2 - x10)
    A[4, 1] -= weight * x11
    A[4, 2] -= weight * (a0 + x12)
    A[5, 0] -= weight * (a1 + x20)
    A[5, 1] += weight * (a0 - x21)
    A[5, 2] -= weight * x22
    A[3, 3] += g1 * a1 + g2 * a2 + damping - (g1 * x02 - g2 * x01)
    A[4, 3] -= 0.5 * (g0 * a1 + g1 * a0) + (g1 * x12 - g2 * x11)
    A[4, 4] += g0 * a0 + g2 * a2 + damping - (g2 * x10 - g0 * x12)
    A[5, 3] -= 0.5 * (g0 * a2 + g2 * a0) + (g1 * x22 - g2 * x21)
    A[5, 4] -= 0.5 * (g1 * a2 + g2 * a1) + (g2 * x20 - g0 * x22)
    A[5, 5] += g0 * a0 + g1 * a1 + damping - (g0 * x21 - g1 * x20)
    m0, m1, m2 = weight * miss[0], weight * miss[1], weight * miss[2]
    b[0] += m0 - weight * r0
    b[1] += m1 - weight * r1
    b[2] += m2 - weight * r2
    b[3] += a1 * m2 - a2 * m1 - (g1 * r2 - g2 * r1)
    b[4] += a2 * m0 - a0 * m2 - (g2 * r0 - g0 * r2)
    b[5] += a0 * m1 - a1 * m0 - (g0 * r1 - g1 * r0)
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def follow(weight, delta, miss, arm, F, moment, H, halves, bend, force):
    """What the palm's step δ (6,) leaves: bend (4,) rad and force (3,), both written."""
    s0, s1, s2, t0, t1, t2 = delta[0], delta[1], delta[2], delta[3], delta[4], delta[5]
    y0 = weight * s0 + (t1 * moment[2] - t2 * moment[1])
    y1 = weight * s1 + (t2 * moment[0] - t0 * moment[2])
    y2 = weight * s2 + (t0 * moment[1] - t1 * moment[0])
    for n in range(4):
        bend[n] = halves[3, n] - (halves[0, n] * y0 + halves[1, n] * y1 + halves[2, n] * y2)
    other_half(H, bend)
    force[0] = miss[0] - s0 - (t1 * arm[2] - t2 * arm[1])
    force[1] = miss[1] - s1 - (t2 * arm[0] - t0 * arm[2])
    force[2] = miss[2] - s2 - (t0 * arm[1] - t1 * arm[0])
    for d in range(3):
        for n in range(4):
            force[d] -= F[n, d] * bend[n]
        force[d] *= weight


@njit(cache=True, nogil=True, error_model="numpy")
def _set_curvature(weight, curved, axes, f, arm, F, reach, moment, H):
    """g, and −f · ∂²tip by two angles into H; or what damps, for the palm's turn returned."""
    for d in range(3):
        moment[d] = weight * arm[d] + (f[d] if curved else 0.0)
    if not curved:
        H[:] = 0.0
        size = math.sqrt(_dot(f, f))
        for n in range(4):
            H[n, n] = size * reach[n]
        return size * math.sqrt(_dot(arm, arm))
    for n in range(4):
        c0 = f[1] * F[n, 2] - f[2] * F[n, 1]
        c1 = f[2] * F[n, 0] - f[0] * F[n, 2]
        c2 = f[0] * F[n, 1] - f[1] * F[n, 0]
        for m in range(n + 1):
            H[n, m] = axes[m, 0] * c0 + axes[m, 1] * c1 + axes[m, 2] * c2
    return 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def _dot(one, other):
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


@njit(cache=True, nogil=True, error_model="numpy")
def _dot4(one, other):
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2] + one[3] * other[3]
