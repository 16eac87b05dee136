"""The displayed hand: rigid bones, fingertips in place, limits, no pops."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

import touchwarp.hand.retarget as retarget
from tests.exact.sample_bricks import near_sphere, sample_bricks
from tests.exact.spheres import SphereWarp
from tests.hand.hands import RADII, about, make_hand, pose, reach_and_grasp
from touchwarp.hand import FINGERS, JOINTS, HandOptions, HandRetargeter
from touchwarp.hand.skeleton import BASES, LIMITS, PARENTS, TIPS
from touchwarp.warp.meta import WarpMeta
from touchwarp.warp.table import TableWarp

Float = NDArray[np.float64]

STRETCH = about(2, 0.3) @ np.diag([1.2, 1.0, 0.9]) - np.eye(3)
WARP = SphereWarp(outer_radius=0.3, shift=np.array([0.02, 0.01, 0.0]), stretch=STRETCH)
"""A ball shown turned by 17°, 20 % longer along one axis and 22 mm away: |u| to 30 mm."""

TIMES, HANDS = reach_and_grasp()
FRAMES = len(TIMES)

BONES = [(0, j) for j in (1, 5, 6, 10, 11, 15, 16, 20, 21)]
BONES += [(base + n, base + n + 1) for base in BASES for n in range(3)]


@dataclass
class Shown:
    """Displayed poses (frames, 25, 4, 4), misses (frames, 5) m, angles (frames, 5, 4)."""

    poses: Float
    misses: Float
    angles: Float


def show(warp=WARP, hands=HANDS, times=TIMES, **options) -> Shown:
    retargeter = HandRetargeter(HandOptions(**({"onset": 0.0} | options)))
    parts: tuple[list[Float], ...] = ([], [], [])
    for time, hand in zip(times, hands, strict=True):
        parts[0].append(retargeter.update(warp, hand, time, RADII))
        parts[1].append(retargeter.misses.copy())
        parts[2].append(retargeter.angles.copy())
    return Shown(*(np.array(part) for part in parts))


@pytest.fixture(scope="module")
def grasp() -> Shown:
    return show()


def tips_of(poses: Float) -> Float:
    """(frames, 5, 3) m."""
    return poses[:, TIPS][:, :, :3, 3]


def bone_changes_mm(shown: Float) -> float:
    def lengths(poses: Float) -> Float:
        at = poses[:, :, :3, 3]
        return np.array([np.linalg.norm(at[:, a] - at[:, b], axis=-1) for a, b in BONES])

    return float(1e3 * np.abs(lengths(shown) - lengths(HANDS[: len(shown)])).max())


def motion_factor(shown: Float, hands: Float = HANDS) -> float:
    """The greatest step of a displayed joint, per greatest step of a real one in that frame."""

    def steps(poses: Float) -> Float:
        return np.linalg.norm(np.diff(poses[:, :, :3, 3], axis=0), axis=-1).max(axis=1)

    return float((steps(shown) / steps(hands)).max())


def angles_of(poses: Float) -> Float:
    """(frames, 5, 4) rad: flexion and abduction at the base, flexion of two joints; by direction.

    A bone's direction in its parent's frame, without reference to how it was turned there.
    """
    out = np.empty((len(poses), 5, 4))
    for i in range(5):
        parents = [PARENTS[i], BASES[i], BASES[i] + 1]
        for n, parent in enumerate(parents):
            child = BASES[i] + n
            z = np.einsum("fji,fj->fi", poses[:, parent, :3, :3], poses[:, child, :3, 2])
            out[:, i, n if n == 0 else n + 1] = np.arctan2(-z[:, 1], z[:, 2])
            if n == 0:
                out[:, i, 1] = np.arcsin(z[:, 0])
    return out


def test_the_names_are_those_of_the_places() -> None:
    assert len(JOINTS) == len(set(JOINTS)) == 25
    assert [JOINTS[t] for t in TIPS] == [
        "thumb-tip",
        *(f"{finger}-finger-tip" for finger in ("index", "middle", "ring", "pinky")),
    ]


@pytest.mark.parametrize("options", [{}, {"contact": "pad"}, {"mode": "rigid"}])
def test_nothing_moves_without_displacement(options) -> None:
    still = SphereWarp(shift=np.zeros(3))
    assert np.abs(show(still, **options).poses - HANDS).max() < 1e-12
    assert np.abs(show(None, **options).poses - HANDS).max() < 1e-12


def test_fingertips_come_where_they_should(grasp: Shown) -> None:
    shown, real = tips_of(grasp.poses), tips_of(HANDS)
    away = np.linalg.norm(shown - WARP(real), axis=-1)
    assert away.max() < 0.1e-3
    np.testing.assert_allclose(grasp.misses, away, atol=1e-12)
    # the claim is about displacements of centimetres
    assert np.linalg.norm(WARP.displacement(real), axis=-1).max() > 25e-3


def test_that_claim_rejects_a_hand_that_follows_one_finger() -> None:
    shown = tips_of(show(mode="rigid").poses)
    assert np.linalg.norm(shown - WARP(tips_of(HANDS)), axis=-1).max() > 5e-3


@pytest.mark.parametrize("mode", ["fingertips", "rigid"])
@pytest.mark.parametrize("orientation", ["as_tracked", "turned"])
def test_bones_keep_their_lengths(mode: str, orientation: str) -> None:
    assert bone_changes_mm(show(mode=mode, orientation=orientation).poses) < 1e-6


def test_the_claim_about_bones_rejects_joints_warped_one_by_one() -> None:
    assert bone_changes_mm(show(mode="points").poses) > 3.0


def test_the_palm_is_rigid_and_matrices_are_rotations(grasp: Shown) -> None:
    palm = [0, 5, 6, 10, 11, 15, 16, 20, 21]

    def distances(poses: Float) -> Float:
        at = poses[:, :, :3, 3][:, palm]
        return np.linalg.norm(at[:, :, None] - at[:, None], axis=-1)

    assert np.abs(distances(grasp.poses) - distances(HANDS)).max() < 1e-9
    R = grasp.poses[:, :, :3, :3]
    assert np.abs(R @ np.swapaxes(R, -1, -2) - np.eye(3)).max() < 1e-9


def test_angles_are_what_changed_between_frames_of_joints(grasp: Shown) -> None:
    tracked, shown = angles_of(HANDS), angles_of(grasp.poses)
    # the thumb's base turns about its own tracked axes
    np.testing.assert_allclose((shown - tracked)[:, 1:], grasp.angles[:, 1:], atol=1e-9)
    np.testing.assert_allclose((shown - tracked)[:, 0, 2:], grasp.angles[:, 0, 2:], atol=1e-9)
    assert np.abs(grasp.angles).max() > np.radians(5)


def over_limits(shown: Shown, hands: Float) -> float:
    """rad, by how much a displayed angle is beyond its limit and beyond the tracked angle."""
    tracked, angles = angles_of(hands), angles_of(shown.poses)
    tracked[:, 0, :2] = 0.0
    angles[:, 0, :2] = shown.angles[:, 0, :2]
    low = np.minimum(LIMITS[..., 0], tracked)
    high = np.maximum(LIMITS[..., 1], tracked)
    return float(np.maximum(low - angles, angles - high).max())


BENT = np.array(
    [make_hand(bend, T_room_wrist=HANDS[120, 0]) for bend in np.linspace(-0.1, 1.9, 60)]
)
SHRINKING = SphereWarp(radius=0.06, outer_radius=0.5, stretch=-0.9 * np.eye(3))


def test_joints_stay_within_their_limits() -> None:
    assert over_limits(show(SHRINKING, BENT, TIMES[:60]), BENT) < 1e-9


def test_that_claim_rejects_joints_without_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(retarget, "LIMITS", LIMITS * 10)
    assert over_limits(show(SHRINKING, BENT, TIMES[:60]), BENT) > np.radians(5)


LARGEST_FACTOR = 2.0
"""As docs/hands.md states it for this grasp."""


def ball(points: Float) -> tuple[Float, Float]:
    normals = points / np.linalg.norm(points, axis=-1, keepdims=True)
    return 0.05 * normals, normals


@pytest.mark.parametrize("orientation", ["as_tracked", "turned"])
@pytest.mark.parametrize("contact", ["centre", "pad", "skin"])
def test_there_are_no_pops(orientation: str, contact: str) -> None:
    options = {"orientation": orientation, "contact": contact, "surface": ball, "onset": 0.5}
    assert motion_factor(show(**options).poses) < LARGEST_FACTOR


def test_there_are_no_pops_where_the_gradient_of_a_table_jumps() -> None:
    box = np.array([[-0.3] * 3, [0.3] * 3])
    grid = {"root_shape": (4, 4, 4), "depth": 2, "refine": near_sphere(0.0, 0.05)}
    table = TableWarp(sample_bricks(WARP.displacement, *box, **grid), WarpMeta(outer_box=box))
    shown = show(table, orientation="turned", contact="skin", surface=ball)
    assert motion_factor(shown.poses) < LARGEST_FACTOR


def test_that_claim_rejects_a_warp_that_comes_at_once() -> None:
    times, hands = TIMES[100:], HANDS[100:]
    retargeter = HandRetargeter(HandOptions(onset=0.0))
    shown = [
        retargeter.update(WARP if time > 1.5 else None, hand, time)
        for time, hand in zip(times, hands, strict=True)
    ]
    assert motion_factor(np.array(shown), hands) > 3 * LARGEST_FACTOR


def test_equal_frames_are_displayed_equally_whatever_was_before() -> None:
    there, back = show(), show(hands=HANDS[::-1])
    np.testing.assert_array_equal(there.poses, back.poses[::-1])


def test_a_shift_is_followed_by_the_hand_as_it_is() -> None:
    shift = np.array([0.03, -0.02, 0.05])
    everywhere = SphereWarp(radius=5.0, outer_radius=1e6, shift=shift)
    shown = show(everywhere, HANDS[:5], TIMES[:5])
    np.testing.assert_allclose(
        shown.poses[:, :, :3, 3] - HANDS[:5, :, :3, 3],
        np.broadcast_to(shift, (5, 25, 3)),
        atol=1e-6,
    )
    assert np.abs(shown.angles).max() < 1e-6


@pytest.mark.parametrize("mode", ["fingertips", "rigid"])
def test_a_turn_is_followed_by_the_hand_as_it_is(mode: str) -> None:
    R = about(0, 0.2) @ about(1, -0.3)
    turning = SphereWarp(radius=5.0, outer_radius=1e6, stretch=R - np.eye(3))
    shown = show(turning, HANDS[:5], TIMES[:5], mode=mode, orientation="turned")
    np.testing.assert_allclose(shown.poses, pose(R, np.zeros(3)) @ HANDS[:5], atol=2e-6)


class Pulling:
    """f pulls two fingertips apart, farther than a hand can."""

    dimension = 3

    def __init__(self, hand: Float) -> None:
        self.tips = hand[TIPS[1:3], :3, 3]

    def __call__(self, x: Float) -> Float:
        return x + self.displacement(x)

    def displacement(self, x: Float) -> Float:
        u = np.zeros_like(x)
        for tip, way in zip(self.tips, (-0.04, 0.04), strict=True):
            u[np.linalg.norm(x - tip, axis=-1) < 1e-6, 0] = way
        return u


def test_what_cannot_be_met_is_shared_by_weights() -> None:
    hand = make_hand()
    misses = {}
    for weights in ((1, 1, 1, 1, 1), (1, 8, 1, 1, 1), (1, 1, 8, 1, 1)):
        shown = show(Pulling(hand), hand[None], [0.0], weights=weights)
        misses[weights] = shown.misses[0]
        tips = shown.poses[0, TIPS[1:3], :3, 3]
        goals = Pulling(hand)(hand[TIPS[1:3], :3, 3])
        np.testing.assert_allclose(
            misses[weights][1:3], np.linalg.norm(tips - goals, axis=-1), atol=1e-12
        )
    alike = misses[(1, 1, 1, 1, 1)]
    assert alike[1:3].min() > 0.5e-3
    assert misses[(1, 8, 1, 1, 1)][1] < 0.6 * alike[1]
    assert misses[(1, 1, 8, 1, 1)][2] < 0.6 * alike[2]


@pytest.mark.parametrize("leader", FINGERS)
def test_the_leading_finger_is_exact(leader: str) -> None:
    shown = show(mode="rigid", leader=leader, orientation="turned")
    n = FINGERS.index(leader)
    np.testing.assert_allclose(
        shown.poses[:, TIPS[n], :3, 3], WARP(HANDS[:, TIPS[n], :3, 3]), atol=1e-12
    )
    moved = np.linalg.inv(HANDS[:, :1]) @ HANDS
    np.testing.assert_allclose(np.linalg.inv(shown.poses[:, :1]) @ shown.poses, moved, atol=1e-9)


def test_points_are_the_warp_of_joints() -> None:
    shown = show(mode="points")
    np.testing.assert_allclose(shown.poses[:, :, :3, 3], WARP(HANDS[:, :, :3, 3]), atol=1e-12)
    assert np.isnan(shown.misses).all()


def test_a_palm_goes_along() -> None:
    hand = HANDS[130]
    palm = pose(hand[0, :3, :3], 0.5 * (hand[0, :3, 3] + hand[11, :3, 3]))
    retargeter = HandRetargeter(HandOptions(onset=0.0))
    shown = retargeter.update(WARP, np.concatenate([palm[None], hand]), 0.0)
    alone = HandRetargeter(HandOptions(onset=0.0)).update(WARP, hand, 0.0)
    np.testing.assert_array_equal(shown[1:], alone)
    np.testing.assert_allclose(
        np.linalg.inv(shown[1]) @ shown[0], np.linalg.inv(hand[0]) @ palm, atol=1e-9
    )


def test_a_lost_finger_is_lost_and_the_others_are_not() -> None:
    hand = HANDS[130].copy()
    hand[8] = np.nan
    retargeter = HandRetargeter(HandOptions(onset=0.0))
    shown = retargeter.update(WARP, hand, 0.0)
    lost = np.isnan(shown).any(axis=(1, 2))
    assert np.flatnonzero(lost).tolist() == [6, 7, 8, 9]
    assert np.isnan(retargeter.misses).tolist() == [False, True, False, False, False]
    assert np.nanmax(retargeter.misses) < 0.1e-3


@pytest.mark.parametrize(("mode", "joint"), [("fingertips", 0), ("fingertips", 16), ("rigid", 9)])
def test_a_lost_hand_is_nan_and_raises_nothing(mode: str, joint: int) -> None:
    hand = HANDS[130].copy()
    hand[joint] = np.nan
    retargeter = HandRetargeter(HandOptions(mode=mode, onset=0.0))
    assert np.isnan(retargeter.update(WARP, hand, 0.0)).all()
    assert np.isnan(retargeter.misses).all()


def test_room_for_the_result_is_used() -> None:
    out = np.empty((25, 4, 4))
    assert HandRetargeter().update(WARP, HANDS[0], 0.0, out=out) is out


def test_other_joints_are_refused() -> None:
    with pytest.raises(ValueError, match=r"\(21, 4, 4\); \(25, 4, 4\) or \(26, 4, 4\) is needed"):
        HandRetargeter().update(WARP, np.zeros((21, 4, 4)), 0.0)
