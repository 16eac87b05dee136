"""Contact error is found where it is, and a spoiled warp fails."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.check.stand_ins import (
    Spoiled,
    Still,
    ball_scene,
    ball_warp,
    block_scene,
    case_of,
    shifted,
    translation,
)
from touchwarp.check.contact import check_contact
from touchwarp.check.report import Check
from touchwarp.scene import Prop, Surface


def found(scene, warp, **more) -> dict[str, Check]:
    return {c.name: c for c in check_contact(case_of(scene, warp, **more)).checks}


def test_the_exact_warp_touches() -> None:
    checks = found(ball_scene(), ball_warp())
    for name in ("contact.mean", "contact.p99", "contact.max"):
        assert checks[name].status == "pass"
        assert checks[name].value == pytest.approx(0.0, abs=1e-9)


def test_a_warp_0_3_mm_off_fails() -> None:
    checks = found(ball_scene(), shifted(ball_warp(), 0.3))
    assert checks["contact.mean"].status == checks["contact.p99"].status == "fail"
    assert checks["contact.p99"].value == pytest.approx(0.3, rel=1e-9)


def test_the_greatest_error_is_placed() -> None:
    spot = np.array([0.0, 0.0, 0.05])

    def dent(x):
        near = np.linalg.norm(x - spot, axis=1) < 3e-3
        return np.where(near[:, None], 2e-3 * np.array([1.0, 0, 0]), 0.0)

    checks = found(ball_scene(), Spoiled(ball_warp(), dent))
    assert checks["contact.mean"].status == checks["contact.p99"].status == "pass"
    assert checks["contact.max"].status == "fail"
    assert checks["contact.max"].value == pytest.approx(2.0)
    assert np.linalg.norm(np.array(checks["contact.max"].where) - spot) < 4e-3


def test_edges_have_samples_of_their_own() -> None:
    # one edge of the block is displaced by 1 mm within 0.5 mm of it
    def chip(x):
        near = np.hypot(x[:, 0] - 0.03, x[:, 1] - 0.02) < 5e-4
        return np.where(near[:, None], np.array([1e-3, 0, 0]), 0.0)

    checks = found(block_scene(), Spoiled(Still(), chip))
    assert checks["edges.max"].value == pytest.approx(1.0)
    assert checks["edges.p99"].status == "warn"
    assert checks["contact.max"].value == 0.0
    assert checks["contact.max_anywhere"].value == pytest.approx(1.0)


def test_nan_is_no_contact() -> None:
    hole = Spoiled(ball_warp(), lambda x: np.where(x[:, :1] > 0.049, np.nan, 0.0))
    checks = found(ball_scene(), hole)
    assert checks["contact.mean"].status == checks["contact.max"].status == "fail"


def test_two_props_have_half_the_samples_each() -> None:
    scene = ball_scene(1.0, (0, 0, 0))
    moved = scene.props[0].surface.transformed(translation(0.12, 0, 0))
    both = replace(scene, props=[*scene.props, Prop("other", moved)])
    case = case_of(both, Still())
    assert [len(p.samples.points) for p in case.props] == [10_000, 10_000]
    checks = check_contact(case).checks
    assert {c.subject for c in checks if c.name == "contact.mean"} == {"ball", "other"}


def test_a_foot_on_the_table_is_told_by_itself() -> None:
    # 1 mm off on the foot alone, where no hand comes between block and table
    off = Spoiled(Still(), lambda x: np.where(x[:, 2:] < 1e-9, np.array([1e-3, 0, 0]), 0.0))
    checks = found(block_scene(), off)
    assert checks["contact.p99"].value == checks["contact.max"].value == 0.0
    assert checks["contact.foot"].value == pytest.approx(1.0)
    # 60 × 40 of the block's 2 (60 × 40 + 60 × 100 + 40 × 100) mm²
    assert "9.7 % of the surface lies on a fixed plane" in checks["contact.foot"].detail
    case = case_of(block_scene(), off)
    assert case.standing["block"].mean() == pytest.approx(0.0968, abs=5e-3)


@pytest.mark.parametrize("what", ["no table", "above it", "an open sheet"])
def test_a_foot_that_a_hand_can_reach_is_touched(what: str) -> None:
    scene = block_scene()
    if what == "no table":
        scene = replace(scene, fixed=[])
    elif what == "above it":
        surface = scene.props[0].surface.transformed(translation(0, 0, 2e-5))
        scene = replace(scene, props=[Prop("block", surface)])
    else:
        # its underside alone, wound as it was: from above it can be touched
        surface = scene.props[0].surface
        low = (surface.vertices[surface.faces][:, :, 2] < 1e-9).all(axis=1)
        scene = replace(scene, props=[Prop("block", Surface(surface.vertices, surface.faces[low]))])
    off = Spoiled(Still(), lambda x: np.where(x[:, 2:] < 3e-5, np.array([1e-3, 0, 0]), 0.0))
    checks = found(scene, off)
    assert checks["contact.p99"].value == pytest.approx(1.0)
    assert "contact.foot" not in checks
