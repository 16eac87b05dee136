"""The rigid-boned hand whose fingertips come nearest to where they should be.

Unknown are the palm's shift t and turn θ and four angles q of each finger, all counted from the
tracked hand, so that nothing moves where nothing is asked for. They minimise

    Σ_i w_i |tip_i − target_i|² + |S q|² + s_t² |t − t₀|² + s_r² |θ − θ₀|²,

with angles beyond their limits held back by a stiff spring and cut off in the end. Steps are
Newton's, with each finger's angles eliminated (`finger_step`), which leaves six equations for the
palm. Once settled, what the stiffness has held back is added to the targets (iterated Tikhonov) and
the steps go on, so that tips which can be reached are, and ones which cannot make no joint swing.

There is no memory of the last frame: equal input gives equal output, and a lost or late frame
leaves no trace. The sums are written out since they run at every frame.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from touchwarp.hand.finger_step import eliminate, follow, linearise
from touchwarp.hand.kinematics import (
    factor,
    half_solve,
    multiply,
    other_half,
    place,
    rotation_vector,
    turn_by,
    turn_on,
)

STEPS = 24
"""Steps at most; 6 to 10 do."""

NEWTON_STEPS = 10
"""So many steps may be Newton's. What has not settled by then has joints at their limits, between
which such steps go to and fro; damped ones bring its fingertips home first."""

SETTLED, SETTLED_DAMPED = 2e-3, 1e-4
"""rad, and shares of 0.1 m: a step as small as that is the last one before and after the halt at
which what has been held back is added to the targets. Newton's next would be its square; damped
steps only shrink by a share."""

STRIDE = 0.3
"""rad, and shares of 0.1 m: longer steps are shortened, since paths bend."""

SHIFT = 0.05
"""What shifting the palm from its own warped place costs, per miss of a fingertip."""

TURN = 2e-2
"""m/rad: what turning the palm costs."""


@njit(cache=True, nogil=True, error_model="numpy")
def solve_hand(
    chain, axes, bounds, target, weight, centre, shift, turn, q, palm_shift, palm_turn, misses
):
    """Where palm and fingers go.

    Args:
        chain: (5, 4, 3) m, tracked: each finger's base, two joints, and the point to be placed.
        axes: (5, 4, 3) unit vectors: flexion and abduction at the base, flexion of the others.
        bounds: (5, 4, 2) rad, least and greatest change of each angle; 0 is within.
        target: (5, 3) m, where the points should be.
        weight: (5,), 0 for a finger that is not tracked.
        centre: (3,) m, tracked, about which the palm turns; shift: (3,) m and turn: (3, 3), where
            the palm would go by itself.
        q: (5, 4), palm_shift: (3,), palm_turn: (3, 3): the start, and written.
        misses: (5,) m, written; NaN where the weight is 0.
    """
    turns, joints = np.empty((7, 3, 3)), np.empty((4, 3))
    moved_axes = np.empty((5, 4, 3))
    F, arm, moment = np.empty((5, 4, 3)), np.empty((5, 3)), np.empty((5, 3))
    reach, stiffness, pull = np.empty((5, 4)), np.empty((5, 4)), np.empty((5, 4))
    miss, held, force = np.empty((5, 3)), np.zeros((5, 3)), np.zeros((5, 3))
    H, halves, bend = np.empty((5, 4, 4)), np.empty((5, 4, 4)), np.zeros((5, 4))
    A, b, springs = np.empty((6, 6)), np.empty(6), np.empty(6)
    springs[:3], springs[3:] = SHIFT * SHIFT, TURN * TURN
    theta, work, increment = np.empty(3), np.empty((3, 3)), np.empty((3, 3))

    settled, halts = False, 0
    for step in range(STEPS):
        if settled and halts > 0:
            break
        halt = halts == 0 and (settled or step == STEPS // 2)
        halts += int(halt)
        for i in range(5):
            if weight[i] <= 0.0:
                continue
            place(
                chain,
                i,
                palm_turn,
                palm_shift,
                centre,
                axes[i],
                q[i],
                turns,
                joints,
                moved_axes[i],
            )
            for d in range(3):
                miss[i, d] = target[i, d] - joints[3, d]
                if halt:
                    held[i, d] = miss[i, d]
                miss[i, d] += held[i, d]
                arm[i, d] = joints[3, d] - centre[d] - palm_shift[d]
            linearise(
                joints,
                moved_axes[i],
                q[i],
                bounds[i],
                F[i],
                reach[i],
                stiffness[i],
                pull[i],
            )
        multiply(palm_turn, turn.T, work)
        rotation_vector(work, theta)
        for attempt in range(2):
            curved = attempt == 0 and step < NEWTON_STEPS
            definite = True
            A[:] = 0.0
            for d in range(3):
                A[d, d], A[3 + d, 3 + d] = springs[d], springs[3 + d]
                b[d] = springs[d] * (shift[d] - palm_shift[d])
                b[3 + d] = -springs[3 + d] * theta[d]
            for i in range(5):
                if weight[i] > 0.0 and definite:
                    definite = eliminate(
                        weight[i],
                        curved,
                        moved_axes[i],
                        force[i],
                        miss[i],
                        arm[i],
                        F[i],
                        reach[i],
                        stiffness[i],
                        pull[i],
                        moment[i],
                        H[i],
                        halves[i],
                        A,
                        b,
                    )
            if definite and factor(A, springs):
                break
        half_solve(A, b)
        other_half(A, b)
        largest = 0.0
        for d in range(3):
            largest = max(largest, 10.0 * abs(b[d]), abs(b[3 + d]))
        for i in range(5):
            if weight[i] > 0.0:
                follow(
                    weight[i],
                    b,
                    miss[i],
                    arm[i],
                    F[i],
                    moment[i],
                    H[i],
                    halves[i],
                    bend[i],
                    force[i],
                )
                for n in range(4):
                    largest = max(largest, abs(bend[i, n]))
        share = STRIDE / largest if largest > STRIDE else 1.0
        for i in range(5):
            for n in range(4):
                q[i, n] += share * bend[i, n]
        for d in range(3):
            palm_shift[d] += share * b[d]
            b[3 + d] *= share
        turn_by(b[3:], increment)
        turn_on(palm_turn, increment, work)
        settled = largest < (SETTLED if curved else SETTLED_DAMPED)

    for i in range(5):
        misses[i] = math.nan
        if weight[i] <= 0.0:
            q[i] = 0.0
            continue
        for n in range(4):
            q[i, n] = min(max(q[i, n], bounds[i, n, 0]), bounds[i, n, 1])
        place(chain, i, palm_turn, palm_shift, centre, axes[i], q[i], turns, joints, moved_axes[i])
        total = 0.0
        for d in range(3):
            total += (target[i, d] - joints[3, d]) ** 2
        misses[i] = math.sqrt(total)


@njit(cache=True, nogil=True, error_model="numpy")
def write_axes(poses, bases, parents, limits, axes, bounds):
    """Axes of the tracked joints, and how far each angle may change.

    Args:
        poses: (25, 4, 4) T_room_joint. bases, parents, limits: as in `skeleton`.
        axes: (5, 4, 3) and bounds: (5, 4, 2), written.
    """
    R = np.empty((3, 3))
    tracked = np.empty(4)
    for i in range(5):
        base, parent = bases[i], parents[i]
        for n in range(3):
            # of the base relative to its parent, of the second joint relative to the base, …
            above = parent if n == 0 else base + n - 1
            for d in range(3):
                for e in range(3):
                    R[d, e] = 0.0
                    for g in range(3):
                        R[d, e] += poses[above, g, d] * poses[base + n, g, e]
            # R = Rx(flexion) Ry(abduction) Rz(twist), so R e_z has no twist in it
            flexion = math.atan2(-R[1, 2], R[2, 2])
            if n == 0:
                tracked[0] = flexion
                tracked[1] = math.asin(min(max(R[0, 2], -1.0), 1.0))
                c, s = math.cos(flexion), math.sin(flexion)
                for d in range(3):
                    axes[i, 0, d] = poses[above, d, 0]
                    axes[i, 1, d] = c * poses[above, d, 1] + s * poses[above, d, 2]
            else:
                tracked[n + 1] = flexion
                for d in range(3):
                    axes[i, n + 1, d] = poses[above, d, 0]
        for n in range(4):
            bounds[i, n, 0] = min(0.0, limits[i, n, 0] - tracked[n])
            bounds[i, n, 1] = max(0.0, limits[i, n, 1] - tracked[n])


@njit(cache=True, nogil=True, error_model="numpy")
def write_poses(poses, bases, present, axes, centre, palm_shift, palm_turn, q, out):
    """Displayed poses of all joints, from those of palm and fingers.

    Args:
        poses: (n, 4, 4); joints that are no finger's go with the palm. out: (n, 4, 4), written.
        present: (5,) bool, whether a finger is moved by its own angles.
    """
    turns, joints, chain = np.empty((7, 3, 3)), np.empty((4, 3)), np.empty((5, 4, 3))
    moved_axes = np.empty((4, 3))
    for j in range(len(poses)):
        _carry(poses[j], palm_turn, centre, palm_shift, out[j])
    for i in range(5):
        if not present[i]:
            continue
        base = bases[i]
        for n in range(4):
            for d in range(3):
                chain[i, n, d] = poses[base + n, d, 3]
        place(chain, i, palm_turn, palm_shift, centre, axes[i], q[i], turns, joints, moved_axes)
        for n in range(4):
            T = turns[min(n, 2)]
            for d in range(3):
                out[base + n, d, 3] = joints[n, d]
                for e in range(3):
                    total = 0.0
                    for g in range(3):
                        total += T[d, g] * poses[base + n, g, e]
                    out[base + n, d, e] = total


@njit(cache=True, nogil=True, error_model="numpy")
def _carry(pose, turn, centre, shift, out):
    for d in range(3):
        for e in range(3):
            out[d, e] = turn[d, 0] * pose[0, e] + turn[d, 1] * pose[1, e] + turn[d, 2] * pose[2, e]
        out[d, 3] = centre[d] + shift[d]
        for e in range(3):
            out[d, 3] += turn[d, e] * (pose[e, 3] - centre[e])
    out[3, 0] = out[3, 1] = out[3, 2] = 0.0
    out[3, 3] = 1.0
