"""What the weight of curvature in `match` buys: a rounded edge that shows where it is felt."""

from __future__ import annotations

import pytest

from touchwarp.goals.maps import make, parameterise
from touchwarp.goals.maps.make import match_goal
from touchwarp.scene import MatchGoal, Prop
from touchwarp.scene.shapes import fillet_box

SIZE = (0.1, 0.1, 0.1)
PROP, VIRTUAL = fillet_box(SIZE, 0.01, 0.5), fillet_box(SIZE, 0.03, 0.5)


@pytest.fixture(autouse=True)
def fine_enough_for_a_fingertip(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parameterise, "EDGES_PER_SIZE", 40)


def mismatches(*weights: float) -> list[float]:
    """Of curvature, 1/m."""
    told = []
    for weight in weights:
        spec = MatchGoal(VIRTUAL, curvature_weight=weight, tolerance_mm=0.2, starts=1)
        report = match_goal(Prop("prop", PROP), spec).report
        assert report["flips"] == 0
        assert report["coverage"] >= 0.999
        told.append(report["curvature_mean"])
    return told


def test_more_weight_on_curvature_leaves_less_of_its_mismatch() -> None:
    none, some, much = mismatches(0.0, 3.0, 100.0)
    assert none > some > much
    assert much < 0.7 * none


def test_the_fall_is_lost_without_a_path_to_the_weight(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(make, "_field_path", lambda weight: [])
    none, some = mismatches(0.0, 3.0)
    assert some > none
