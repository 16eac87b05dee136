"""A made-up hand, posed by angles, and motions of it like those that trackers record."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Float = NDArray[np.float64]

# m, right hand, palm down, fingers along −z, in the wrist's frame: knuckles and bones after them
KNUCKLES = np.array(
    [[-0.025, 0.0, -0.095], [-0.004, 0.002, -0.1], [0.016, 0.0, -0.093], [0.034, -0.004, -0.083]]
)
BONES = np.array(
    [[0.042, 0.025, 0.022], [0.047, 0.029, 0.023], [0.043, 0.027, 0.023], [0.034, 0.02, 0.02]]
)
THUMB_BASE = np.array([-0.022, -0.012, -0.03])
THUMB_BONES = np.array([0.044, 0.034, 0.026])
RADII = np.r_[0.02, np.full(24, 0.01)]
RADII[[4, 9, 14, 19, 24]] = 0.008


def about(axis: int, angle: float) -> Float:
    """(3, 3) rotation about a coordinate axis."""
    c, s = np.cos(angle), np.sin(angle)
    R = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R[i, i], R[i, j], R[j, i], R[j, j] = c, -s, s, c
    return R


def pose(rotation: ArrayLike, position: ArrayLike) -> Float:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotation, position
    return T


def make_hand(
    bend: ArrayLike = 0.3, spread: ArrayLike = 0.0, T_room_wrist: Float | None = None
) -> Float:
    """(25, 4, 4) T_room_joint of a right hand.

    Args:
        bend: rad, flexion of all joints, or (5,) of each finger's, or (5, 3) of each joint.
        spread: rad, abduction at the base, one or (5,).
    """
    bends = -np.broadcast_to(np.asarray(bend, float).reshape(-1, *np.shape(bend)[1:]).T, (3, 5)).T
    spreads = np.broadcast_to(np.asarray(spread, float), (5,))
    joints = [np.eye(4)]
    R = about(0, -0.3) @ about(2, -0.9) @ about(1, spreads[0])
    R = R @ about(0, bends[0, 0])
    at = pose(R, THUMB_BASE)
    joints.append(at)
    for n, length in enumerate(THUMB_BONES):
        turn = about(0, bends[0, n + 1]) if n < 2 else np.eye(3)
        at = at @ pose(turn, [0, 0, -length])
        joints.append(at)
    for finger in range(4):
        knuckle = KNUCKLES[finger]
        joints.append(pose(np.eye(3), [0.4 * knuckle[0], 0.0, -0.03]))
        at = pose(about(0, bends[finger + 1, 0]) @ about(1, spreads[finger + 1]), knuckle)
        joints.append(at)
        for n, length in enumerate(BONES[finger]):
            turn = about(0, bends[finger + 1, n + 1]) if n < 2 else np.eye(3)
            at = at @ pose(turn, [0, 0, -length])
            joints.append(at)
    hand = np.array(joints)
    return hand if T_room_wrist is None else T_room_wrist @ hand


def facing(
    hand: Float, target: ArrayLike, direction: ArrayLike, away: float, roll: float = 0.0
) -> Float:
    """(4, 4) T_room_wrist of a hand the middle of whose fingertips is `away` m from a point.

    Args:
        hand: (25, 4, 4) in the wrist's frame.
        target: (3,) m; direction: (3,) which way the fingers point.
    """
    z = -np.asarray(direction, float) / np.linalg.norm(direction)
    x = np.cross([0.1, 1.0, 0.2], z)
    x /= np.linalg.norm(x)
    R = np.column_stack([x, np.cross(z, x), z]) @ about(2, roll)
    tips = hand[[4, 9, 14, 19, 24], :3, 3].mean(axis=0)
    return pose(R, np.asarray(target, float) + away * z - R @ tips)


def reach_and_grasp(seconds: float = 3.0, rate: float = 90.0, seed: int = 0) -> tuple[Float, Float]:
    """Times (n,) s and hands (n, 25, 4, 4): to a ball of 5 cm at the origin, around it, and back.

    Tracking noise of 0.3 mm and 3 mrad, correlated over 50 ms, is on it, as on recordings.
    """
    random = np.random.default_rng(seed)
    times = np.arange(0.0, seconds, 1.0 / rate)
    phase = 0.5 - 0.5 * np.cos(2 * np.pi * times / seconds)
    keep = np.exp(-1.0 / (0.05 * rate))
    noise = np.zeros(6)
    hands = []
    for time, near in zip(times, phase, strict=True):
        drive = np.sqrt(1 - keep**2) * random.normal(size=6) * np.repeat([3e-4, 3e-3], 3)
        noise = keep * noise + drive
        direction = [np.sin(0.7 * time), -0.3, -1.0 + 0.2 * time]
        bend = 0.15 + 0.45 * near + 0.1 * np.sin(3 * time + np.arange(5))
        hand = make_hand(bend, 0.1 * np.sin(time + np.arange(5)))
        wrist = facing(hand, [0.0, 0.0, 0.0], direction, 0.23 - 0.21 * near, 0.5 * np.sin(time))
        jitter = pose(about(0, noise[3]) @ about(1, noise[4]) @ about(2, noise[5]), noise[:3])
        hands.append(wrist @ jitter @ hand)
    return times, np.array(hands)
