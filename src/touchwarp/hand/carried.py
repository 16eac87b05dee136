"""A prop that is carried about: its warp goes along, x ↦ T f(T⁻¹ x), with no solve."""

from __future__ import annotations

import math
import tomllib

import numpy as np
from numpy.typing import ArrayLike, NDArray

from touchwarp.hand.kinematics import rotation_vector, turn_by
from touchwarp.warp.posed import rigid
from touchwarp.warp.protocol import Warp

Float = NDArray[np.float64]

LONGEST_WAIT = 0.1
"""s: with no pose of the prop so near a frame, the warp is not valid there."""


class CarriedWarp:
    """The warp of a prop whose pose is tracked, aligned in time with the hand.

    Where other props or fixed surfaces are in Ω, u was solved for where they stand: carried farther
    than allowed the warp is not valid, since it would take them along.

    Args:
        warp: f, of the prop where it stood when the scene was solved.
        T_room_scene: (4, 4) where the scene as solved stands in the room.
        fixed_surroundings: whether anything else is in Ω, a table, say; where left out, what the
            warp's own scene says.
        allowed_shift, allowed_turn: m and rad, how far the prop may go from there in that case.

    Raises:
        ValueError: an allowance is negative, or the matrix is not rigid.
    """

    def __init__(
        self,
        warp: Warp,
        T_room_scene: ArrayLike | None = None,
        *,
        fixed_surroundings: bool | None = None,
        allowed_shift: float = 2e-3,
        allowed_turn: float = math.radians(1.0),
    ) -> None:
        if not (allowed_shift >= 0.0 and allowed_turn >= 0.0):
            raise ValueError(
                f"A shift of {allowed_shift} m and a turn of {allowed_turn} rad are allowed; "
                "numbers ≥ 0 are needed."
            )
        self._warp = warp
        self._rest = np.eye(4) if T_room_scene is None else rigid(T_room_scene, "T_room_scene")
        known = fixed_surroundings is not None
        self._fixed = bool(fixed_surroundings) if known else _has_surroundings(warp)
        self._allowed = (allowed_shift, allowed_turn)
        self._times: list[float] = []
        self._poses: list[Float] = []
        self.valid = False

    def add_pose(self, T_room_scene: ArrayLike, time: float) -> None:
        """The prop's pose at a time, in s: where the scene as solved has been carried with it.

        Poses that are not newer than the last one are passed over.

        Raises:
            ValueError: the pose is not rigid.
        """
        pose = rigid(T_room_scene, "T_room_scene")
        if self._times and time <= self._times[-1]:
            return
        # two poses tell all that lies between them; older ones are for hands that come late
        self._times = [*self._times[-7:], time]
        self._poses = [*self._poses[-7:], pose]

    def at_time(self, time: float) -> Warp:
        """The warp at a hand sample's time, between the poses around it; sets `valid`.

        Before the first pose and after the last one the nearest is taken.
        """
        if not self._times:
            self.valid = False
            return self._warp
        later = int(np.searchsorted(self._times, time))
        before, after = max(later - 1, 0), min(later, len(self._times) - 1)
        t0, t1 = self._times[before], self._times[after]
        share = 0.0 if t1 <= t0 else min(max((time - t0) / (t1 - t0), 0.0), 1.0)
        T = between(self._poses[before], self._poses[after], share)
        away = min(abs(time - t0), abs(time - t1))
        self.valid = away <= LONGEST_WAIT and (not self._fixed or self._near(T))
        return self._warp.at(T)

    def _near(self, T: Float) -> bool:
        """Whether the prop is about where it was solved."""
        vector = np.empty(3)
        rotation_vector(T[:3, :3] @ self._rest[:3, :3].T, vector)
        shift, turn = self._allowed
        difference = T - self._rest
        moved = difference[:3, :3] @ _middle(self._warp) + difference[:3, 3]
        return bool(np.linalg.norm(moved) <= shift and np.linalg.norm(vector) <= turn)


def between(T_0: Float, T_1: Float, share: float) -> Float:
    """The rigid pose at a share of the way from one pose to another: (4, 4)."""
    T = np.eye(4)
    vector, turn = np.empty(3), np.empty((3, 3))
    rotation_vector(T_1[:3, :3] @ T_0[:3, :3].T, vector)
    turn_by(share * vector, turn)
    T[:3, :3] = turn @ T_0[:3, :3]
    T[:3, 3] = T_0[:3, 3] + share * (T_1[:3, 3] - T_0[:3, 3])
    return T


def _has_surroundings(warp: Warp) -> bool:
    """Whether the scene that a warp was solved for holds more than one prop."""
    meta = getattr(warp, "meta", None)
    if meta is None:
        return False
    return len(meta.prop_names) > 1 or bool(tomllib.loads(meta.scene_text).get("fixed"))


def _middle(warp: Warp) -> Float:
    """(3,) m: the middle of ∂Ω1's box, near the prop; the origin for a warp without one."""
    box = getattr(warp, "outer_box", None)
    return np.zeros(3) if box is None else np.asarray(box, np.float64).mean(axis=0)
