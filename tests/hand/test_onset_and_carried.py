"""The displacement comes and goes at a bounded rate; warps go along with props."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.exact.spheres import SphereWarp
from tests.hand.hands import about, pose, reach_and_grasp
from tests.hand.test_retarget import WARP
from tests.warp.tables import sphere_table
from touchwarp.hand import CarriedWarp, HandOptions, HandRetargeter, Onset
from touchwarp.hand.carried import between

TIMES, HANDS = reach_and_grasp()
LOST = np.full((25, 4, 4), np.nan)


def test_the_weight_keeps_its_rate_and_its_bounds() -> None:
    onset = Onset(0.5)
    random = np.random.default_rng(0)
    time, before = 0.0, onset.advance(0.0, True)
    for _ in range(500):
        step = random.uniform(0.0, 0.05)
        time += step
        weight = onset.advance(time, bool(random.random() < 0.6))
        assert abs(weight - before) <= step / 0.5 + 1e-12
        assert 0.0 <= weight <= 1.0
        before = weight


def test_time_that_stands_still_or_is_unknown_changes_nothing() -> None:
    onset = Onset(0.5)
    assert [onset.advance(t, True) for t in (np.nan, 1.0, 1.0, 0.5)] == [0.0] * 4
    assert onset.advance(100.0, True) == pytest.approx(0.2)  # a pause counts as 0.1 s


@pytest.mark.parametrize("duration", [-0.1, np.nan, np.inf])
def test_an_onset_without_a_duration_is_refused(duration: float) -> None:
    with pytest.raises(ValueError, match="a finite time ≥ 0 is needed"):
        Onset(duration)


def test_the_share_is_that_of_the_displacement() -> None:
    retargeter = HandRetargeter(HandOptions(onset=0.5, mode="points"))
    retargeter.update(WARP, HANDS[130], 0.0)
    shown = retargeter.update(WARP, HANDS[130], 0.1)
    assert retargeter.weight == pytest.approx(0.2)
    u = WARP.displacement(HANDS[130, :, :3, 3])
    np.testing.assert_allclose(shown[:, :3, 3], HANDS[130, :, :3, 3] + 0.2 * u, atol=1e-12)


def test_contact_may_be_claimed_at_full_weight_only() -> None:
    retargeter = HandRetargeter(HandOptions(onset=0.5))
    claims = []
    for n in range(60):
        retargeter.update(WARP, HANDS[130], n / 90)
        claims.append(retargeter.may_claim_contact)
        assert claims[-1] == (retargeter.weight == 1.0)
    assert claims.index(True) == pytest.approx(45, abs=1)


def test_a_lost_hand_eases_out_and_in_again() -> None:
    retargeter = HandRetargeter(HandOptions(onset=0.1))
    weights = []
    for n, hand in enumerate([HANDS[0]] * 3 + [LOST] * 2 + [HANDS[0]] * 3):
        retargeter.update(WARP, hand, 0.05 * n)
        weights.append(retargeter.weight)
    np.testing.assert_allclose(weights, [0, 0.5, 1, 0.5, 0, 0.5, 1, 1], atol=1e-9)


def test_another_warp_waits_until_the_first_has_gone() -> None:
    other = SphereWarp(shift=np.array([0.0, 0.0, 0.03]))
    retargeter = HandRetargeter(HandOptions(onset=0.1, mode="points"))
    x = HANDS[130, :, :3, 3]
    seen = []
    for n, warp in enumerate([WARP] * 3 + [other] * 5):
        u = retargeter.update(warp, HANDS[130], 0.05 * n)[:, :3, 3] - x
        seen.append((retargeter.weight, u))
    np.testing.assert_allclose([w for w, _ in seen], [0, 0.5, 1, 0.5, 0, 0.5, 1, 1], atol=1e-9)
    np.testing.assert_allclose(seen[3][1], 0.5 * WARP.displacement(x), atol=1e-9)
    np.testing.assert_allclose(seen[5][1], 0.5 * other.displacement(x), atol=1e-9)


def test_a_warp_that_is_known_better_takes_its_place_at_once() -> None:
    better = SphereWarp(outer_radius=0.31, shift=np.array([0.02, 0.01, 0.0001]))
    retargeter = HandRetargeter(HandOptions(onset=0.1, mode="points"))
    retargeter.replace(better)  # none is in use: nothing is replaced
    x = HANDS[130, :, :3, 3]
    for n in range(3):
        retargeter.update(WARP, HANDS[130], 0.05 * n)
    retargeter.replace(better)
    shown = retargeter.update(better, HANDS[130], 0.15)
    assert retargeter.weight == 1.0
    np.testing.assert_allclose(shown[:, :3, 3], better(x), atol=1e-12)


def test_it_can_be_switched_off() -> None:
    retargeter = HandRetargeter(HandOptions(onset=0.1))
    retargeter.update(WARP, HANDS[0], 0.0)
    retargeter.update(WARP, HANDS[0], 0.1)
    retargeter.active = False
    retargeter.update(WARP, HANDS[0], 0.15)
    assert retargeter.weight == pytest.approx(0.5)


POSES = [pose(about(2, 0.3 * n) @ about(0, 0.1 * n), [0.1 * n, 0.0, 0.02 * n]) for n in range(4)]


def test_a_prop_takes_its_warp_along() -> None:
    warp = sphere_table()
    carried = CarriedWarp(warp)
    for n, T in enumerate(POSES):
        carried.add_pose(T, 0.02 * n)
    x = np.random.default_rng(0).uniform(-0.2, 0.4, (50, 3))
    for n, T in enumerate(POSES):
        inverse = np.linalg.inv(T)
        local = x @ inverse[:3, :3].T + inverse[:3, 3]
        expected = warp(local) @ T[:3, :3].T + T[:3, 3]
        np.testing.assert_allclose(carried.at_time(0.02 * n)(x), expected, atol=1e-12)
        assert carried.valid


def test_hand_and_prop_are_aligned_in_time() -> None:
    carried = CarriedWarp(sphere_table())
    carried.add_pose(np.eye(4), 0.0)
    carried.add_pose(pose(about(1, 0.4), [0.1, 0.0, 0.0]), 0.1)
    carried.add_pose(pose(np.eye(3), [9.0, 0.0, 0.0]), 0.05)  # late: passed over
    x = np.array([0.05, 0.02, 0.03])
    middle = sphere_table().at(pose(about(1, 0.1), [0.025, 0.0, 0.0]))
    np.testing.assert_allclose(carried.at_time(0.025)(x), middle(x), atol=1e-12)


def test_between_two_poses_goes_the_straight_way() -> None:
    T = between(POSES[0], POSES[3], 0.0)
    np.testing.assert_allclose(T, POSES[0], atol=1e-12)
    np.testing.assert_allclose(between(POSES[0], POSES[3], 1.0), POSES[3], atol=1e-12)
    turned = between(np.eye(4), pose(about(1, 2.8), np.zeros(3)), 0.5)
    np.testing.assert_allclose(turned[:3, :3], about(1, 1.4), atol=1e-12)


def test_without_a_pose_near_the_frame_it_is_not_valid() -> None:
    carried = CarriedWarp(sphere_table())
    assert carried.at_time(0.0) is not None
    assert not carried.valid
    carried.add_pose(np.eye(4), 1.0)
    for time, valid in ((1.0, True), (1.09, True), (1.2, False), (0.95, True), (0.5, False)):
        carried.at_time(time)
        assert carried.valid == valid


@pytest.mark.parametrize(
    ("moved", "valid"),
    [
        (pose(np.eye(3), [0.0019, 0, 0]), True),
        (pose(np.eye(3), [0.0021, 0, 0]), False),
        (pose(about(2, np.radians(0.9)), [0, 0, 0]), True),
        (pose(about(2, np.radians(1.1)), [0, 0, 0]), False),
    ],
)
def test_beside_fixed_surroundings_it_may_hardly_move(moved: np.ndarray, valid: bool) -> None:
    rest = POSES[2]
    for fixed in (True, False):
        carried = CarriedWarp(sphere_table(), rest, fixed_surroundings=fixed)
        carried.add_pose(rest @ moved, 0.0)
        carried.at_time(0.0)
        assert carried.valid == (valid or not fixed)


ALONE = """[[prop]]
name = "ball"
shape = { kind = "sphere", radius = 0.05 }
"""
TABLE = """[[fixed]]
name = "table"
plane = { point = [0, 0, 0], normal = [0, 0, 1] }
"""


@pytest.mark.parametrize(
    ("scene_text", "names", "valid"),
    [
        ("", (), True),
        (ALONE, ("ball",), True),
        (ALONE + TABLE, ("ball",), False),
        (ALONE, ("ball", "cup"), False),
    ],
)
def test_the_warp_s_own_scene_tells_whether_it_may_be_carried(
    scene_text: str, names: tuple[str, ...], valid: bool
) -> None:
    table = sphere_table()
    table._meta = replace(table.meta, scene_text=scene_text, prop_names=names)
    carried = CarriedWarp(table)
    carried.add_pose(pose(np.eye(3), [0.05, 0, 0]), 0.0)
    carried.at_time(0.0)
    assert carried.valid == valid


def test_a_hand_is_eased_out_where_the_carried_warp_is_not_valid() -> None:
    carried = CarriedWarp(sphere_table())
    carried.add_pose(np.eye(4), 0.0)
    retargeter = HandRetargeter(HandOptions(onset=0.1))
    weights = []
    for time in (0.0, 0.05, 0.1, 0.15, 0.2):
        retargeter.update(carried, HANDS[130], time)
        weights.append(retargeter.weight)
    np.testing.assert_allclose(weights, [0.0, 0.5, 1.0, 0.5, 0.0], atol=1e-9)


def test_allowances_and_poses_are_checked() -> None:
    with pytest.raises(ValueError, match=r"shift of -1 m .* numbers ≥ 0 are needed"):
        CarriedWarp(sphere_table(), allowed_shift=-1)
    with pytest.raises(ValueError, match="T_room_scene is not rigid"):
        CarriedWarp(sphere_table()).add_pose(2 * np.eye(4) - np.diag([0, 0, 0, 1]), 0.0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"mode": "stretch"}, "mode is 'stretch'; one of fingertips, rigid, points is needed"),
        ({"leader": "toe"}, "leader is 'toe'; one of thumb, index"),
        ({"orientation": "up"}, "orientation is 'up'; one of as_tracked, turned"),
        ({"contact": "nail"}, "contact is 'nail'; one of centre, pad, skin"),
        ({"contact": "skin"}, 'give `surface`, or take "pad"'),
        ({"tip_radius": 8.0}, r"tip radius is 8.0 m; 0 to 0\.05 is needed"),
        ({"weights": (1, 1, 1, 1, 0)}, "five numbers > 0 are needed"),
        ({"pad_offsets": ((0, 0, 0),)}, r"shape \(1, 3\); \(5, 3\) is needed"),
        ({"onset": -1.0}, "a finite time ≥ 0 is needed"),
    ],
)
def test_options_are_checked(options: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        HandRetargeter(HandOptions(**options))
