"""What the weight of curvature in `match` buys: a rounded edge that shows where it is felt."""

from __future__ import annotations

import pytest

from touchwarp.goals.maps import make, parameterise
from touchwarp.goals.maps.make import match_goal
from touchwarp.scene import MatchGoal, Prop
from touchwarp.scene.shapes import fillet_box

SIZE = (0.1, 0.1, 0.1)
PROP, VIRTUAL = fillet_box(SIZE, 0.01, 0.5), fillet_box(SIZE, 0.03, 0.5)


@pytest.fixture(scope="module")
def layouts(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Where both surfaces' layouts are kept from one map to the next."""
    return str(tmp_path_factory.mktemp("layouts"))


@pytest.fixture(autouse=True)
def fine_enough_for_a_fingertip(
    small_and_alone: None, layouts: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(parameterise, "EDGES_PER_SIZE", 40)
    monkeypatch.setenv("TOUCHWARP_CACHE", layouts)


@pytest.fixture(scope="module")
def none(layouts: str) -> float:
    """The mismatch where curvature has no weight: no path leads there, so both tests share it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(parameterise, "EDGES_PER_SIZE", 40)
        patch.setenv("TOUCHWARP_CACHE", layouts)
        assert make._field_path(MatchGoal(VIRTUAL).normal_weight) == []
        return mismatch(0.0)


def mismatch(weight: float) -> float:
    """Of curvature, 1/m."""
    spec = MatchGoal(VIRTUAL, curvature_weight=weight, tolerance_mm=0.2, starts=1)
    report = match_goal(Prop("prop", PROP), spec).report
    assert report["flips"] == 0
    assert report["coverage"] >= 0.999
    return float(report["curvature_mean"])


def test_more_weight_on_curvature_leaves_less_of_its_mismatch(none: float) -> None:
    some, much = mismatch(3.0), mismatch(100.0)
    assert none > some > much
    assert much < 0.7 * none


def test_the_fall_is_lost_without_a_path_to_the_weight(
    none: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(make, "_field_path", lambda weight: [])
    assert mismatch(3.0) > none
