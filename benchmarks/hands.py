"""How fingertips are brought to their places: least squares from the tracked hand against peers.

    python benchmarks/hands.py

A made-up grasp of a ball with tracking noise, displayed by four methods, under a moderate and a
strong warp: how far fingertips miss; how much farther a displayed joint moves in a frame than any
real one; by how much the same frame is displayed otherwise when the grasp is played backwards; how
far joints go beyond their limits, or hinges out of their plane. Time is the process's own, for one
hand; the peers are plain NumPy, so theirs is no measure of the method.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from time import process_time

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tests.exact.spheres import SphereWarp
from tests.hand.hands import RADII, about, reach_and_grasp
from touchwarp.hand import HandOptions, HandRetargeter
from touchwarp.hand.kinematics import place, turn_by
from touchwarp.hand.skeleton import BASES, LIMITS, PARENTS
from touchwarp.hand.solver import write_axes

Float = NDArray[np.float64]
Result = tuple[Float, Float]
"""Displayed joints of the fingers (5, 4, 3) m, and by how many rad angles pass their limits."""

WARPS = {
    "27 mm": SphereWarp(
        outer_radius=0.3,
        shift=np.array([0.02, 0.01, 0.0]),
        stretch=about(2, 0.3) @ np.diag([1.2, 1.0, 0.9]) - np.eye(3),
    ),
    "60 mm": SphereWarp(
        outer_radius=0.25,
        shift=np.array([0.04, 0.0, 0.0]),
        stretch=about(1, 0.9) @ np.diag([1.5, 1.2, 0.7]) - np.eye(3),
    ),
}


def chains_of(hand: Float) -> Float:
    """(5, 4, 3) m."""
    return np.stack([hand[BASES + n, :3, 3] for n in range(4)], axis=1)


class LeastSquares:
    """What touchwarp does."""

    def __init__(self) -> None:
        self.retargeter = HandRetargeter(HandOptions(onset=0.0))

    def __call__(self, warp: SphereWarp, hand: Float) -> Result:
        shown = self.retargeter.update(warp, hand, 0.0, RADII)
        bounds, q = self.retargeter._bounds, self.retargeter.angles
        return chains_of(shown), np.maximum(bounds[..., 0] - q, q - bounds[..., 1]).max(axis=1)


class WarmLeastSquares:
    """Damped least squares from the last frame's angles, with no pull to the tracked hand."""

    def __init__(self, steps: int = 10, damping: float = 0.01) -> None:
        self.steps, self.damping = steps, damping
        self.q, self.shift, self.turn = np.zeros((5, 4)), np.zeros(3), np.eye(3)

    def __call__(self, warp: SphereWarp, hand: Float) -> Result:
        axes, bounds = np.empty((5, 4, 3)), np.empty((5, 4, 2))
        write_axes(hand, BASES, PARENTS, LIMITS, axes, bounds)
        chain, centre = chains_of(hand), hand[BASES[1:], :3, 3].mean(axis=0)
        target = warp(chain[:, 3])
        turns, joints, moved = np.empty((7, 3, 3)), np.empty((5, 4, 3)), np.empty((4, 3))
        for step in range(self.steps + 1):
            J = np.zeros((15, 26))
            for i in range(5):
                body = (self.turn, self.shift, centre)
                place(chain, i, *body, axes[i], self.q[i], turns, joints[i], moved)
                rows = slice(3 * i, 3 * i + 3)
                arm = joints[i, 3] - centre - self.shift
                J[rows, :3] = np.eye(3)
                J[rows, 3:6] = np.cross(np.eye(3), arm).T
                for n in range(4):
                    J[rows, 6 + 4 * i + n] = np.cross(
                        moved[n], joints[i, 3] - joints[i, max(n - 1, 0)]
                    )
            if step == self.steps:
                break
            miss = (target - joints[:, 3]).ravel()
            delta = J.T @ np.linalg.solve(J @ J.T + self.damping**2 * np.eye(15), miss)
            self.shift += delta[:3]
            increment = np.empty((3, 3))
            turn_by(delta[3:6], increment)
            self.turn = increment @ self.turn
            self.q = np.clip(self.q + delta[6:].reshape(5, 4), bounds[..., 0], bounds[..., 1])
        return joints.copy(), np.zeros(5)


class Fabrik:
    """FABRIK with five end effectors on one rigid palm (Aristidou & Lasenby 2011).

    Args:
        warm: start from the last frame's displayed hand, not from the tracked one.
    """

    def __init__(self, warm: bool, rounds: int = 30) -> None:
        self.warm, self.rounds = warm, rounds
        self.last: Float | None = None

    def __call__(self, warp: SphereWarp, hand: Float) -> Result:
        tracked = chains_of(hand)
        lengths = np.linalg.norm(np.diff(tracked, axis=1), axis=-1)
        p = self.last.copy() if self.warm and self.last is not None else tracked.copy()
        target = warp(tracked[:, 3])
        for _ in range(self.rounds):
            p[:, 3] = target
            for n in (2, 1, 0):
                p[:, n] = p[:, n + 1] + lengths[:, n, None] * unit(p[:, n] - p[:, n + 1])
            p[:, 0] = fitted(tracked[:, 0], p[:, 0])
            for n in range(3):
                p[:, n + 1] = p[:, n] + lengths[:, n, None] * unit(p[:, n + 1] - p[:, n])
            if np.linalg.norm(p[:, 3] - target, axis=-1).max() < 1e-5:
                break
        self.last = p
        return p.copy(), self._beyond(hand, tracked, p)

    def _beyond(self, hand: Float, tracked: Float, p: Float) -> Float:
        """The two outer joints are hinges: how far their bones leave the plane they bend in."""
        beyond = np.zeros(5)
        for i in range(5):
            before, after = np.diff(tracked[i], axis=0), np.diff(p[i], axis=0)
            for n in (1, 2):
                axis = hand[BASES[i] + n - 1, :3, 0]
                free = np.arcsin(unit(before[n]) @ axis)
                # carried along with the bone above it
                turn = shortest_turn(unit(before[n - 1]), unit(after[n - 1]))
                beyond[i] = max(beyond[i], abs(np.arcsin(unit(after[n]) @ (turn @ axis)) - free))
        return beyond


def unit(v: Float) -> Float:
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))


def shortest_turn(a: Float, b: Float) -> Float:
    cross = np.cross(a, b)
    K = np.array([[0, -cross[2], cross[1]], [cross[2], 0, -cross[0]], [-cross[1], cross[0], 0]])
    return np.asarray(np.eye(3) + K + K @ K / (1.0 + a @ b))


def fitted(body: Float, to: Float) -> Float:
    """A rigid body's points, moved as near as may be to where they should be (Kabsch)."""
    a, b = body - body.mean(axis=0), to - to.mean(axis=0)
    U, _, V = np.linalg.svd(a.T @ b)
    R = V.T @ np.diag([1.0, 1.0, np.sign(np.linalg.det(V.T @ U.T))]) @ U.T
    return np.asarray(a @ R.T + to.mean(axis=0))


METHODS: dict[str, Callable[[], Callable[[SphereWarp, Float], Result]]] = {
    "least squares, from the tracked hand": LeastSquares,
    "damped least squares, from the last frame": WarmLeastSquares,
    "FABRIK, from the last frame": lambda: Fabrik(True),
    "FABRIK, from the tracked hand": lambda: Fabrik(False),
}


def main() -> None:
    _, hands = reach_and_grasp()
    real = np.array([chains_of(hand) for hand in hands])
    steps = np.linalg.norm(np.diff(real, axis=0), axis=-1).max(axis=(1, 2))
    for title, warp in WARPS.items():
        print(f"displacements to {title}; {len(hands)} frames")
        heads = ("motion", "back, mm", "beyond, °", "time, µs")
        print(f"{'':44s} {'miss, mm: median, most':>22s}" + "".join(f"{h:>11s}" for h in heads))
        for name, make in METHODS.items():
            method = make()
            method(warp, hands[0])
            start = process_time()
            results = [method(warp, hand) for hand in hands]
            took = 1e6 * (process_time() - start) / len(hands)
            shown = np.array([joints for joints, _ in results])
            misses = 1e3 * np.linalg.norm(shown[:, :, 3] - warp(real[:, :, 3]), axis=-1)
            moved = np.linalg.norm(np.diff(shown, axis=0), axis=-1).max(axis=(1, 2))
            beyond = np.degrees(max(0.0, *(b.max() for _, b in results)))
            method = make()
            back = np.array([method(warp, hand)[0] for hand in hands[::-1]])[::-1]
            differ = 1e3 * np.linalg.norm(shown - back, axis=-1).max()
            print(
                f"{name:44s} {np.median(misses):14.3f}{misses.max():8.2f}"
                f"{(moved / steps).max():11.2f}{differ:11.1f}{beyond:11.1f}{took:11.0f}"
            )


if __name__ == "__main__":
    main()
