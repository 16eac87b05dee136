"""Vertex i shows at vertex i, exactly, or the meshes are told apart."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from touchwarp.errors import GoalError
from touchwarp.goals import Goal, goals
from touchwarp.scene import Prop, Scene, Surface, VerticesGoal, load_scene
from touchwarp.scene.shapes import box, make_shape

MUG = make_shape("mug", {})
BENT = Surface(MUG.vertices + 0.01 * np.sin(40 * MUG.vertices[:, [1, 2, 0]]), MUG.faces)


def made(prop: Surface, virtual: Surface) -> Goal:
    return goals(Scene([Prop("mug", prop, VerticesGoal(virtual))]))["mug"]


def test_vertices_go_to_vertices() -> None:
    goal = made(MUG, BENT)
    np.testing.assert_array_equal(goal.prop_points, MUG.vertices)
    np.testing.assert_array_equal(goal.virtual_points, BENT.vertices)
    np.testing.assert_array_equal(goal.faces, MUG.faces)
    assert (goal.kind, goal.virtual_surface) == ("vertices", BENT)


def test_faces_may_be_listed_and_turned_otherwise() -> None:
    shuffled = Surface(BENT.vertices, np.roll(BENT.faces[::-1], 1, axis=1))
    np.testing.assert_array_equal(made(MUG, shuffled).virtual_points, BENT.vertices)


def test_it_works_from_files(tmp_path: Path) -> None:
    for name, surface in (("mug.obj", MUG), ("bent.obj", BENT)):
        lines = ["v {!r} {!r} {!r}".format(*v) for v in (surface.vertices * 1e3).tolist()]
        lines += ["f {} {} {}".format(*f) for f in (surface.faces + 1).tolist()]
        (tmp_path / name).write_text("\n".join(lines) + "\n")
    (tmp_path / "scene.toml").write_text(
        '[[prop]]\nname = "mug"\nmesh = "mug.obj"\nunit = "mm"\n'
        '[prop.goal]\nkind = "vertices"\nvirtual_mesh = "bent.obj"\nunit = "mm"\n'
    )
    goal = goals(load_scene(tmp_path / "scene.toml"))["mug"]
    np.testing.assert_allclose(goal.displacement, BENT.vertices - MUG.vertices, atol=1e-15)


def test_other_meshes_are_refused() -> None:
    with pytest.raises(
        GoalError, match=r"prop 'mug': the prop has [\d,]+ vertices and the virtual object 8 \(eq"
    ):
        made(MUG, box((0.1, 0.1, 0.1)))
    with pytest.raises(GoalError, match="faces and the virtual object"):
        made(MUG, Surface(MUG.vertices, MUG.faces[1:]))
    shuffled = np.random.default_rng(0).permutation(len(MUG.vertices))
    with pytest.raises(GoalError, match="faces join other vertices in the virtual object, face 1"):
        made(MUG, Surface(MUG.vertices, shuffled[MUG.faces]))
