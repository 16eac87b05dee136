"""Whole reaches: gain, direction and jumps of warps whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest

from tests.check.stand_ins import Spoiled, Still, ball_scene, block_scene, case_of
from touchwarp.check.reaches import RING_RADIUS, check_reaches


def found(scene, warp):
    finding = check_reaches(case_of(scene, warp))
    return {c.name: c for c in finding.checks}, finding.shown


def test_reaches_without_a_warp_are_true() -> None:
    checks, shown = found(ball_scene(1.0, (0, 0, 0)), Still())
    assert checks["reach.gain_low"].value == pytest.approx(1.0)
    assert checks["reach.direction"].value == pytest.approx(0.0, abs=1e-5)
    assert checks["reach.jump"].value == pytest.approx(0.0, abs=1e-9)
    assert {checks[n].status for n in ("reach.gain_low", "reach.gain_high", "reach.direction")} == {
        "pass"
    }
    assert len(shown["ratio"]) > 400


def test_reaches_start_on_the_ring_and_meet_nothing_on_the_way() -> None:
    _, shown = found(ball_scene(), Still())
    starts, ends = shown["starts"], shown["ends"]
    assert np.linalg.norm(starts, axis=1) == pytest.approx(
        np.full(len(starts), RING_RADIUS), abs=1e-3
    )
    # a ball's near side only, but for the tilt of its facets
    assert np.einsum("ij,ij->i", starts - ends, ends).min() > -0.1 * 0.4 * 0.05
    _, shown = found(block_scene(), Still())
    assert (shown["starts"][:, 2] > 0).all()


def contract(x):
    """The last 100 mm towards the centre are shown at half the speed."""
    r = np.linalg.norm(x, axis=1, keepdims=True)
    return np.where(r < 0.15, 0.5 * (0.15 - r) * x / r, 0.0)


def test_a_slowed_reach_warns() -> None:
    checks, _ = found(ball_scene(1.0, (0, 0, 0)), Spoiled(Still(), contract))
    low = checks["reach.gain_low"]
    assert low.status == "warn"
    # straight on: 300 mm of the 350 mm are shown; aslant reaches see a little less of it
    assert low.value == pytest.approx(300 / 350, abs=0.03)
    assert checks["reach.slowest"].value == pytest.approx(0.5, abs=0.02)
    # it is slow within 150 mm of the centre, and there the line leads
    assert np.linalg.norm(checks["reach.slowest"].where) < 0.15
    assert checks["reach.jump"].value == pytest.approx(0.5, rel=0.15)


def test_a_deflected_reach_warns() -> None:
    aside = Spoiled(
        Still(),
        lambda x: np.where(np.linalg.norm(x, axis=1, keepdims=True) < 0.1, [0, 0, 0.06], 0.0),
    )
    checks, _ = found(ball_scene(1.0, (0, 0, 0)), aside)
    assert checks["reach.direction"].status == "warn"
    assert checks["reach.direction"].value == pytest.approx(
        np.degrees(np.arctan(60 / 355)), abs=1.2
    )


def test_a_wall_around_the_prop_leaves_no_reach() -> None:
    from touchwarp.scene import Fixed
    from touchwarp.scene.shapes import sphere

    shell = Fixed("shell", surface=sphere(0.1, 0.5))
    checks, shown = found(ball_scene(1.0, (0, 0, 0), fixed=[shell]), Still())
    assert checks["reach.gain_low"].status == "unknown"
    assert "No surface point can be reached" in checks["reach.gain_low"].detail
    assert shown == {}
