"""Goals between two-handled vessels."""

from __future__ import annotations

import numpy as np
import pytest

from touchwarp.errors import GoalError
from touchwarp.goals.coverage import cover
from touchwarp.goals.goal import Goal
from touchwarp.goals.maps.hyperbolic import search
from touchwarp.goals.maps.make import area_preserving_goal, match_goal
from touchwarp.goals.surface_tree import SurfaceTree
from touchwarp.scene import AreaPreservingGoal, MatchGoal, Prop, Surface
from touchwarp.scene.map_goals import Landmark
from touchwarp.scene.shapes import sphere

from ..conftest import ring_surface
from .conftest import pot, vase, vessel

VASE, POT = vase(), pot()


@pytest.fixture(scope="module")
def matched() -> Goal:
    return match_goal(Prop("prop", VASE), MatchGoal(POT))


def test_a_two_handled_vase_is_matched_to_a_pot_one_to_one(matched: Goal) -> None:
    tree = SurfaceTree(POT.vertices, POT.faces)
    assert tree.nearest(matched.virtual_points).distance.max() <= 1e-9
    assert matched.report["domain"] == "hyperbolic"
    assert matched.report["domain_flips"] == 0
    assert matched.report["flips"] == 0
    assert matched.report["coverage"] == 1.0
    assert matched.report["layers"] == pytest.approx(1, abs=1e-3)
    assert matched.report["image_distance_max"] <= 0.05e-3


def test_the_claim_rejects_a_map_with_two_images_exchanged(matched: Goal) -> None:
    images = matched.virtual_points.copy()
    a, b, _ = matched.faces[0]
    images[[a, b]] = images[[b, a]]
    changed = Goal(matched.prop_points, images, matched.faces, virtual_surface=POT)
    tree = SurfaceTree(POT.vertices, POT.faces)
    assert cover(changed, POT, tree, 1000, 0).flipped.sum() > 0


def test_handles_show_on_the_handles_beside_them(matched: Goal) -> None:
    for side in (1, -1):
        there = side * matched.prop_points[:, 0] > 0.045
        assert (side * matched.virtual_points[there, 0] > 0.03).all()
    assert matched.report["normal_mean"] < 0.6


def test_landmarks_can_ask_for_another_class(matched: Goal) -> None:
    """Half round the axis each handle shows on the other one: of another class, or far away."""
    ends = [
        Landmark(prop=(s * 0.06, 0, 0.05), virtual=(-s * 0.0743, -s * 0.0104, 0.035))
        for s in (1, -1)
    ]
    led = match_goal(Prop("prop", VASE), MatchGoal(POT, landmarks=ends))
    assert led.report["flips"] == 0
    right = led.prop_points[:, 0] > 0.057
    assert (led.virtual_points[right, 0] < 0).all()
    assert (matched.virtual_points[matched.prop_points[:, 0] > 0.057, 0] > 0).all()  # the twin


def test_the_same_goal_comes_out_again(matched: Goal) -> None:
    again = match_goal(Prop("prop", VASE), MatchGoal(POT))
    assert np.array_equal(again.virtual_points, matched.virtual_points)


def test_area_preserving_keeps_areas_better_than_match(matched: Goal) -> None:
    kept = area_preserving_goal(Prop("prop", VASE), AreaPreservingGoal(POT))
    assert kept.report["flips"] == 0
    assert kept.report["area_std"] < matched.report["area_std"]


def test_no_class_at_all_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "classes", lambda *_: iter(()))
    with pytest.raises(GoalError, match="no map between the prop and the virtual object was found"):
        match_goal(Prop("prop", VASE), MatchGoal(POT))


@pytest.mark.parametrize(
    ("other", "genus"), [(sphere(0.05, 2.0), 0), (ring_surface(), 1)], ids=["ball", "ring"]
)
def test_other_genus_is_refused_with_the_places_of_the_handles(other: Surface, genus: int) -> None:
    with pytest.raises(
        GoalError, match=rf"the prop has genus 2 \(handles about .* mm\).*has genus {genus}"
    ):
        match_goal(Prop("prop", vessel(0.03, 0.1, 0.03)), MatchGoal(other))
