"""A scene and a warp that do not belong together are refused, each with its reason."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import touchwarp as tw
from tests.check.stand_ins import Still, ball_bricks, ball_scene, ball_table, ball_warp, translation
from touchwarp.check.belonging import require_belonging
from touchwarp.goals import goals
from touchwarp.scene import (
    DirectionGoal,
    Fixed,
    Interaction,
    Objective,
    Outer,
    Prop,
    Scene,
    TextureGoal,
    UvMesh,
)
from touchwarp.scene.shapes import box, sphere
from touchwarp.warp.meta import WarpMeta
from touchwarp.warp.table import TableWarp


def refused(scene, warp, match: str) -> None:
    with pytest.raises(tw.WarpFileError, match=match):
        tw.check(scene, warp, samples=2000)


def test_the_right_pair_is_accepted_whatever_the_mode_and_lambda() -> None:
    scene = ball_scene()
    warp = ball_table(scene)
    for other in (
        scene,
        replace(scene, interaction=Interaction("pinch")),
        replace(scene, objective=Objective(mismatch_weight=3.0)),
    ):
        assert tw.check(other, warp, samples=2000).facts["props"] == ["ball"]


def test_another_goal() -> None:
    refused(ball_scene(1.21), ball_table(ball_scene(1.2)), "goal of 'ball' is not the one")


def test_another_surface() -> None:
    scene = ball_scene()
    other = replace(scene, props=[replace(scene.props[0], surface=sphere(0.05, 0.3))])
    refused(other, ball_table(scene), "surface of 'ball' is not the one")


def test_another_prop() -> None:
    scene = ball_scene()
    other = replace(scene, props=[Prop("sphere", scene.props[0].surface, scene.props[0].goal)])
    refused(other, ball_table(scene), "has the props 'sphere', but the warp was made for 'ball'")


def test_another_outer_boundary() -> None:
    refused(
        ball_scene(outer=Outer(box_scale=3.0)), ball_table(ball_scene()), r"\[outer\] of the scene"
    )


def test_another_table_under_it() -> None:
    table = Fixed("table", plane=([0, 0, -0.06], [0, 0, 1]))
    refused(ball_scene(fixed=[table]), ball_table(ball_scene()), r"\[fixed\] of the scene")


def test_a_scene_text_that_is_no_toml() -> None:
    scene = ball_scene()
    refused(scene, ball_table(scene, scene_text="[oops"), "scene text is no TOML")


def test_bases() -> None:
    scene = ball_scene()
    refused(scene, ball_table(scene, kind="bases"), "holds bases, not a warp")


def test_another_dimension() -> None:
    refused(ball_scene(), Still(2), "The warp is 2-D, but the scene 3-D")


def test_too_few_samples() -> None:
    with pytest.raises(ValueError, match="at least 1000 are needed"):
        tw.check(ball_scene(), ball_warp(), samples=10)


def test_a_carried_warp_is_checked_where_it_was_solved() -> None:
    scene = ball_scene()
    here = tw.check(scene, ball_table(scene), samples=2000)
    T = translation(0.3, -0.2, 0.1)
    T[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    there = tw.check(scene, ball_table(scene).at(T), samples=2000)
    assert there.of("contact.p99").value == pytest.approx(here.of("contact.p99").value, rel=1e-6)
    assert there.of("continuity.jump").status == "pass"
    assert np.linalg.norm(there.of("contact.p99").where) < 0.06


def test_a_goal_that_is_no_matrix_does_not_belong_to_one_that_is() -> None:
    scene = ball_scene()
    table = TableWarp(ball_bricks(), replace(ball_table(scene).meta, goals={}))
    refused(scene, table, "goal of 'ball' is not the one")


def shaped_scene(radius: float = 0.05, tolerance_mm: float = 0.5) -> Scene:
    """A cube felt as a ball."""
    goal = DirectionGoal(sphere(radius, 0.3), tolerance_mm=tolerance_mm)
    return Scene([Prop("cube", box((0.08, 0.08, 0.08)), goal)])


def shaped_meta(scene: Scene) -> WarpMeta:
    return WarpMeta(scene_text=scene.text, mesh_digests=scene.digests, prop_names=("cube",))


def test_a_goal_to_another_shape_belongs_to_its_own_warp() -> None:
    scene = shaped_scene()
    require_belonging(scene, goals(scene), shaped_meta(shaped_scene()))


@pytest.mark.parametrize(
    ("other", "message"),
    [
        (shaped_scene(radius=0.06), "The surface of 'cube, virtual object' is not the one"),
        (shaped_scene(tolerance_mm=1.0), "The goal of 'cube' is not the one that the warp was"),
    ],
)
def test_another_virtual_object_or_way_to_it(other: Scene, message: str) -> None:
    with pytest.raises(tw.WarpFileError, match=message):
        require_belonging(other, goals(other), shaped_meta(shaped_scene()))


def test_another_texture() -> None:
    cube = box((0.08, 0.08, 0.08))
    atlas = UvMesh(cube.vertices, cube.faces, np.full((8, 2), 0.5))
    painted = [
        Scene([Prop("cube", cube, TextureGoal(np.full((2, 2, 3), shift), atlas))])
        for shift in (0.01, 0.02)
    ]
    require_belonging(painted[0], goals(painted[0]), shaped_meta(painted[0]))
    with pytest.raises(tw.WarpFileError, match="The surface of 'cube, texture' is not the one"):
        require_belonging(painted[1], goals(painted[1]), shaped_meta(painted[0]))
