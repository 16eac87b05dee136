"""A fingertip has a size: what of it is warped, and how near its skin then comes."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize

from tests.exact.spheres import SphereWarp
from tests.hand.hands import RADII, about, facing, make_hand, reach_and_grasp
from touchwarp.hand import HandOptions, HandRetargeter
from touchwarp.hand.contact import STENCIL, slope_of, turn_of, write_stencil
from touchwarp.hand.skeleton import TIP_RADIUS, TIPS

Float = NDArray[np.float64]
BALL = 0.05
PLAIN = SphereWarp(
    radius=BALL, outer_radius=0.3, shift=np.array([0.02, 0.0, 0.01]), stretch=0.2 * np.eye(3)
)
"""A ball shown as a ball of 6 cm."""
LONG = SphereWarp(
    radius=BALL, outer_radius=0.3, stretch=about(0, 0.3) @ np.diag([1.3, 1.0, 0.85]) - np.eye(3)
)
"""A ball shown as an ellipsoid, turned."""


def ball(points: Float) -> tuple[Float, Float]:
    normals = points / np.linalg.norm(points, axis=-1, keepdims=True)
    return BALL * normals, normals


def touching_hands(count: int, gap: float = 0.0, seed: int = 0) -> Float:
    """(count, 25, 4, 4): the index finger's skin is `gap` away from the ball."""
    random = np.random.default_rng(seed)
    hands = []
    for _ in range(count):
        outward = random.normal(size=3)
        outward /= np.linalg.norm(outward)
        hand = make_hand(random.uniform(0.1, 0.6))
        wrist = facing(hand, np.zeros(3), -outward, 0.0, random.uniform(-1, 1))
        hand = wrist @ hand
        hand[:, :3, 3] += outward * (BALL + TIP_RADIUS + gap) - hand[9, :3, 3]
        hands.append(hand)
    return np.array(hands)


def skin_gaps(warp: SphereWarp, hands: Float, **options) -> Float:
    """(n,) m between the displayed index finger's skin and the virtual surface.

    The nearest point of the virtual surface f(ball) is searched for over the ball's directions.
    """
    retargeter = HandRetargeter(HandOptions(onset=0.0, **options))
    gaps = []
    for hand in hands:
        centre = retargeter.update(warp, hand, 0.0, RADII)[9, :3, 3]

        def distance(direction: Float, centre: Float = centre) -> float:
            at = BALL * direction / np.linalg.norm(direction)
            return float(np.linalg.norm(warp(at) - centre))

        start = hand[9, :3, 3] / np.linalg.norm(hand[9, :3, 3])
        found = minimize(
            distance, start, method="Nelder-Mead", options={"xatol": 1e-8, "fatol": 1e-10}
        )
        gaps.append(found.fun - TIP_RADIUS)
    return np.array(gaps)


HANDS = touching_hands(12)


@pytest.mark.parametrize("warp", [PLAIN, LONG], ids=["ball", "ellipsoid"])
@pytest.mark.parametrize(("mode", "most"), [("rigid", 0.01e-3), ("fingertips", 0.5e-3)])
def test_skin_touches_the_virtual_surface_when_it_touches_the_prop(
    warp: SphereWarp, mode: str, most: float
) -> None:
    # in "fingertips" other fingers, some of them inside the ball, ask for their places too
    assert np.abs(skin_gaps(warp, HANDS, mode=mode, contact="skin", surface=ball)).max() < most


@pytest.mark.parametrize("warp", [PLAIN, LONG], ids=["ball", "ellipsoid"])
def test_that_claim_rejects_centres(warp: SphereWarp) -> None:
    assert np.abs(skin_gaps(warp, HANDS, mode="rigid")).max() > 1e-3


def test_it_rejects_skin_that_does_not_touch_the_prop() -> None:
    hands = touching_hands(12, gap=2e-3)
    assert (
        np.abs(skin_gaps(PLAIN, hands, mode="rigid", contact="skin", surface=ball)).min() > 0.3e-3
    )


def test_far_from_the_prop_skin_is_the_centre() -> None:
    far = touching_hands(3, gap=0.15)
    for hand in far:
        by_skin = HandRetargeter(HandOptions(contact="skin", surface=ball, onset=0.0))
        by_centre = HandRetargeter(HandOptions(onset=0.0))
        shown = by_skin.update(PLAIN, hand, 0.0)
        np.testing.assert_allclose(shown, by_centre.update(PLAIN, hand, 0.0), atol=1e-9)


def test_a_finger_that_comes_through_the_surface_does_not_jump() -> None:
    retargeter = HandRetargeter(HandOptions(mode="rigid", contact="skin", surface=ball, onset=0.0))
    hand = HANDS[0]
    way = hand[9, :3, 3] / np.linalg.norm(hand[9, :3, 3])
    depths = np.arange(-0.02, 0.02, 1e-4)
    shown = []
    for depth in depths:
        moved = hand.copy()
        moved[:, :3, 3] -= depth * way
        shown.append(retargeter.update(LONG, moved, 0.0, RADII)[9, :3, 3])
    assert np.linalg.norm(np.diff(shown, axis=0), axis=-1).max() < 3e-4


def test_pads_are_shown_where_their_points_are() -> None:
    offsets = np.zeros((5, 3))
    offsets[:, 1], offsets[:, 2] = -6e-3, -3e-3
    for given in (None, tuple(map(tuple, offsets.tolist()))):
        retargeter = HandRetargeter(HandOptions(contact="pad", pad_offsets=given, onset=0.0))
        local = np.tile([0.0, -TIP_RADIUS, 0.0], (5, 1)) if given is None else offsets
        for hand in reach_and_grasp()[1][100:160:20]:
            shown = retargeter.update(PLAIN, hand, 0.0, RADII)
            pads = np.einsum("nij,nj->ni", hand[TIPS, :3, :3], local) + hand[TIPS, :3, 3]
            there = np.einsum("nij,nj->ni", shown[TIPS, :3, :3], local) + shown[TIPS, :3, 3]
            assert np.linalg.norm(there - PLAIN(pads), axis=-1).max() < 0.1e-3


def test_radii_of_the_device_are_used_and_unknown_ones_are_not() -> None:
    hand = HANDS[0]
    results = []
    for radii in (np.full(25, 0.008), None, np.full(25, np.nan), np.full(25, 0.012)):
        retargeter = HandRetargeter(HandOptions(contact="pad", onset=0.0))
        results.append(retargeter.update(PLAIN, hand, 0.0, radii))
    np.testing.assert_array_equal(results[0], results[1])
    np.testing.assert_array_equal(results[0], results[2])
    assert np.abs(results[0] - results[3]).max() > 1e-4


def test_the_slope_is_that_of_the_warp() -> None:
    points, J = np.empty((6, 3)), np.empty((3, 3))
    x = np.array([0.06, 0.05, -0.03])
    write_stencil(x, STENCIL, points)
    slope_of(LONG(points), STENCIL, J)
    assert np.abs(J - LONG.jacobian(x)).max() < 0.01


def nearest_rotation(J: Float) -> Float:
    U, _, V = np.linalg.svd(J)
    return U @ np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ V))]) @ V


def test_the_turn_is_the_nearest_rotation() -> None:
    random = np.random.default_rng(3)
    R = np.empty((3, 3))
    for _ in range(200):
        turn = about(0, random.uniform(-1, 1)) @ about(1, random.uniform(-1, 1))
        J = turn @ (np.eye(3) + 0.2 * random.normal(size=(3, 3)))
        if np.linalg.det(J) > 0.2:
            turn_of(J, R)
            assert np.abs(R - nearest_rotation(J)).max() < 1e-3


def test_the_turn_is_continuous_through_a_fold() -> None:
    turns = []
    for squeeze in np.linspace(1.0, -0.7, 401):
        R = np.empty((3, 3))
        turn_of(about(2, 0.4) @ np.diag([1.0, 0.8, squeeze]), R)
        turns.append(R)
    assert np.abs(np.diff(turns, axis=0)).max() < 0.01
