"""The goal's own certificate: a good map passes, a spoilt one fails where it is spoilt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.check.stand_ins import (
    Spoiled,
    Still,
    ball_scene,
    ball_warp,
    case_of,
    map_scene,
    shifted,
    translation,
)
from tests.exact.spheres import SphereWarp
from tests.goals.hand_made_maps import (
    RADIUS,
    STRETCH,
    ball,
    cube_map,
    doubled,
    ellipsoid_map,
    identity_map,
    with_a_hole,
    with_one_flip,
)
from touchwarp.check import Check
from touchwarp.check.goal_map import check_map
from touchwarp.check.virtual_contact import check_virtual_contact
from touchwarp.goals import Goal
from touchwarp.scene import Fixed, Prop, Scene
from touchwarp.scene.shapes import box, polygon
from touchwarp.warp.protocol import Warp


def found(goal: Goal, warp: Warp | None = None, **more: str) -> dict[str, Check]:
    case = case_of(map_scene(goal, **more), warp or Still())
    return {c.name: c for f in (check_virtual_contact, check_map) for c in f(case).checks}


def ellipsoid_warp() -> SphereWarp:
    return SphereWarp(
        radius=RADIUS,
        outer_radius=0.2,
        shift=np.zeros(3),
        stretch=STRETCH - np.eye(3),
        screening=0.0,
    )


def test_a_good_map_with_an_exact_warp_keeps_every_promise() -> None:
    checks = found(ellipsoid_map(), ellipsoid_warp())
    assert {c.name for c in checks.values() if c.group == "hard"} == {
        *("virtual.mean", "virtual.p99"),
        *("map.flips", "map.coverage", "map.layers", "map.vertices", "map.distance"),
    }
    assert {c.status for c in checks.values() if c.group == "hard"} == {"pass"}
    assert checks["map.coverage"].value == 100.0
    assert checks["virtual.p99"].value == pytest.approx(0.0, abs=1e-9)
    assert checks["map.displacement"].value == pytest.approx(7.85, rel=0.02)
    assert checks["map.stretch_greatest"].value == pytest.approx(1.2, rel=1e-3)
    assert checks["map.stretch_least"].value == pytest.approx(0.8, rel=1e-3)


def test_one_flipped_face_fails() -> None:
    goal = with_one_flip(ellipsoid_map())
    check = found(goal)["map.flips"]
    assert check.status == "fail"
    assert check.where is not None
    near = goal.prop_points[goal.faces[0]].mean(axis=0)
    assert np.linalg.norm(np.array(check.where) - near) < 5e-3


def test_a_hole_in_coverage_fails() -> None:
    pole = np.array([0.0, 0.0, RADIUS])
    check = found(with_a_hole(ellipsoid_map(), pole, 0.006))["map.coverage"]
    assert check.status == "fail"
    assert check.where is not None
    assert np.linalg.norm(np.array(check.where) - pole) < 8e-3


def test_an_image_that_winds_twice_round_fails() -> None:
    checks = found(doubled(identity_map(ball(0.02))))
    assert checks["map.layers"].status == "fail"
    assert checks["map.coverage"].status == "pass"


def test_a_landmark_off_fails_and_is_placed() -> None:
    goal = ellipsoid_map()
    marks = np.stack([goal.prop_points[[3, 50, 90]], goal.virtual_points[[3, 50, 90]]], axis=1)
    good = replace(goal, landmarks=marks)
    assert found(good)["map.landmarks"].status == "pass"
    off = marks.copy()
    off[1, 1] += [0, 0, 3e-4]
    check = found(replace(goal, landmarks=off))["map.landmarks"]
    assert check.status == "fail"
    assert check.where == pytest.approx(marks[1, 0])


def test_an_image_off_its_surface_fails() -> None:
    goal = ellipsoid_map()
    off = replace(goal, virtual_points=goal.virtual_points + np.array([0, 0, 2e-4]))
    checks = found(off)
    assert checks["map.distance"].status == checks["map.vertices"].status == "fail"
    assert checks["map.distance"].value == pytest.approx(0.2, rel=0.05)


def test_points_from_elsewhere_may_be_rounded() -> None:
    goal = ellipsoid_map()
    off = replace(goal, virtual_points=goal.virtual_points + np.array([0, 0, 1e-5]))
    assert found(off)["map.vertices"].status == "fail"
    assert found(replace(off, kind="arrays"))["map.vertices"].status == "pass"


def test_a_warp_off_the_virtual_surface_fails_and_one_that_slides_along_it_does_not() -> None:
    surface = ball()
    still = identity_map(surface)
    assert found(still, shifted(Still(), 0.3))["virtual.p99"].status == "fail"

    def turn(x):
        return 0.02 * np.stack([-x[:, 1], x[:, 0], 0 * x[:, 2]], axis=1)

    sliding = found(still, Spoiled(Still(), turn))
    # 1 mm along the surface, and off it by no more than the turn's second order
    assert sliding["virtual.p99"].status == "pass"


def test_what_is_not_finite_is_far() -> None:
    broken = Spoiled(Still(), lambda x: np.where(x[:, :1] > 0.04, np.nan, 0.0 * x))
    assert found(identity_map(ball()), broken)["virtual.max"].value == np.inf


def test_only_area_preserving_goals_promise_areas() -> None:
    goal = ellipsoid_map()
    assert found(goal)["map.area_std"].group == "told"
    promised = found(replace(goal, kind="area_preserving"))["map.area_std"]
    assert (promised.status, promised.group) == ("fail", "hard")
    assert (
        found(replace(identity_map(ball()), kind="area_preserving"))["map.area_std"].status
        == "pass"
    )


def test_a_projection_may_leave_part_of_the_object_out() -> None:
    goal = with_a_hole(ellipsoid_map(), np.array([0.0, 0.0, RADIUS]), 0.02)
    check = found(replace(goal, kind="plane_projection"))["map.coverage"]
    assert (check.status, check.group) == ("pass", "told")


def test_a_cube_shown_as_a_ball_loses_its_edges_and_changes_curvature() -> None:
    checks = found(cube_map())
    assert checks["map.edges_lost"].value == 100.0
    assert "map.edges_new" not in checks
    assert "map.edges_offset" not in checks
    curvature = checks["map.curvature"]
    # an edge of the cube is felt with about 130 1/m and seen with 20
    assert curvature.where is not None
    assert np.sort(np.abs(curvature.where))[1:] == pytest.approx([0.04, 0.04], abs=1e-6)
    for name in ("map.edges_lost", "map.curvature", "map.stretch_greatest", "map.stretch_least"):
        assert (checks[name].status, checks[name].group) == ("unknown", "judged")
    assert "1.8" in checks["map.stretch_greatest"].condition


def test_transforms_have_no_map_to_check() -> None:
    case = case_of(ball_scene(), ball_warp())
    assert check_map(case).checks == check_virtual_contact(case).checks == []


def test_a_goal_without_a_virtual_surface_promises_none() -> None:
    checks = found(replace(ellipsoid_map(), virtual_surface=None), ellipsoid_warp())
    assert {c.group for c in checks.values()} == {"judged", "told"}
    assert "map.curvature" in checks


@pytest.mark.parametrize("on_table", [True, False])
def test_a_foot_on_the_table_is_told_by_itself(on_table: bool) -> None:
    # 1 mm off on the foot alone; without the table a hand comes there
    block = box([0.06, 0.04, 0.1]).transformed(translation(0, 0, 0.05))
    goal = Goal(block.vertices, block.vertices, block.faces, virtual_surface=block)
    table = Fixed("table", plane=((0, 0, 0), (0, 0, 1)), contact="slide")
    scene = Scene(props=[Prop("block", block, goal)], fixed=[table] if on_table else [])
    off = Spoiled(Still(), lambda x: np.where(x[:, 2:] < 1e-9, np.array([0, 0, -1e-3]), 0.0))
    checks = {c.name: c for c in check_virtual_contact(case_of(scene, off)).checks}
    if on_table:
        assert checks["virtual.max"].value == pytest.approx(0.0, abs=1e-9)
        assert checks["virtual.foot"].value == pytest.approx(1.0)
        assert checks["virtual.foot"].group == "told"
    else:
        assert checks["virtual.p99"].value == pytest.approx(1.0)
        assert "virtual.foot" not in checks


def test_a_weight_of_areas_is_told_with_its_reason() -> None:
    told = {"area_weight": 1.15, "area_weight_reason": "at 0.5 areas spread by 0.16"}
    checks = found(replace(ellipsoid_map(), report=told))
    assert checks["map.area_std"].detail.endswith(
        " area_weight is 1.15: at 0.5 areas spread by 0.16."
    )
    assert "area_weight" not in found(ellipsoid_map())["map.area_std"].detail  # the twin


def test_in_the_plane_contact_is_held_against_the_virtual_outline() -> None:
    outline = polygon([[0, 0], [0.1, 0], [0.1, 0.05], [0, 0.05]])
    goal = Goal(outline.vertices, outline.vertices, outline.faces, virtual_surface=outline)
    scene = Scene(props=[Prop("slab", outline, goal)], dimension=2)
    for millimetres, status in ((0.01, "pass"), (0.3, "fail")):
        case = case_of(scene, shifted(Still(2), millimetres))
        checks = {c.name: c for c in check_virtual_contact(case).checks}
        assert checks["virtual.p99"].status == status
        assert check_map(case).checks == []
