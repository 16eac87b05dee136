"""A tracked hand in, the displayed hand out, frame by frame."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from touchwarp.hand.carried import CarriedWarp
from touchwarp.hand.contact import (
    STENCIL,
    place_skin,
    slope_of,
    touch_directions,
    turn_of,
    write_stencil,
)
from touchwarp.hand.kinematics import rotation_vector, turn_by
from touchwarp.hand.onset import Onset
from touchwarp.hand.options import HandOptions
from touchwarp.hand.skeleton import BASES, FINGERS, LIMITS, PARENTS, TIPS
from touchwarp.hand.solver import solve_hand, write_axes, write_poses
from touchwarp.warp.protocol import Warp

Float = NDArray[np.float64]

PALM_STENCIL = 2e-2
"""m: half the width over which ∂f is averaged for the palm's turn."""

# rows of the points that are looked up at each frame
_CENTRES, _TOUCH, _PALM = slice(0, 5), slice(5, 10), 10
_TURN, _SKIN = slice(11, 17), slice(17, 47)


class HandRetargeter:
    """Displays one hand: bones keep their lengths, fingertips touch where they should.

    What the state of one frame leaves to the next is the onset's weight alone, see
    `touchwarp.hand.onset`; the rest depends on this frame only.

    Args:
        options: how.

    Attributes:
        active: ease the displacement out while False.
        misses: (5,) m, how far each displayed fingertip (its centre or pad) is from where it
            should be; NaN for a finger that is not tracked, and in "points".
        angles: (5, 4) rad, by how much each joint angle differs from the tracked one.
    """

    def __init__(self, options: HandOptions | None = None) -> None:
        self.options = options or HandOptions()
        self.active = True
        self.misses = np.full(5, np.nan)
        self.angles = np.zeros((5, 4))
        self._onset = Onset(self.options.onset)
        self._source: Warp | CarriedWarp | None = None
        self._warp: Warp | None = None
        self._axes, self._bounds = np.zeros((5, 4, 3)), np.zeros((5, 4, 2))
        self._chain, self._goal = np.zeros((5, 4, 3)), np.zeros((5, 3))
        self._points, self._shown = np.zeros((47, 3)), np.zeros((47, 3))
        self._outward, self._share = np.zeros((5, 3)), np.zeros(5)
        self._slope, self._turn = np.zeros((3, 3)), np.eye(3)
        self._palm_turn, self._palm_shift = np.eye(3), np.zeros(3)
        self._weight, self._radii = np.zeros(5), np.zeros(5)

    @property
    def weight(self) -> float:
        """The share of the displacement that is shown, 0 to 1."""
        return self._onset.weight

    @property
    def may_claim_contact(self) -> bool:
        """Whether all of the displacement is shown, so that to touch the prop is to touch."""
        return self._onset.weight == 1.0

    def replace(self, warp: Warp | CarriedWarp) -> None:
        """Take another warp for the one in use, at once and without easing.

        For one that displays the same and is only known better, as the solved warp after an
        instant one: the hand moves by no more than what they differ.
        """
        if self._source is not None:
            self._source = warp

    def update(
        self,
        warp: Warp | CarriedWarp | None,
        poses: ArrayLike,
        time: float,
        radii: ArrayLike | None = None,
        *,
        out: Float | None = None,
    ) -> Float:
        """One frame.

        Args:
            warp: f; None, or another than last time, eases the old one out first. One that goes
                with a prop is given as the `CarriedWarp`, which stays the same one.
            poses: (25, 4, 4) T_room_joint in WebXR's order, or (26, 4, 4) with OpenXR's palm
                before them; NaN where a joint is not tracked.
            time: s, of the frame.
            radii: (25,) or (26,) m, of the joints; NaN where unknown.
            out: written and returned where given.

        Returns:
            The displayed poses, of the same shape; all NaN where the wrist or a knuckle (in
            "rigid", the leading fingertip) is lost, and for the joints of a finger of which one is.

        Raises:
            ValueError: an array has a wrong shape.
        """
        tracked = np.asarray(poses, dtype=np.float64)
        if tracked.shape not in ((25, 4, 4), (26, 4, 4)):
            raise ValueError(
                f"The poses have shape {tracked.shape}; (25, 4, 4) or (26, 4, 4) is needed."
            )
        shown = np.empty_like(tracked) if out is None else out
        first = len(tracked) - 25
        hand = tracked[first:]
        known: NDArray[np.bool_] = np.asarray(np.isfinite(hand[:, :3]).all(axis=(1, 2)))
        present = known[BASES] & known[BASES + 1] & known[BASES + 2] & known[TIPS] & known[PARENTS]
        lost = not (known[0] and known[BASES[1:]].all())
        if self.options.mode == "rigid":
            lost = lost or not present[FINGERS.index(self.options.leader)]
        weight = self._ease(warp, time, lost)
        if lost:
            shown[:] = np.nan
            self.misses[:] = np.nan
            return shown
        self._read(hand, present, radii, first)
        self._look_up(hand, present, weight)
        mode = self.options.mode
        if mode == "points":
            self._move_points(tracked, weight, shown)
        elif mode == "rigid":
            self._move_rigidly(tracked, present, shown)
        else:
            self._move_fingers(tracked, present, first, shown)
        unknown = ~known
        for n in range(5):
            if not present[n]:
                unknown[BASES[n] : TIPS[n] + 1] = True
        shown[first:][unknown] = np.nan
        return shown

    def _ease(self, warp: Warp | CarriedWarp | None, time: float, lost: bool) -> float:
        if self._onset.weight == 0.0 or self._onset.duration == 0.0:
            self._source = warp
        wanted = self.active and warp is not None and warp is self._source and not lost
        if isinstance(self._source, CarriedWarp):
            self._warp = self._source.at_time(time)
            wanted = wanted and self._source.valid
        else:
            self._warp = self._source
        weight = self._onset.advance(time, wanted)
        return weight if self._warp is not None else 0.0

    def _read(
        self, hand: Float, present: NDArray[np.bool_], radii: ArrayLike | None, first: int
    ) -> None:
        """Axes, chains and radii of the tracked hand."""
        self._radii[:] = np.nan if radii is None else np.asarray(radii, np.float64)[first:][TIPS]
        self._radii[~(self._radii > 0.0)] = self.options.tip_radius
        write_axes(hand, BASES, PARENTS, LIMITS, self._axes, self._bounds)
        for n in range(4):
            self._chain[:, n] = hand[BASES + n, :3, 3]
        if self.options.contact == "pad":
            rotations = hand[TIPS, :3, :3]
            if self.options.pad_offsets is None:
                self._chain[:, 3] -= rotations[:, :, 1] * self._radii[:, None]
            else:
                self._chain[:, 3] += np.einsum(
                    "nij,nj->ni", rotations, np.asarray(self.options.pad_offsets)
                )
        self._weight[:] = np.where(present, self.options.weights, 0.0)

    def _look_up(self, hand: Float, present: NDArray[np.bool_], weight: float) -> None:
        """Goals of the fingertips, and the palm's own shift and turn, all by their share."""
        options, points, shown = self.options, self._points, self._shown
        skin, turned = options.contact == "skin", options.orientation == "turned"
        points[_CENTRES] = self._chain[:, 3]
        points[_PALM] = self._centre(hand)
        rigid = options.mode == "rigid"
        pivot = points[FINGERS.index(options.leader)] if rigid else points[_PALM]
        if turned:
            write_stencil(pivot, PALM_STENCIL, points[_TURN])
        if skin:
            assert options.surface is not None
            nearest, normals = options.surface(points[_CENTRES])
            tip = (points[_CENTRES], nearest, normals, self._radii)
            touch_directions(*tip, self._outward, points[_TOUCH], self._share)
            for n in range(5):
                write_stencil(points[5 + n], STENCIL, points[_SKIN][6 * n : 6 * n + 6])
        count = 47 if skin else 17
        if self._warp is None or weight == 0.0:
            self._goal[:] = points[_CENTRES]
            shown[_PALM] = points[_PALM]
            self._turn[:] = np.eye(3)
        else:
            shown[:count] = self._warp(points[:count])
            self._goal[:] = shown[_CENTRES]
            if skin:
                for n in range(5):
                    slope_of(shown[_SKIN][6 * n : 6 * n + 6], STENCIL, self._slope)
                    place_skin(
                        *(shown[n], shown[5 + n], self._slope, self._outward[n]),
                        *(self._radii[n], self._share[n], self._goal[n]),
                    )
            self._goal[:] = points[_CENTRES] + weight * (self._goal - points[_CENTRES])
            self._turn[:] = np.eye(3)
            if turned:
                slope_of(shown[_TURN], PALM_STENCIL, self._slope)
                turn_of(self._slope, self._turn)
                vector = np.empty(3)
                rotation_vector(self._turn, vector)
                turn_by(weight * vector, self._turn)
        self._palm_shift[:] = weight * (shown[_PALM] - points[_PALM])
        self._weight[~(present & np.isfinite(self._goal).all(axis=1))] = 0.0

    def _centre(self, hand: Float) -> Float:
        """(3,) m: the middle of the four knuckles, about which the palm turns."""
        centre: Float = hand[BASES[1:], :3, 3].mean(axis=0)
        return centre

    def _move_points(self, tracked: Float, weight: float, shown: Float) -> None:
        shown[:] = tracked
        shown[:, :3, :3] = self._turn @ tracked[:, :3, :3]
        if self._warp is not None and weight > 0.0:
            shown[:, :3, 3] += weight * self._warp.displacement(tracked[:, :3, 3])
        self.misses[:] = np.nan
        self.angles[:] = 0.0

    def _move_rigidly(self, tracked: Float, present: NDArray[np.bool_], shown: Float) -> None:
        leader = FINGERS.index(self.options.leader)
        centre = self._points[leader].copy()
        self._palm_turn[:] = self._turn
        self._palm_shift[:] = self._goal[leader] - centre
        self.angles[:] = 0.0
        nobody = np.zeros(5, np.bool_)
        body = (centre, self._palm_shift, self._palm_turn, self.angles)
        write_poses(tracked, BASES, nobody, self._axes, *body, shown)
        moved = centre + self._palm_shift + (self._points[_CENTRES] - centre) @ self._palm_turn.T
        misses = np.linalg.norm(self._goal - moved, axis=1)
        self.misses[:] = np.where(present, misses, np.nan)

    def _move_fingers(
        self, tracked: Float, present: NDArray[np.bool_], first: int, shown: Float
    ) -> None:
        centre = self._points[_PALM]
        shift = self._palm_shift.copy()
        if not math.isfinite(float(shift.sum())):
            shift[:] = 0.0
        self.angles[:] = 0.0
        self._palm_shift[:] = shift
        self._palm_turn[:] = self._turn
        start = (self.angles, self._palm_shift, self._palm_turn, self.misses)
        problem = (self._chain, self._axes, self._bounds, self._goal, self._weight)
        solve_hand(*problem, centre, shift, self._turn, *start)
        body = (centre, self._palm_shift, self._palm_turn, self.angles)
        write_poses(tracked, BASES + first, present, self._axes, *body, shown)
