"""The solver's estimate is held against the tolerance; silence is unknown."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest

from tests.check.stand_ins import ball_scene, ball_table, ball_warp, block_scene, case_of
from touchwarp.check.estimate import check_estimate


@pytest.mark.parametrize(("told", "status"), [(0.09, "pass"), (0.11, "fail"), (None, "unknown")])
def test_the_estimate_against_the_tolerance(told: float | None, status: str) -> None:
    scene = ball_scene()
    warp = ball_table(scene, estimated_error_max_mm=told, tolerance_mm=0.1)
    (check,) = check_estimate(case_of(scene, warp)).checks
    assert (check.status, check.value) == (status, told)


def test_a_warp_without_a_word_is_unknown() -> None:
    (check,) = check_estimate(case_of(ball_scene(), ball_warp())).checks
    assert check.status == "unknown"
    assert "SphereWarp carries no estimate" in check.detail


def test_what_the_solution_tells_beyond_that_is_told() -> None:
    scene = block_scene()
    told = SimpleNamespace(estimated_edge_error_mm=0.4, capped=True, contradiction_mm=3.0)
    warp = SimpleNamespace(**{"solution": told, "dimension": 3})
    meta = ball_table(ball_scene()).meta
    checks = {c.name: c for c in check_estimate(replace(case_of(scene, warp), meta=meta)).checks}
    assert checks["estimate.edges"].value == 0.4
    assert "capped" in checks["estimate.edges"].detail
    assert checks["estimate.contradiction"].value == 3.0
    assert checks["estimate.contradiction"].group == "told"
