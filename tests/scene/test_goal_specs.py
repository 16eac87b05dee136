"""Goals with a virtual object, as the scene file says them and as code builds them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from touchwarp.errors import GoalError, SceneError, TouchwarpError
from touchwarp.scene import (
    AreaPreservingGoal,
    DirectionGoal,
    Landmark,
    MatchGoal,
    Patch,
    PlaneProjectionGoal,
    TextureGoal,
    UvMesh,
    VerticesGoal,
    describe,
    parse_scene,
)
from touchwarp.scene.goal_spec import GOAL_SPECS
from touchwarp.scene.shapes import box, polygon
from touchwarp.scene.write import scene_text

CUBE = box((0.1, 0.1, 0.1))
PROP = '[[prop]]\nname = "cube"\nshape = { kind = "box", size = [0.1, 0.1, 0.1] }\n[prop.goal]\n'
VIRTUAL = 'virtual_shape = { kind = "box", size = [0.2, 0.1, 0.1] }\n'

EVERY_KEY = {
    "plane_projection": "patches = [{ point = [0, 0, 0.01], normal = [0, 0, 2] }]\n"
    "gap_mm = 0.3\ntolerance_mm = 0.1",
    "direction": "centre = [0, 0, 0.01]\nvirtual_centre = [0, 0, 0.02]\ntolerance_mm = 0.1",
    "area_preserving": "seed = 3\nstarts = 2\ntolerance_mm = 0.1",
    "match": "displacement_weight = 2\nsmoothness_weight = 3\narea_weight = 4\nnormal_weight = 5\n"
    "curvature_weight = 6\nseed = 7\nstarts = 8\ntolerance_mm = 0.1\n"
    "landmarks = [{ prop = [0, 0, 0.05], virtual = [0.1, 0, 0.05] }]\nbase = [0, 0, -2]",
    "vertices": "pose = { position = [0, 0, 0.3], rotation_deg = [0, 0, 90] }",
}


def goal_of(text: str, directory: Path = Path()) -> Any:
    return parse_scene(PROP + text, directory).props[0].goal


def refusal(text: str) -> str:
    with pytest.raises(TouchwarpError) as error:
        goal_of(text)
    return str(error.value)


@pytest.mark.parametrize("kind", EVERY_KEY)
def test_every_key_is_read_and_written_back(kind: str) -> None:
    scene = parse_scene(f'{PROP}kind = "{kind}"\n{VIRTUAL}{EVERY_KEY[kind]}\n')
    text = scene_text(scene)
    again = parse_scene(text)
    assert scene_text(again) == text
    goal: Any = again.props[0].goal
    assert type(goal) is GOAL_SPECS[kind]
    for key in re.findall(r"^(\w+) = ", EVERY_KEY[kind], flags=re.MULTILINE):
        assert key in goal.keys, key
        assert re.search(rf"^{key} = ", text, flags=re.MULTILINE), key
    np.testing.assert_array_equal(
        goal.virtual.vertices, parse_scene(text).props[0].goal.virtual.vertices
    )


def test_patches_may_be_normals_alone() -> None:
    text = 'kind = "plane_projection"\npatches = [{ normal = [0, 0, 2] }]\n' + VIRTUAL
    assert goal_of(text).patches == (Patch((0, 0, 1)),)
    assert goal_of(text).entries()["patches"] == [{"normal": (0, 0, 1)}]


def test_the_values_reach_their_places() -> None:
    match = goal_of(f'kind = "match"\n{VIRTUAL}{EVERY_KEY["match"]}')
    weights = [match.displacement_weight, match.smoothness_weight, match.area_weight]
    assert [*weights, match.normal_weight, match.curvature_weight] == [2, 3, 4, 5, 6]
    assert (match.seed, match.starts, match.tolerance_mm) == (7, 8, 0.1)
    assert match.base == (0, 0, -1)
    assert match.landmarks == (Landmark((0, 0, 0.05), (0.1, 0, 0.05)),)
    plane = goal_of(f'kind = "plane_projection"\n{VIRTUAL}{EVERY_KEY["plane_projection"]}')
    assert plane.patches == (Patch((0, 0, 1), (0, 0, 0.01)),)
    assert (plane.normal, plane.gap_mm) == (None, 0.3)
    about = goal_of(f'kind = "direction"\n{VIRTUAL}{EVERY_KEY["direction"]}')
    assert (about.centre, about.virtual_centre) == ((0, 0, 0.01), (0, 0, 0.02))


def test_an_area_weight_that_is_not_given_stays_open() -> None:
    match = goal_of(f'kind = "match"\n{VIRTUAL}')
    assert match.area_weight is None
    assert match.weighs_by_default
    assert "area_weight" not in match.entries()
    for key in ("area_weight = 0.5", "curvature_weight = 0.2"):
        assert not goal_of(f'kind = "match"\n{key}\n{VIRTUAL}').weighs_by_default


def test_a_virtual_mesh_has_unit_up_axis_and_pose(tmp_path: Path) -> None:
    long = box((0.3, 0.2, 0.1))
    trimesh.Trimesh(long.vertices * 1e3, long.faces, process=False).export(tmp_path / "long.stl")
    goal = goal_of(
        'kind = "vertices"\nvirtual_mesh = "long.stl"\nunit = "mm"\nup = "y"\n'
        "pose = { position = [1, 0, 0], rotation_deg = [0, 0, 90] }",
        tmp_path,
    )
    # y up: (x, y, z) becomes (x, −z, y); the quarter turn about z makes that (z, x, y).
    expected = np.array([[0.95, -0.15, -0.1], [1.05, 0.15, 0.1]])
    assert goal.virtual.bounds == pytest.approx(expected, abs=1e-7)


def test_goals_built_in_code_are_described_but_cannot_be_read_back() -> None:
    scene = parse_scene(PROP + 'kind = "transform"').with_goals({"cube": MatchGoal(CUBE)})
    text = scene_text(scene)
    assert "virtual_mesh = { digest = " in text
    with pytest.raises(SceneError, match=r"goal.virtual_mesh was given as arrays \(SHA-256"):
        parse_scene(text)
    texture = TextureGoal(np.zeros((4, 4, 3)), UvMesh(CUBE.vertices, CUBE.faces, np.zeros((8, 2))))
    text = scene_text(scene.with_goals({"cube": texture}))
    with pytest.raises(GoalError, match=r"goal.texture was given as arrays, which no scene file"):
        parse_scene(text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('kind = "matched"', "goal.kind is 'matched'. Did you mean 'match'?"),
        ('kind = "match"', "goal has no surface; exactly one of virtual_mesh, virtual_shape"),
        (
            f'kind = "match"\nvirtual_mesh = "a.stl"\n{VIRTUAL}',
            "goal has virtual_mesh and virtual_shape; exactly one",
        ),
        (f'kind = "match"\nunit = "mm"\n{VIRTUAL}', "goal.unit goes with virtual_mesh only"),
        ('kind = "match"\nvirtual_mesh = "a.stl"', "mesh file a.stl does not exist"),
        (f'kind = "match"\nseed = -1\n{VIRTUAL}', "goal.seed is -1.0; a whole number ≥ 0"),
        (f'kind = "match"\nstarts = 1.5\n{VIRTUAL}', "goal.starts is 1.5; a whole number ≥ 1"),
        (f'kind = "match"\narea_weight = -1\n{VIRTUAL}', "goal.area_weight is -1.0; a number ≥ 0"),
        (
            f'kind = "area_preserving"\ntolerance_mm = 0\n{VIRTUAL}',
            "goal.tolerance_mm is 0.0; a number > 0 is needed",
        ),
        (
            f'kind = "match"\nlandmarks = [{{ prop = [0, 0, 0] }}]\n{VIRTUAL}',
            "goal.landmarks[#1].virtual is missing",
        ),
        (f'kind = "plane_projection"\n{VIRTUAL}', "goal has neither normal nor patches; give the"),
        (
            'kind = "plane_projection"\nnormal = [0, 0, 1]\n'
            f"patches = [{{ point = [0, 0, 0], normal = [0, 0, 1] }}]\n{VIRTUAL}",
            "goal.normal stands beside goal.patches; give either",
        ),
        (
            f'kind = "plane_projection"\nnormal = [0, 0, 0]\n{VIRTUAL}',
            "goal.normal is (0.0, 0.0, 0.0); a direction of some length is needed",
        ),
        (
            f'kind = "plane_projection"\nnormal = [0, 0, 1]\ngap_mm = -1\n{VIRTUAL}',
            "goal.gap_mm is -1.0; a number ≥ 0 is needed",
        ),
        (
            f'kind = "direction"\nvirtual_centre = [0, 0, 0]\n{VIRTUAL}',
            "goal.virtual_centre stands without goal.centre; give both or neither",
        ),
        ('kind = "texture"', "goal.texture is missing"),
    ],
)
def test_what_is_wrong_is_told(text: str, message: str) -> None:
    told = refusal(text)
    assert told.startswith("prop[cube]: goal")
    assert message in told


@pytest.mark.parametrize("kind", ["match", "texture"])
def test_plane_scenes_have_transforms_only(kind: str) -> None:
    text = (
        'dimension = 2\n[[prop]]\nname = "s"\npolygon = [[0, 0], [1, 0], [0, 1]]\n'
        f'[prop.goal]\nkind = "{kind}"\n'
    )
    with pytest.raises(GoalError, match="surfaces in space, but the scene is 2-D"):
        parse_scene(text)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: VerticesGoal("cup.stl"), "virtual object of a vertices goal is a str; a Surface"),
        (
            lambda: MatchGoal(polygon([(0, 0), (1, 0), (0, 1)])),
            "virtual object of a match goal is 2-D; a surface in space is needed",
        ),
        (lambda: DirectionGoal(CUBE, centre=(0, 0)), r"goal.centre is \(0, 0\); three numbers"),
        (lambda: DirectionGoal(CUBE, centre="here"), "goal.centre is 'here'; numbers are needed"),
        (
            lambda: DirectionGoal(CUBE, centre=(0, 0, np.nan)),
            "goal.centre is .*; finite numbers are needed",
        ),
        (lambda: AreaPreservingGoal(CUBE, starts=0), "goal.starts is 0; a whole number ≥ 1"),
        (
            lambda: PlaneProjectionGoal(
                CUBE, patches=[Patch((0, 0, 1)), Patch((1, 0, 0), (0, 0, 0))]
            ),
            "some of goal.patches have a point and some have none; give all of them one",
        ),
        (lambda: PlaneProjectionGoal(CUBE), "goal has neither normal nor patches"),
        (lambda: Landmark((0, 0), (0, 0, 0)), r"goal.landmarks.prop is \(0, 0\); three numbers"),
    ],
)
def test_what_is_wrong_in_code_is_told(build: Any, message: str) -> None:
    with pytest.raises(GoalError, match=message):
        build()


@pytest.mark.parametrize(
    ("image", "message"),
    [
        (np.zeros((4, 4)), r"the texture has the shape \(4, 4\); \(height, width, 3\) is needed"),
        (np.full((2, 2, 3), np.nan), "4 of the texture's 4 pixels are NaN or infinite"),
    ],
)
def test_textures_that_are_none(image: Any, message: str) -> None:
    atlas = UvMesh(CUBE.vertices, CUBE.faces, np.zeros((8, 2)))
    with pytest.raises(GoalError, match=message):
        TextureGoal(image, atlas)
    with pytest.raises(GoalError, match="the texture's atlas is a Surface; a UvMesh is needed"):
        TextureGoal(np.zeros((2, 2, 3)), CUBE)  # type: ignore[arg-type]


def test_a_scene_s_summary_tells_the_virtual_object() -> None:
    scene = parse_scene(f'{PROP}kind = "match"\n{VIRTUAL}')
    told = dict(describe(scene))["prop cube"]
    assert told.endswith("goal match to 200 × 100 × 100 mm, 12 triangles")
