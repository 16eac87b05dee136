"""A finger pad is found from touches."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.hand.hands import about, pose
from tests.hand.test_contact import BALL, ball
from touchwarp.hand import calibrate_pad

Float = NDArray[np.float64]
PAD = np.array([0.5e-3, -6.5e-3, -4e-3])


def touches(count: int, noise: float = 0.0, seed: int = 0) -> Float:
    """(count, 4, 4): the pad is on the ball, the finger at many angles."""
    random = np.random.default_rng(seed)
    poses = []
    for _ in range(count):
        outward = random.normal(size=3)
        outward /= np.linalg.norm(outward)
        z = np.linalg.qr(np.column_stack([outward, random.normal(size=(3, 2))]))[0][:, 1]
        # y out of the back of the finger, away from the ball
        R = np.column_stack([np.cross(outward, z), outward, z])
        R = R @ about(0, random.uniform(-0.6, 0.3)) @ about(2, random.uniform(-0.4, 0.4))
        poses.append(pose(R, BALL * outward - R @ PAD + noise * random.normal(size=3)))
    return np.array(poses)


def test_exact_touches_give_the_pad() -> None:
    found = calibrate_pad(touches(40), ball)
    # what is known beforehand pulls a little
    assert np.abs(found.offset - PAD).max() < 0.2e-3
    assert found.residual < 0.05e-3


def test_that_claim_rejects_touches_with_another_point() -> None:
    moved = touches(40)
    moved[:, :3, 3] += 2e-3 * moved[:, :3, 1]
    assert np.abs(calibrate_pad(moved, ball).offset - PAD).max() > 1e-3


def test_noise_and_outliers_are_borne() -> None:
    poses = touches(40, noise=1e-3)
    poses[::10, :3, 3] += [0.0, 0.0, 0.02]
    found = calibrate_pad(poses, ball)
    assert np.linalg.norm(found.offset - PAD) < 1.2e-3
    assert found.residual > 1e-3


def test_what_touches_do_not_tell_stays_as_usual() -> None:
    flat = np.array([pose(np.eye(3), [x, 7e-3, 0.0]) for x in np.linspace(-0.1, 0.1, 20)])

    def floor(points: Float) -> tuple[Float, Float]:
        return points * [1.0, 0.0, 1.0], np.tile([0.0, 1.0, 0.0], (len(points), 1))

    np.testing.assert_allclose(calibrate_pad(flat, floor).offset, [0, -7e-3, 0], atol=0.01e-3)


def test_touches_are_checked() -> None:
    with pytest.raises(ValueError, match=r"shape \(0, 4, 4\); \(n, 4, 4\), n > 0, is needed"):
        calibrate_pad(np.empty((0, 4, 4)), ball)
    with pytest.raises(ValueError, match="leave out lost ones"):
        calibrate_pad(np.full((3, 4, 4), np.nan), ball)
