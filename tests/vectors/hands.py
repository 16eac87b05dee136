"""Hands for the vectors: a few frames of a grasp, displayed in every way."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.hand.hands import RADII, about, pose, reach_and_grasp
from tests.hand.test_pad import touches
from tests.vectors.warps import RADIUS
from touchwarp.hand import CarriedWarp, HandOptions, HandRetargeter, calibrate_pad
from touchwarp.warp.file import load_table
from touchwarp.warp.protocol import Warp

Float = NDArray[np.float64]
FRAMES = (100, 118, 135, 160)
TIMES = (0.0, 0.05, 0.1, 0.3)


def ball(points: Float) -> tuple[Float, Float]:
    """Nearest points of the ball that the warps are about, and its normals."""
    normals = points / np.linalg.norm(points, axis=-1, keepdims=True)
    return RADIUS * normals, normals


CASES = {
    "fingertips": HandOptions(onset=0.0),
    "turned_pads": HandOptions(orientation="turned", contact="pad", onset=0.2),
    "skin": HandOptions(contact="skin", surface=ball, weights=(1, 9, 1, 0.3, 4), onset=0.0),
    "rigid": HandOptions(mode="rigid", leader="middle", orientation="turned", onset=0.0),
    "points": HandOptions(mode="points", onset=0.0),
}


def tracked_hands() -> NDArray[np.float32]:
    """(4, 25, 4, 4) as a browser gives them; of the last one the little finger's tip is lost."""
    _, hands = reach_and_grasp()
    chosen = hands[list(FRAMES)].astype(np.float32)
    chosen[-1, 24] = np.nan
    return chosen


PULL = 0.9
"""By how much `Shrinking` draws hands together: farther than fingers bend."""

CARRIED_TIMES = np.array([-0.02, 0.045, 0.09, 0.26, 0.33])
CARRIED_POSES = np.array(
    [pose(about(2, 0.1 * n) @ about(0, 0.05), [0.01 * n, 0, -0.004 * n]) for n in range(5)]
)


class Shrinking:
    """f(x) = (1 − PULL) x."""

    dimension = 3

    def __call__(self, x: Float) -> Float:
        return (1.0 - PULL) * x

    def displacement(self, x: Float) -> Float:
        return -PULL * x


def hand_vectors(folder: Path) -> dict[str, NDArray[Any]]:
    """Poses (4, 25, 4, 4), of which results are kept as their upper rows (4, 25, 3, 4)."""
    warp: Warp = load_table(folder / "levels.warp")
    carried = CarriedWarp(warp, fixed_surroundings=False)
    for time, T in zip(CARRIED_TIMES, CARRIED_POSES, strict=True):
        carried.add_pose(T, time)
    arrays = {
        "hand.poses": tracked_hands(),
        "hand.radii": RADII.astype(np.float32),
        "hand.carried.times": CARRIED_TIMES,
        "hand.carried.poses": CARRIED_POSES,
        "hand.limits.pull": np.array([PULL]),
    }
    cases = [(name, options, warp) for name, options in CASES.items()]
    cases.append(("carried", HandOptions(onset=0.0), carried))
    cases.append(("limits", HandOptions(onset=0.0), Shrinking()))
    for name, options, own in cases:
        retargeter = HandRetargeter(options)
        shown, misses = [], []
        frames = 2 if name == "limits" else len(TIMES)  # the file stays small
        for time, hand in zip(TIMES[:frames], arrays["hand.poses"][:frames], strict=True):
            shown.append(retargeter.update(own, hand, time, arrays["hand.radii"])[:, :3])
            misses.append(retargeter.misses.copy())
        arrays[f"hand.{name}.displayed"] = np.array(shown, np.float32)
        arrays[f"hand.{name}.misses"] = np.array(misses, np.float32)
    taps = touches(12, noise=1e-3).astype(np.float32)
    pad = calibrate_pad(taps, ball)
    told = np.array([*pad.offset, pad.residual], np.float32)
    return arrays | {"pad.touches": taps, "pad.offset_and_residual": told}
