"""The scene file: everything that it may say, and every way to say it wrong."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from touchwarp.errors import GoalError, SceneError, TouchwarpError
from touchwarp.scene import Scene, Tracking, TransformGoal, load_scene, parse_scene
from touchwarp.scene.shapes import make_shape

PROP = '[[prop]]\nname = "ball"\nshape = { kind = "sphere", radius = 0.03 }\n'

FULL = """
[objective]
mismatch_weight = 1
length_scale = 0.2
tolerance_mm = 0.5
edge_radius_mm = 3.0

[outer]
box = { min = [-0.6, -0.6, -0.3], max = [0.6, 0.6, 0.9] }

[[prop]]
name = "mug"
mesh = "mug.stl"
unit = "mm"
up = "y"
pose = { position = [0.1, 0.2, 0.3], rotation_deg = [0, 0, 90] }

[prop.goal]
kind = "transform"
pivot = "centre"
scale = [1.2, 1.2, 0.6]
rotation_deg = [0, 10, 20]
translation = [0.015, 0, 0]

[[prop]]
name = "crate"
shape = { kind = "box", size = [0.1, 0.1, 0.1] }

[[fixed]]
name = "table"
plane = { point = [0, 0, 0.2], normal = [0, 0, 2] }
blend_mm = 5

[[fixed]]
name = "wall"
shape = { kind = "box", size = [0.01, 0.5, 0.5] }
contact = "hold"

[interaction]
mode = "pinch"
tracking = { bias_mm = 1, latency_ms = 20 }
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    import trimesh

    mug = make_shape("mug", {})
    trimesh.Trimesh(mug.vertices * 1e3, mug.faces, process=False).export(tmp_path / "mug.stl")
    return tmp_path


def read(folder: Path, text: str) -> Scene:
    path = folder / "scene.toml"
    path.write_text(text)
    return load_scene(path)


def refusal(text: str, folder: Path = Path()) -> str:
    with pytest.raises(TouchwarpError) as error:
        parse_scene(text, folder)
    return str(error.value)


def test_every_key_reaches_its_place(folder: Path) -> None:
    scene = read(folder, FULL)
    assert scene.dimension == 3
    assert scene.directory == folder
    assert scene.text == FULL
    assert scene.objective.mismatch_weight == 1.0
    assert scene.objective.screening == pytest.approx(25.0)
    assert (scene.objective.tolerance_mm, scene.objective.edge_radius_mm) == (0.5, 3.0)
    assert np.array_equal(scene.outer.box, [[-0.6, -0.6, -0.3], [0.6, 0.6, 0.9]])
    assert [p.name for p in scene.props] == ["mug", "crate"]
    assert scene.prop("mug").goal == TransformGoal(
        pivot="centre", scale=(1.2, 1.2, 0.6), rotation_deg=(0, 10, 20), translation=(0.015, 0, 0)
    )
    assert scene.prop("crate").goal == TransformGoal()
    table, wall = scene.fixed
    assert (table.contact, table.blend_mm) == ("slide", 5.0)
    assert table.plane is not None
    assert np.array_equal(table.plane, [[0, 0, 0.2], [0, 0, 1]])
    assert scene.slide_plane is table
    assert (wall.contact, wall.blend_mm) == ("hold", 10.0)
    assert wall.surface is not None
    assert scene.interaction.mode == "pinch"
    assert scene.interaction.tracking == Tracking(bias_mm=1.0, latency_ms=20.0)


def test_unit_axis_and_pose_act_in_that_order(folder: Path) -> None:
    # The mug's file axes: 80 + handle along x, 80 along y, 95 along z. With y up, file (x, y, z)
    # becomes (x, −z, y); the quarter turn about z makes that (z, x, y).
    bounds = read(folder, FULL).prop("mug").surface.bounds
    expected = np.array([[0.1, 0.16, 0.26], [0.195, 0.2745, 0.34]])
    assert bounds == pytest.approx(expected, abs=1e-6)


def test_defaults(folder: Path) -> None:
    scene = read(folder, PROP)
    assert scene.objective.mismatch_weight == 0.0
    assert (scene.objective.length_scale, scene.objective.tolerance_mm) == (0.1, 0.1)
    assert scene.outer.box_scale == 4.0
    assert scene.outer.box is None
    assert scene.fixed == ()
    assert scene.interaction.mode == "slide"
    assert isinstance(scene.interaction.tracking, Tracking)
    assert scene.interaction.tracking.name == "markers"


def test_headset_tracking_has_larger_errors(folder: Path) -> None:
    hands = read(folder, PROP + '[interaction]\ntracking = "headset_hands"').interaction.tracking
    markers = read(folder, PROP).interaction.tracking
    assert isinstance(hands, Tracking)
    assert isinstance(markers, Tracking)
    assert (hands.bias_mm, hands.latency_ms) == (11.0, 45.0)
    assert hands.bias_mm > markers.bias_mm


def test_a_closed_mesh_can_be_the_outer_boundary(folder: Path) -> None:
    scene = read(folder, '[outer]\nshape = { kind = "sphere", radius = 0.3 }\n' + PROP)
    assert scene.outer.box_scale is None
    assert scene.outer.surface is not None
    assert scene.outer.surface.bounds[1] == pytest.approx([0.3, 0.3, 0.3], abs=1e-4)


def test_a_plane_scene(folder: Path) -> None:
    scene = read(
        folder,
        "dimension = 2\n[outer]\npolygon = [[-1, -1], [1, -1], [1, 1], [-1, 1]]\n"
        '[[prop]]\nname = "s"\npolygon = [[0, 0], [0.2, 0], [0.2, 0.1]]\n'
        "pose = { position = [0.1, 0], rotation_deg = 90 }\n"
        '[prop.goal]\nkind = "transform"\nscale = [2, 1]\nrotation_deg = 5\n'
        '[[fixed]]\nname = "floor"\nplane = { point = [0, 0], normal = [0, 1] }\n',
    )
    assert scene.dimension == 2
    bounds = scene.prop("s").surface.bounds
    assert bounds == pytest.approx(np.array([[0, 0], [0.1, 0.2]]), abs=1e-12)
    assert scene.prop("s").goal == TransformGoal(scale=(2, 1), rotation_deg=5.0)


def test_a_numeric_unit_is_metres(folder: Path) -> None:
    mesh = '[[prop]]\nname = "mug"\nmesh = "mug.stl"\nunit = {unit}\n'
    small, large = (read(folder, mesh.format(unit=u)).props[0] for u in (0.001, 0.004))
    assert large.surface.bounds == pytest.approx(4 * small.surface.bounds)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("tolerence = 1", "unknown key 'tolerence'. Known: dimension, objective, outer, prop,"),
        ("[objectives]", "unknown key 'objectives'. Did you mean 'objective'?"),
        (
            "[objective]\ntolerance = 1",
            "unknown key 'objective.tolerance'. Did you mean 'tolerance_mm'?",
        ),
        (PROP + "units = 'mm'", "unknown key 'prop[ball].units'. Did you mean 'unit'?"),
        ("[[prop]]\nnam = 'a'", "unknown key 'prop[#1].nam'. Did you mean 'name'?"),
        (PROP + "pose = { pos = [0, 0, 0] }", "unknown key 'prop[ball].pose.pos'."),
        (
            PROP + "[prop.goal]\nkind = 'transform'\nscales = 2",
            "prop[ball]: unknown key 'goal.scales'. Did you mean 'scale'?",
        ),
        (
            PROP + "[prop.goal]\nkind = 'transfrom'",
            "prop[ball]: goal.kind is 'transfrom'. Did you mean 'transform'?",
        ),
        (PROP + "[prop.goal]\nscale = 2", "goal.kind is missing; it is needed here"),
        (
            "[[prop]]\nname = 'a'\nshape = { kind = 'spher', radius = 1 }",
            "prop[a].shape.kind is 'spher'. Did you mean 'sphere'? Known: box, sphere,",
        ),
        (
            "[[prop]]\nname = 'a'\nshape = { kind = 'sphere', raduis = 1 }",
            "unknown key 'prop[a].shape.raduis'. Did you mean 'radius'?",
        ),
        (
            "[[prop]]\nname = 'a'\nshape = { kind = 'box' }",
            "prop[a].shape: 'size' is missing; a box needs it",
        ),
        ("[interaction]\nmode = 'slid'\n" + PROP, "interaction.mode is 'slid'. Did you mean"),
        (
            "[interaction]\ntracking = 'marker'\n" + PROP,
            "interaction.tracking is 'marker'. Did you mean 'markers'?",
        ),
        (
            "[interaction]\ntracking = { bias = 1 }\n" + PROP,
            "unknown key 'interaction.tracking.bias'. Did you mean 'bias_mm'?",
        ),
        (
            PROP + "[[fixed]]\nname = 't'\ncontact = 'glide'\n"
            "plane = { point = [0, 0, 0], normal = [0, 0, 1] }",
            "fixed[t].contact is 'glide'. Did you mean 'slide'?",
        ),
        (
            "[[prop]]\nname = 'mug'\nmesh = 'mug.stl'\nunit = 'inch'",
            "prop[mug].unit is 'inch'. Did you mean 'in'?",
        ),
        (
            "[[prop]]\nname = 'mug'\nmesh = 'mug.stl'\nunit = 'mm'\nup = 'Z'",
            "prop[mug].up is 'Z'. Did you mean 'z'?",
        ),
    ],
)
def test_unknown_keys_and_kinds_name_the_nearest(folder: Path, text: str, message: str) -> None:
    assert message in refusal(text, folder)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("dimension = '3'", "dimension is the text '3'; 2 or 3 is needed"),
        ("dimension = true", "dimension is true; 2 or 3 is needed"),
        ("objective = 3", "objective is the number 3; a table is needed"),
        ("prop = { name = 'a' }", "prop is a table; an array of tables is needed: write [[prop]]"),
        ("prop = [1]", "prop[#1] is the number 1; a table is needed"),
        (
            "[objective]\ntolerance_mm = 'fine'",
            "objective.tolerance_mm is the text 'fine'; a number is needed",
        ),
        ("[objective]\nlength_scale = true", "objective.length_scale is true; a number is needed"),
        ("[objective]\nmismatch_weight = nan", "objective.mismatch_weight is nan; a finite number"),
        ("[[prop]]\nname = 3\n", "prop[#1].name is the number 3; a text is needed"),
        (
            PROP + "pose = { position = [0, 0] }",
            "prop[ball].pose.position is a list of 2; a list of 3",
        ),
        (
            PROP + "pose = { rotation_deg = 90 }",
            "prop[ball].pose.rotation_deg is the number 90; a list of 3 numbers is needed",
        ),
        (
            PROP + "pose = { position = [0, 0, 'a'] }",
            "prop[ball].pose.position[2] is the text 'a'; a number is needed",
        ),
        (
            PROP + "[prop.goal]\nkind = 'transform'\nallow_mirror = 1",
            "goal.allow_mirror is the number 1; true or false is needed",
        ),
        (
            PROP + "[prop.goal]\nkind = 'transform'\nmatrix = [[1, 0, 0]]",
            "goal.matrix is a list of 1; 4 rows of 4 numbers is needed",
        ),
        (
            "dimension = 2\n[[prop]]\nname = 'a'\npolygon = 5",
            "prop[a].polygon is the number 5; a list of rows of 2 numbers is needed",
        ),
        (PROP + "[prop.goal]\nkind = 2026-01-01", "goal.kind is 2026-01-01 (date); a text is"),
    ],
)
def test_wrong_types_name_the_key_path(text: str, message: str) -> None:
    assert message in refusal(text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[objective]", "the scene has no props; add at least one [[prop]]"),
        (PROP + PROP, "the name 'ball' is used 2 times"),
        ("[[prop]]\nname = 'a'", "prop[a] has no surface; exactly one of mesh, shape, polygon"),
        (PROP + "mesh = 'a.stl'", "prop[ball] has mesh and shape; exactly one of"),
        (PROP + "unit = 'mm'", "prop[ball].unit goes with mesh only; a shape is in metres"),
        (
            "dimension = 2\n" + PROP,
            "prop[ball].shape does not fit a 2-D scene; polygon is needed there",
        ),
        (
            "[[prop]]\nname = 'a'\npolygon = [[0, 0], [1, 0], [0, 1]]",
            "prop[a].polygon does not fit a 3-D scene; mesh or shape is needed there",
        ),
        (
            "dimension = 2\n[[prop]]\nname = 'a'\npolygon = [[0, 0], [1, 0]]",
            "prop[a].polygon: a polygon has 2 corners",
        ),
        (
            "[objective]\nmismatch_weight = -1\n" + PROP,
            "objective.mismatch_weight is -1.0; a finite",
        ),
        (
            "[outer]\nbox_scale = 3\nbox = { min = [0, 0, 0], max = [1, 1, 1] }\n" + PROP,
            "outer has",
        ),
        ("[outer]\nbox = { min = [0, 0, 0] }\n" + PROP, "outer.box.max is missing"),
        (
            "[outer]\nbox = { min = [0, 1, 0], max = [1, -1, 1] }\n" + PROP,
            "outer.box is inverted: in y its min 1 is not below its max -1",
        ),
        (
            "[[prop]]\nname = 'a'\nmesh = 'mug.stk'\nunit = 'mm'",
            "prop[a]: mesh file mug.stk does not exist",
        ),
        (
            "[[prop]]\nname = 'a'\nmesh = { digest = 'abc', vertices = 8, faces = 12 }",
            "prop[a].mesh was given as arrays (SHA-256 abc), which no scene file holds",
        ),
    ],
)
def test_values_that_make_no_scene(text: str, message: str) -> None:
    assert message in refusal(text)


def test_a_singular_goal_names_the_prop() -> None:
    goal = PROP + "[prop.goal]\nkind = 'transform'\nscale = [1, 0, 1]"
    with pytest.raises(GoalError, match=r"prop\[ball\]: the goal is singular \(determinant 0\)"):
        parse_scene(goal)


def test_messages_begin_with_the_file(folder: Path) -> None:
    with pytest.raises(SceneError, match=r"^scene\.toml: unknown key 'objektive'\. Did you mean"):
        read(folder, "[objektive]")
    with pytest.raises(
        SceneError, match=r"^scene\.toml: prop\[mug\]: mug\.stl: the unit is missing"
    ):
        read(folder, '[[prop]]\nname = "mug"\nmesh = "mug.stl"')


def test_broken_toml_shows_the_line(folder: Path) -> None:
    with pytest.raises(SceneError, match=r"not valid TOML: .*at line 2.*: 'tolerance_mm = \.5'"):
        read(folder, "[objective]\ntolerance_mm = .5\n")
    with pytest.raises(SceneError, match=r"scene\.toml: not valid TOML: .*end of document.*\)\.$"):
        read(folder, 'name = """')


def test_files_that_cannot_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(SceneError, match=r"no.toml does not exist; check the name and folder"):
        load_scene(tmp_path / "no.toml")
    with pytest.raises(SceneError, match="is a folder; a scene file"):
        load_scene(tmp_path)
    path = tmp_path / "scene.toml"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(SceneError, match=r"scene.toml is not UTF-8 text"):
        load_scene(path)

    def deny(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "read_text", deny)
    with pytest.raises(SceneError, match=r"scene.toml cannot be read: Permission denied"):
        load_scene(path)
