"""Rotations and joints of one finger, in numba's plain loops; used by `touchwarp.hand.solver`.

Rotations R have columns x, y, z.
"""

from __future__ import annotations

import math

from numba import njit

LEAST = 0.05
"""A pivot is to keep this share of what the unknown's own spring alone would give."""


@njit(cache=True, nogil=True, error_model="numpy")
def turn_about(axis, angle, R):
    """R (3, 3) = rotation by `angle` about a unit axis."""
    c, s = math.cos(angle), math.sin(angle)
    x, y, z = axis[0], axis[1], axis[2]
    o = 1.0 - c
    R[0, 0], R[0, 1], R[0, 2] = c + o * x * x, o * x * y - s * z, o * x * z + s * y
    R[1, 0], R[1, 1], R[1, 2] = o * x * y + s * z, c + o * y * y, o * y * z - s * x
    R[2, 0], R[2, 1], R[2, 2] = o * x * z - s * y, o * y * z + s * x, c + o * z * z


@njit(cache=True, nogil=True, error_model="numpy")
def turn_by(vector, R):
    """R (3, 3) = rotation by |vector| about it."""
    angle = math.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)
    if angle < 1e-12:
        R[:] = 0.0
        R[0, 0] = R[1, 1] = R[2, 2] = 1.0
        return
    turn_about(vector / angle, angle, R)


@njit(cache=True, nogil=True, error_model="numpy")
def multiply(A, B, out):
    """out = A B, all (3, 3); out is neither."""
    for i in range(3):
        for j in range(3):
            out[i, j] = A[i, 0] * B[0, j] + A[i, 1] * B[1, j] + A[i, 2] * B[2, j]


@njit(cache=True, nogil=True, error_model="numpy")
def turn_on(R, step, work):
    """R ← step R, all (3, 3); work is neither."""
    multiply(step, R, work)
    for i in range(3):
        for j in range(3):
            R[i, j] = work[i, j]


@njit(cache=True, nogil=True, error_model="numpy")
def place(chain, finger, palm_turn, palm_shift, centre, axes, q, turns, joints, moved_axes):
    """One finger's joints and axes as displayed.

    Args:
        chain: (5, 4, 3) m, tracked: base, two joints, and the point that should be somewhere.
        palm_turn, palm_shift, centre: the palm takes x to centre + shift + turn (x − centre).
        axes: (4, 3), tracked. q: (4,) rad.
        turns: (7, 3, 3) working space; turns[0], [1], [2] are left as the turns of the three bones.
        joints: (4, 3) m and moved_axes: (4, 3), written.
    """
    work = turns[3]
    for d in range(3):
        joints[0, d] = centre[d] + palm_shift[d]
        for e in range(3):
            joints[0, d] += palm_turn[d, e] * (chain[finger, 0, e] - centre[e])
    turn_about(axes[0], q[0], turns[4])
    turn_about(axes[1], q[1], turns[5])
    multiply(palm_turn, turns[4], turns[6])  # what the axis of abduction turns with
    multiply(turns[6], turns[5], turns[0])
    turn_about(axes[2], q[2], work)
    multiply(turns[0], work, turns[1])
    turn_about(axes[3], q[3], work)
    multiply(turns[1], work, turns[2])
    for n in range(3):
        for d in range(3):
            joints[n + 1, d] = joints[n, d]
            for e in range(3):
                step = chain[finger, n + 1, e] - chain[finger, n, e]
                joints[n + 1, d] += turns[n, d, e] * step
    for n in range(4):
        if n == 0:
            T = palm_turn
        elif n == 1:
            T = turns[6]
        else:
            T = turns[n - 2]
        x, y, z = axes[n]
        for d in range(3):
            moved_axes[n, d] = T[d, 0] * x + T[d, 1] * y + T[d, 2] * z


@njit(cache=True, nogil=True, error_model="numpy")
def factor(A, springs):
    """A = L Lᵀ (n, n), in its lower half, with 1 / L_jj on the diagonal.

    Args:
        springs: (n,), stiffness that each unknown has by itself.

    Returns:
        Whether A is definite enough: each pivot keeps a share of its spring.
    """
    n = len(springs)
    for j in range(n):
        pivot = A[j, j]
        for k in range(j):
            pivot -= A[j, k] * A[j, k]
        if not pivot > LEAST * springs[j]:
            return False
        A[j, j] = 1.0 / math.sqrt(pivot)
        for i in range(j + 1, n):
            for k in range(j):
                A[i, j] -= A[i, k] * A[j, k]
            A[i, j] *= A[j, j]
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def half_solve(L, b):
    """b ← L⁻¹ b, with the factor of `factor`."""
    for i in range(len(b)):
        for k in range(i):
            b[i] -= L[i, k] * b[k]
        b[i] *= L[i, i]


@njit(cache=True, nogil=True, error_model="numpy")
def other_half(L, b):
    """b ← L⁻ᵀ b, with the factor of `factor`."""
    for i in range(len(b) - 1, -1, -1):
        for k in range(i + 1, len(b)):
            b[i] -= L[k, i] * b[k]
        b[i] *= L[i, i]


@njit(cache=True, nogil=True, error_model="numpy")
def rotation_vector(R, out):
    """The vector θ of a rotation R = exp[θ]×, of an angle below π."""
    x, y, z = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    twice_sine = math.sqrt(x * x + y * y + z * z)
    angle = math.atan2(twice_sine, R[0, 0] + R[1, 1] + R[2, 2] - 1.0)
    scale = 0.5 if twice_sine < 1e-9 else angle / twice_sine
    out[0], out[1], out[2] = scale * x, scale * y, scale * z
