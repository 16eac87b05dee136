"""What a table forbids a goal is told apart from what a warp does wrong."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from tests.check.stand_ins import (
    Float,
    Spoiled,
    Still,
    ball_scene,
    block_scene,
    case_of,
    translation,
)
from touchwarp.check.bounds import check_bounds
from touchwarp.check.contact import check_contact
from touchwarp.check.report import Check
from touchwarp.scene import Fixed, Prop, Scene, TransformGoal
from touchwarp.scene.shapes import box
from touchwarp.warp.protocol import Warp

LIFT = TransformGoal(translation=(0.0, 0.0, 0.01))
SHELF = Fixed(
    "shelf", surface=box([0.3, 0.3, 0.02]).transformed(translation(0, 0, -0.01)), blend_mm=5.0
)


def found(scene: Scene, warp: Warp) -> dict[str, Check]:
    return {c.name: c for c in check_contact(case_of(scene, warp)).checks}


def lifted_over(width: float) -> Warp:
    """By 10 mm, `width` above the table and more; on it not at all."""

    def up(x: Float) -> Float:
        s = np.clip(x[:, 2] / width, 0.0, 1.0)
        return 0.01 * s[:, None] * np.array([0.0, 0.0, 1.0])

    return Spoiled(Still(), up)


def test_what_the_table_forbids_warns_and_the_rest_is_held_to_its_limits() -> None:
    checks = found(block_scene(goal=LIFT), lifted_over(0.01))
    for name in ("contact.mean", "contact.p99", "contact.max"):
        assert (checks[name].status, checks[name].value) == ("pass", pytest.approx(0.0, abs=1e-9))
    forbidden = checks["contact.contradicted"]
    assert (forbidden.status, forbidden.value) == ("warn", pytest.approx(10.0, abs=0.02))
    assert forbidden.where is not None
    assert forbidden.where[2] == pytest.approx(0.0, abs=2e-5)
    # 10 mm of the walls around the foot, which counts by itself
    share = 2 * (6 + 4) * 1 / (2 * 6 * 4 + 2 * (6 + 4) * 10)
    told = float(forbidden.detail.split(" % of the surface")[0])
    assert told == pytest.approx(100 * share, abs=0.6)  # three standard errors
    assert "table forbids up to 10 mm" in forbidden.detail


def test_a_warp_that_gives_way_farther_than_it_may_fails() -> None:
    checks = found(block_scene(goal=LIFT), lifted_over(0.02))
    assert checks["contact.mean"].status == checks["contact.p99"].status == "fail"


def test_a_goal_along_the_table_contradicts_nothing() -> None:
    along = block_scene(goal=TransformGoal(translation=(0.01, 0.0, 0.0)))
    checks = found(along, Still())
    assert "contact.contradicted" not in checks
    assert checks["contact.mean"].value == pytest.approx(10.0)


def test_what_is_held_forbids_that_too() -> None:
    along = block_scene(goal=TransformGoal(translation=(0.01, 0.0, 0.0)))
    scene = replace(along, fixed=[SHELF])
    checks = found(scene, Spoiled(Still(), lambda x: np.array([0.01, 0.0, 0.0])))
    assert checks["contact.mean"].value == pytest.approx(0.0, abs=1e-9)
    assert "shelf forbids up to 10 mm" in checks["contact.contradicted"].detail


def test_a_round_foot_that_is_stretched_is_no_contradiction() -> None:
    still = ball_scene(1.0, (0, 0, 0))
    ball = still.props[0].surface.transformed(translation(0, 0, 0.05))
    table = Fixed("table", plane=([0, 0, 0], [0, 0, 1]))
    tall = TransformGoal(pivot="base", scale=(1.0, 1.0, 3.0))
    checks = found(Scene(props=[Prop("ball", ball, tall)], fixed=[table]), Still())
    assert "contact.contradicted" not in checks


def test_a_prop_that_may_nowhere_meet_its_goal_has_no_contact_to_measure() -> None:
    scene = block_scene((0.06, 0.04, 0.008), goal=LIFT)
    checks = found(scene, Still())
    assert checks["contact.mean"].status == checks["contact.p99"].status == "unknown"
    assert "everywhere on this prop" in checks["contact.mean"].detail
    assert checks["contact.contradicted"].status == "warn"


def near_edge(added: float) -> Callable[[Float], Float]:
    def chip(x: Float) -> Float:
        near = np.hypot(x[:, 0] - 0.03, x[:, 1] - 0.02) < 1e-4
        return np.where(near[:, None], added, 0.0) * np.array([1.0, 0.0, 0.0])

    return chip


def test_mismatch_beside_the_props_may_have_the_contact_error_of_edges_but_not_that_of_tables() -> (
    None
):
    def limit(scene: Scene, warp: Warp) -> float:
        checks = {c.name: c for c in check_bounds(case_of(scene, warp)).checks}
        value = checks["bounds.excess_at_surface"].limit
        assert isinstance(value, float)
        return value

    still = block_scene()
    assert limit(still, Still()) == pytest.approx(0.1, abs=2e-3)
    assert limit(still, Spoiled(Still(), near_edge(4e-4))) == pytest.approx(0.4, abs=2e-3)
    assert limit(block_scene(goal=LIFT), lifted_over(0.01)) == pytest.approx(0.1, abs=2e-3)
