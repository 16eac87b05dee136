"""The Shape Changing Texture Map: what is exported comes back as the goal that it was."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import Delaunay, cKDTree

from touchwarp.errors import GoalError
from touchwarp.export import paint_texture, shape_texture, write_goal, write_png
from touchwarp.export.atlas import _collapsed
from touchwarp.export.shape_texture import BEYOND, ShapeTexture, _paint
from touchwarp.goals import Goal, goals
from touchwarp.scene import DirectionGoal, Prop, Scene, parse_scene
from touchwarp.scene.shapes import box, polygon, sphere
from touchwarp.scene.texture_file import read_texture

CUBE = box((0.1, 0.08, 0.06))
PROP = '[[prop]]\nname = "cube"\nshape = { kind = "box", size = [0.1, 0.08, 0.06] }\n[prop.goal]\n'


@pytest.fixture(scope="module")
def goal() -> Goal:
    """A box felt as a ball."""
    spec = DirectionGoal(sphere(0.05, facet_mm=0.1), tolerance_mm=0.2)
    return goals(Scene([Prop("cube", CUBE, spec)]))["cube"]


def read_back(folder: Path, name: str, more: str = "") -> Goal:
    text = f'{PROP}kind = "texture"\ntexture = "{name}"\nuv_mesh = "goal.glb"\n{more}'
    return goals(parse_scene(text, folder))["cube"]


def difference(came: Goal, goal: Goal) -> float:
    """m: the greatest difference between the two maps at the goal's points."""
    distance, row = cKDTree(came.prop_points).query(goal.prop_points)
    assert distance.max() < 1e-7
    return float(np.linalg.norm(came.displacement[row] - goal.displacement, axis=1).max())


def test_an_exr_gives_the_goal_back_to_single_precision(goal: Goal, tmp_path: Path) -> None:
    facts = write_goal(tmp_path / "goal.exr", goal, "cube")
    came = read_back(tmp_path, "goal.exr")
    assert facts["texture_error"] < 1e-8
    assert difference(came, goal) < facts["texture_error"] + 1e-8  # of the atlas's own points
    assert came.kind == "texture"
    # Not at the points only: with no need to subdivide, the faces are the same as well.
    assert len(came.faces) == len(goal.faces)


def test_a_png_gives_the_goal_back_within_the_stated_error(goal: Goal, tmp_path: Path) -> None:
    facts = write_goal(tmp_path / "goal.png", goal, "cube")
    came = read_back(tmp_path, "goal.png")
    greatest = np.abs(goal.displacement).max()
    assert facts["step"] == pytest.approx(facts["scale"] / 32767)
    assert greatest <= facts["scale"] < 1.1 * greatest
    off = difference(came, goal)
    assert 0.1 * facts["step"] < off < facts["texture_error"] < 2 * facts["step"]


def test_the_round_trip_rejects_another_scale_axis_or_size(goal: Goal, tmp_path: Path) -> None:
    facts = write_goal(tmp_path / "goal.png", goal, "cube")
    wrong_scale = read_back(tmp_path, "goal.png", f"texture_scale = {1.01 * facts['scale']}")
    assert difference(wrong_scale, goal) > 5 * facts["texture_error"]
    with pytest.raises(GoalError, match="the atlas lies off the prop"):
        read_back(tmp_path, "goal.png", 'up = "z"')
    with pytest.raises(GoalError, match="the atlas lies off the prop"):
        read_back(tmp_path, "goal.png", 'unit = "cm"')


def test_a_pose_turns_atlas_and_displacement_alike(goal: Goal, tmp_path: Path) -> None:
    write_goal(tmp_path / "goal.exr", goal, "cube")
    pose = "pose = { position = [0.1, 0.2, 0.3], rotation_deg = [0, 0, 90] }\n"
    text = PROP.replace("[prop.goal]", pose + "[prop.goal]") + (
        f'kind = "texture"\ntexture = "goal.exr"\nuv_mesh = "goal.glb"\n{pose}'
    )
    scene = parse_scene(text, tmp_path)
    came = goals(scene)["cube"]
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    turned = [p @ turn.T + [0.1, 0.2, 0.3] for p in (goal.prop_points, goal.virtual_points)]
    assert difference(came, Goal(*turned, goal.faces)) < 1e-7


def test_the_texture_is_the_goal_between_its_points_too(goal: Goal) -> None:
    texture = paint_texture(goal, 1024)
    centres = texture.atlas.uv[texture.atlas.faces].mean(axis=1)
    height, width, _ = texture.displacement.shape
    column = np.rint(centres[:, 0] * width - 0.5).astype(int)
    row = np.rint((1 - centres[:, 1]) * height - 0.5).astype(int)
    rows = cKDTree(goal.prop_points).query(texture.atlas.vertices)[1]
    expected = goal.displacement[rows][texture.atlas.faces].mean(axis=1)
    # Half a texel off, in a field that changes by 0.3 at most and with texels of about 0.2 mm.
    assert np.abs(texture.displacement[row, column] - expected).max() < 1e-4


def test_charts_do_not_overlap(goal: Goal) -> None:
    atlas = paint_texture(goal).atlas
    assert atlas.uv.min() >= 0
    assert atlas.uv.max() <= 1
    a, b, c = (atlas.uv[atlas.faces[:, i]] for i in range(3))
    first, second = b - a, c - a
    flat_area = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]).sum() / 2
    assert flat_area < 1
    # Random places lie in one triangle at most.
    inside = np.zeros(400, dtype=int)
    for n, uv in enumerate(np.random.default_rng(0).uniform(0, 1, (400, 2))):
        sides = [(q - p)[:, 0] * (uv - p)[:, 1] - (q - p)[:, 1] * (uv - p)[:, 0]
                 for p, q in ((a, b), (b, c), (c, a))]  # fmt: skip
        inside[n] = (np.min(sides, axis=0) > 1e-12).sum() + (np.max(sides, axis=0) < -1e-12).sum()
    assert inside.max() == 1


def with_a_needle(goal: Goal) -> Goal:
    """The same map with the middle of one edge as a point of its own, on one side only.

    A face with no area closes the gap to the other side, as where layouts of two meshes meet.
    """
    a, b, c = goal.faces[0].tolist()
    p = len(goal.prop_points)
    faces = np.concatenate([goal.faces[1:], [(a, p, c), (p, b, c), (a, b, p)]])
    points, virtual = (
        np.concatenate([v, v[[a, b]].mean(axis=0, keepdims=True)])
        for v in (goal.prop_points, goal.virtual_points)
    )
    return Goal(points, virtual, faces)


def test_faces_with_no_area_have_a_place_too(
    goal: Goal, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    needled = with_a_needle(goal)
    facts = write_goal(tmp_path / "goal.exr", needled, "cube")
    assert facts["texture_error"] < 1e-8
    assert difference(read_back(tmp_path, "goal.exr"), needled) < 2e-8
    # as the unwrapper leaves it, the needle's corners lie where nothing is painted
    monkeypatch.setattr(
        "touchwarp.export.atlas.with_needles",
        lambda points, rows, faces, uv, dropped: (rows, faces, uv),
    )
    assert paint_texture(needled).error > 1e-3


def with_a_crowd(goal: Goal) -> Goal:
    """The same map with twenty points strewn over a spot of one face, 0.01 mm out of its plane."""
    rng = np.random.default_rng(0)
    corners = goal.faces[0]
    places = np.r_[np.eye(3), rng.dirichlet([1, 1, 1], 20) * 0.02 + 0.98 / 3]
    faces = Delaunay(places[:, :2]).simplices
    one, two = (places[faces[:, i]] - places[faces[:, 0]] for i in (1, 2))
    turned = one[:, 0] * two[:, 1] < one[:, 1] * two[:, 0]
    faces[turned] = faces[turned][:, ::-1]
    points, virtual = (places @ v[corners] for v in (goal.prop_points, goal.virtual_points))
    virtual[3:] += rng.normal(scale=1e-5, size=(20, 3))
    rows = np.r_[corners, len(goal.prop_points) + np.arange(20)]
    return Goal(
        np.concatenate([goal.prop_points, points[3:]]),
        np.concatenate([goal.virtual_points, virtual[3:]]),
        np.concatenate([goal.faces[1:], rows[faces]]),
    )


def test_points_that_crowd_a_texel_do_not_throw_it_off_between_them(
    goal: Goal, monkeypatch: pytest.MonkeyPatch
) -> None:
    crowded = with_a_crowd(goal)
    texture = paint_texture(crowded, 256)
    assert texture.error < 4e-5
    assert texture.error_between < 8e-5
    # exact at each point as far as single texels can be
    monkeypatch.setattr(shape_texture, "CROWDED", shape_texture.ALONE)
    assert paint_texture(crowded, 256).error_between > 1e-3


def test_a_needle_on_a_border_paints_no_greater_values_than_a_triangle_does() -> None:
    # a thousandth of a texel high: two texels beyond it its slope would have come to 2000
    needle = np.array([[10.0, 10.0], [20.0, 10.0], [15.0, 9.999]])
    image, depth = np.zeros((30, 30, 3)), np.full((30, 30), -np.inf)
    _paint(needle, np.array([[0, 1, 2]]), np.array([[0.0] * 3, [0.0] * 3, [1.0] * 3]), image, depth)
    assert (np.isfinite(depth)).sum() > 40
    assert np.abs(image).max() < 1 + 2 * BEYOND + 1e-9
    # a triangle that is no needle is carried on by its own slope
    plain = np.array([[10.0, 10.0], [20.0, 10.0], [15.0, 20.0]])
    image, depth = np.zeros((30, 30, 3)), np.full((30, 30), -np.inf)
    _paint(plain, np.array([[0, 1, 2]]), 0.1 * plain[:, [1, 1, 1]], image, depth)
    assert image[9, 15] == pytest.approx([0.9] * 3, abs=1e-12)


def test_a_face_whose_corners_share_a_texel_is_known() -> None:
    corners = (
        np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]] * 4) * np.array([1, 2, 3, 1e-3])[:, None, None]
    )
    places = corners[:, :, :2] * 7.0
    assert not _collapsed(corners, places).any()
    places[3] = places[3, 0]
    assert _collapsed(corners, places).tolist() == [False, False, False, True]


def test_a_face_that_is_laid_on_a_line_has_no_room() -> None:
    """No texel is in it, and others are packed upon it."""
    corners = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]] * 2, dtype=float)
    places = 9.0 * corners[:, :, :2]
    places[1, 2] = [4.0, 1e-3]
    assert _collapsed(corners, places).tolist() == [False, True]
    places[1, 2] = [4.0, 1e-2]
    assert not _collapsed(corners, places).any()


def test_a_size_can_be_asked_for(goal: Goal) -> None:
    small, large = (paint_texture(goal, size).displacement.shape for size in (300, 600))
    assert 0.4 < (small[0] * small[1]) / 300**2 < 2
    assert large[0] > 1.5 * small[0]
    assert isinstance(paint_texture(goal, 300), ShapeTexture)


def test_what_cannot_be_a_texture_is_told(goal: Goal, tmp_path: Path) -> None:
    with pytest.raises(GoalError, match="the texture's size is 8 texels; 16 to 8192 is needed"):
        paint_texture(goal, 8)
    square = polygon([(0, 0), (1, 0), (1, 1)])
    flat = Goal(square.vertices, square.vertices, square.faces)
    with pytest.raises(GoalError, match="a texture lays surfaces flat, but the goal is of a plane"):
        paint_texture(flat)
    with pytest.raises(GoalError, match=r"displaces by up to 20 mm along an axis, more than .* 10"):
        write_png(tmp_path / "a.png", np.full((2, 2, 3), 0.02, dtype=np.float32), scale=0.01)
    assert not (tmp_path / "a.png").exists()


def test_a_png_tells_its_scale_itself(tmp_path: Path) -> None:
    image = np.array([[[0.0, 0.001, -0.002]]], dtype=np.float32)
    step = write_png(tmp_path / "a.png", image, scale=0.01)
    assert step == pytest.approx(0.01 / 32767)
    np.testing.assert_allclose(read_texture(tmp_path / "a.png"), image, atol=step / 2)
    assert read_texture(tmp_path / "a.png")[0, 0, 0] == 0.0
    still = np.zeros((2, 2, 3), dtype=np.float32)
    write_png(tmp_path / "still.png", still)
    np.testing.assert_array_equal(read_texture(tmp_path / "still.png"), still)
