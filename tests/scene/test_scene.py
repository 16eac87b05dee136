"""Scenes built in code are checked like those from files, and can be written as text."""

from __future__ import annotations

import dataclasses
import math
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from touchwarp.errors import SceneError
from touchwarp.goals import Goal
from touchwarp.scene import (
    Fixed,
    Interaction,
    Objective,
    Outer,
    Prop,
    Scene,
    Surface,
    Tracking,
    TransformGoal,
    describe,
    parse_scene,
)
from touchwarp.scene.scene import surface_digest
from touchwarp.scene.shapes import box, polygon, sphere

BALL = Prop("ball", sphere(0.03), TransformGoal(scale=1.5))
TABLE = Fixed("table", plane=((0, 0, -0.03), (0, 0, 3)))


def test_a_scene_is_built_from_its_parts() -> None:
    scene = Scene([BALL], fixed=[TABLE])
    assert scene.props == (BALL,)
    assert scene.slide_plane is TABLE
    assert scene.outer.box_scale == 4.0
    assert scene.prop("ball") is BALL


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("mismatch_weight", -1.0, "objective.mismatch_weight is -1.0; a finite number ≥ 0"),
        ("mismatch_weight", math.nan, "objective.mismatch_weight is nan; a finite number ≥ 0"),
        ("mismatch_weight", math.inf, "objective.mismatch_weight is inf"),
        ("mismatch_weight", "1", "objective.mismatch_weight is '1'"),
        ("length_scale", 0.0, "objective.length_scale is 0.0; a finite length in m > 0"),
        ("tolerance_mm", 0.0, "objective.tolerance_mm is 0.0; a finite length in mm > 0"),
        ("tolerance_mm", -0.1, "objective.tolerance_mm is -0.1"),
        ("tolerance_mm", True, "objective.tolerance_mm is True"),
        ("edge_radius_mm", -1.0, "objective.edge_radius_mm is -1.0; a finite length in mm ≥ 0"),
    ],
)
def test_objectives_out_of_range(key: str, value: Any, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        Objective(**{key: value})
    with pytest.raises(SceneError, match=message):
        Scene([BALL]).with_objective(**{key: value})


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"box_scale": 3.0, "box": [[0, 0, 0], [1, 1, 1]]}, "outer has box_scale and box; give"),
        ({"box_scale": 1.0}, "outer.box_scale is 1.0; a finite number > 1 is needed"),
        ({"box_scale": math.nan}, "outer.box_scale is nan"),
        ({"box": [[0, 0, 0], [1, 1, 0]]}, "outer.box is inverted: in z its min 0 is not below"),
        ({"box": [[0, 0], [1, 1], [2, 2]]}, r"outer.box has shape \(3, 2\)"),
        ({"box": [[0, 0, 0], [1, 1, math.inf]]}, "a finite least and greatest corner"),
        (
            {"surface": Surface(box((1, 1, 1)).vertices, box((1, 1, 1)).faces[1:])},
            "the outer surface is not closed: 3 of its edges have an odd number of faces",
        ),
    ],
)
def test_outer_boundaries_that_are_none(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        Outer(**arguments)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "fixed surface 'f' has neither a plane nor a surface; give exactly one"),
        ({"plane": ((0, 0, 0), (0, 0, 1)), "surface": box((1, 1, 1))}, "'f' has both; give"),
        ({"surface": box((1, 1, 1)), "contact": "slide"}, "a mesh can only 'hold'"),
        ({"plane": ((0, 0, 0), (0, 0, 1)), "contact": "glue"}, "has the contact 'glue'. Known: sl"),
        ({"plane": ((0, 0, 0), (0, 0, 1)), "blend_mm": -1}, "has blend_mm -1; a finite length"),
        (
            {"plane": ((0, 0, 0), (0, 0, 0))},
            "a finite point and a normal of some length are needed",
        ),
        ({"plane": ((0, 0, math.nan), (0, 0, 1))}, "a finite point and a normal of some length"),
        ({"plane": ((0, 0, 0), (0, 1))}, r"a point of shape \(3,\) and a normal of shape \(2,\)"),
        (
            {"name": " ", "plane": ((0, 0, 0), (0, 0, 1))},
            "a fixed surface has the name ' '; a text",
        ),
    ],
)
def test_fixed_surfaces_that_are_none(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        Fixed(**{"name": "f", **arguments})


def test_contact_defaults_to_what_the_surface_can_do() -> None:
    assert TABLE.contact == "slide"
    assert Fixed("wall", surface=box((1, 1, 1))).contact == "hold"


def test_at_most_one_plane_slides() -> None:
    wall = Fixed("wall", plane=((-1, 0, 0), (1, 0, 0)))
    with pytest.raises(SceneError, match=r"2 planes slide \(table, wall\); at most one can"):
        Scene([BALL], fixed=[TABLE, wall])
    assert Scene([BALL], fixed=[TABLE, dataclasses.replace(wall, contact="hold")]).slide_plane


def test_scenes_that_are_none() -> None:
    with pytest.raises(SceneError, match="the scene has no props"):
        Scene([])
    with pytest.raises(SceneError, match="the name 'ball' is used 2 times"):
        Scene([BALL, BALL])
    with pytest.raises(SceneError, match="the name 'ball' is used 2 times"):
        Scene([BALL], fixed=[dataclasses.replace(TABLE, name="ball")])
    with pytest.raises(SceneError, match="dimension is 4; 2 or 3 is needed"):
        Scene([BALL], dimension=4)
    with pytest.raises(SceneError, match="prop 'ball' is 3-D in a 2-D scene; give it 2 coord"):
        Scene([BALL], dimension=2)
    flat = Prop("flat", polygon([(0, 0), (1, 0), (0, 1)]))
    with pytest.raises(SceneError, match="outer is 3-D in a 2-D scene"):
        Scene([flat], outer=Outer(box=[[0, 0, 0], [1, 1, 1]]), dimension=2)
    with pytest.raises(SceneError, match="fixed surface 'table' is 3-D in a 2-D scene"):
        Scene([flat], fixed=[TABLE], dimension=2)
    with pytest.raises(SceneError, match=r"no prop is named 'bal'. Did you mean 'ball'?"):
        Scene([BALL]).prop("bal")


def test_props_that_are_none() -> None:
    with pytest.raises(SceneError, match="a prop has the name ''; a text that is not empty"):
        Prop("", BALL.surface)
    with pytest.raises(SceneError, match="prop 'a': its surface is a str; a Surface"):
        Prop("a", "mug.stl")  # type: ignore[arg-type]
    with pytest.raises(SceneError, match="prop 'a': its goal is a dict; a TransformGoal"):
        Prop("a", BALL.surface, {"scale": 2})  # type: ignore[arg-type]


def test_interactions_that_are_none() -> None:
    with pytest.raises(SceneError, match=r"interaction.mode is 'hold'. Known: tap, slide"):
        Interaction("hold")
    with pytest.raises(
        SceneError, match=r"interaction.tracking is 'marker'. Did you mean 'markers'"
    ):
        Interaction(tracking="marker")
    with pytest.raises(
        SceneError, match=r"interaction.tracking is 3; a Tracking or one of markers"
    ):
        Interaction(tracking=3)  # type: ignore[arg-type]
    with pytest.raises(
        SceneError, match=r"interaction.tracking.noise_mm is -1; a finite number ≥ 0"
    ):
        Tracking(noise_mm=-1)


def test_the_text_of_a_built_scene_reads_back(tmp_path: Path) -> None:
    text = (
        '[outer]\nbox = { min = [-1, -1, -1], max = [1, 1, 1] }\n[[prop]]\nname = "a \\"b\\""\n'
        'shape = { kind = "sphere", radius = 0.1 }\npose = { position = [0, 0, 0.2] }\n'
        '[prop.goal]\nkind = "transform"\nscale = [1, 2, 3]\npivot = [0, 0, 1]\n'
        '[[fixed]]\nname = "t"\nplane = { point = [0, 0, 0], normal = [0, 0, 1] }\n'
        "[interaction]\ntracking = { bias_mm = 2 }\n"
    )
    scene = parse_scene(text, tmp_path)
    assert scene.text == text
    changed = scene.with_objective(mismatch_weight=2.5)
    assert changed.text != text
    again = parse_scene(changed.text, tmp_path)
    assert again.objective == changed.objective
    assert again.props[0].goal == scene.props[0].goal
    assert again.digests == scene.digests
    assert np.array_equal(again.outer.box, scene.outer.box)  # type: ignore[arg-type]
    assert again.interaction == scene.interaction
    assert again.text == changed.text
    assert scene.fixed[0].plane is not None
    assert np.array_equal(again.fixed[0].plane, scene.fixed[0].plane)  # type: ignore[arg-type]


def test_the_text_of_a_plane_scene_reads_back(tmp_path: Path) -> None:
    text = (
        "dimension = 2\n[outer]\nbox_scale = 3\n[[prop]]\nname = 'a'\n"
        "polygon = [[0, 0], [1, 0], [0, 1]]\n[prop.goal]\nkind = 'transform'\n"
        "matrix = [[1, 0, 0.1], [0, 2, 0], [0, 0, 1]]\n"
    )
    scene = parse_scene(text, tmp_path).with_objective(tolerance_mm=1.0)
    again = parse_scene(scene.text, tmp_path)
    assert again.dimension == 2
    assert again.outer.box_scale == 3.0
    assert again.props[0].goal == scene.props[0].goal


def test_surfaces_given_as_arrays_are_told_by_digest() -> None:
    goal = Goal(BALL.surface.vertices, BALL.surface.vertices * 2, BALL.surface.faces)
    outer = Outer(surface=sphere(0.2))
    entries = tomllib.loads(Scene([Prop("ball", BALL.surface, goal)], outer).text)
    assert entries["prop"][0]["mesh"] == {
        "digest": BALL.digest,
        "vertices": len(BALL.surface.vertices),
        "faces": len(BALL.surface.faces),
    }
    assert entries["prop"][0]["goal"]["kind"] == "arrays"
    assert entries["prop"][0]["goal"]["prop_digest"] == BALL.digest
    assert entries["outer"]["mesh"]["digest"] == surface_digest(sphere(0.2))


def test_control_characters_in_names_are_escaped() -> None:
    scene = Scene([dataclasses.replace(BALL, name="a\\b\tc\n")], outer=Outer(box_scale=2))
    assert tomllib.loads(scene.text)["prop"][0]["name"] == "a\\b\tc\n"


def test_digests_tell_surfaces_apart_but_not_rounding() -> None:
    rounded = Surface(BALL.surface.vertices * (1 + 1e-15), BALL.surface.faces)
    moved = Surface(BALL.surface.vertices + 1e-6, BALL.surface.faces)
    turned = Surface(BALL.surface.vertices, BALL.surface.faces[:, ::-1])
    assert surface_digest(rounded) == BALL.digest
    assert BALL.digest not in (surface_digest(moved), surface_digest(turned))


def test_goals_can_be_exchanged() -> None:
    scene = Scene([BALL])
    moved = scene.with_goals({"ball": TransformGoal(translation=(0.1, 0, 0))})
    assert moved.props[0].goal == TransformGoal(translation=(0.1, 0, 0))
    assert moved.props[0].surface is BALL.surface
    with pytest.raises(SceneError, match=r"no prop is named 'bell'. Did you mean 'ball'?"):
        scene.with_goals({"bell": TransformGoal()})


def test_describing_a_scene() -> None:
    wall = Fixed("wall", surface=box((0.01, 1, 1)))
    rows = dict(describe(Scene([BALL], fixed=[TABLE, wall]).with_objective(mismatch_weight=2)))
    assert rows["mismatch weight λ"] == "2 (λ/L² = 200 1/m²)"
    assert rows["prop ball"].startswith("60 × 60 × 60 mm, ") or "59.9" in rows["prop ball"]
    assert rows["prop ball"].endswith("from arrays, goal transform")
    assert rows["fixed table"] == "plane, slide, blended over 10 mm"
    assert rows["fixed wall"].startswith("surface of 10 × 1000 × 1000 mm, 12 triangles, hold")
    assert rows["outer boundary"].startswith("cube, 4 × the longest side")
    boxed = Scene([BALL], outer=Outer(box=[[0, 0, 0], [1, 2, 3]]))
    assert dict(describe(boxed))["outer boundary"] == "box of 1000 × 2000 × 3000 mm"
    round_room = Scene([BALL], outer=Outer(surface=box((1, 1, 1))))
    assert dict(describe(round_room))["outer boundary"].startswith("surface of 1000 × 1000")
    plane = "dimension = 2\n[[prop]]\nname = 'flat'\npolygon = [[0, 0], [1, 0], [0, 1]]\n"
    rows = dict(describe(parse_scene(plane)))
    assert rows["prop flat"] == "1000 × 1000 mm, 3 segments, from polygon, goal transform"
    assert rows["outer boundary"].startswith("square, 4 × the longest side")


def test_the_rooms_load_no_heavy_library_before_it_is_needed() -> None:
    script = (
        "import sys, touchwarp.scene, touchwarp.goals; "
        "print(sorted({'trimesh', 'scipy', 'fcl', 'manifold3d', 'numba'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], check=True, capture_output=True, text=True
    )
    assert done.stdout.strip() == "[]"
