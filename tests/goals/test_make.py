"""Goals come from specs by their kind, or ready-made as arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import pytest

from touchwarp.errors import GoalError
from touchwarp.goals import MAKERS, Goal, goals
from touchwarp.scene import AreaPreservingGoal, Prop, Scene
from touchwarp.scene.goal_spec import GOAL_SPECS
from touchwarp.scene.shapes import box, polygon, sphere
from touchwarp.scene.surface_reader import SurfaceReader
from touchwarp.scene.table import Table

CUBE = box((0.1, 0.1, 0.1))


def made(goal: Any) -> Goal:
    return goals(Scene([Prop("cube", CUBE, goal)]))["cube"]


def test_every_kind_that_a_scene_can_name_has_a_maker() -> None:
    assert set(MAKERS) == set(GOAL_SPECS)
    assert all(spec.kind == kind for kind, spec in GOAL_SPECS.items())


def test_a_ready_goal_is_taken_as_it_is() -> None:
    ready = Goal(CUBE.vertices, CUBE.vertices * 2, CUBE.faces, kind="vertices")
    assert made(ready) is ready


def test_a_goal_of_another_make_becomes_one() -> None:
    @dataclass
    class Foreign:
        prop_points: Any
        virtual_points: Any
        faces: Any

    goal = made(Foreign(CUBE.vertices, CUBE.vertices + 0.1, CUBE.faces))
    assert isinstance(goal, Goal)
    assert goal.kind == "arrays"
    assert goal.displacement == pytest.approx(0.1)


def test_a_ready_goal_must_lie_on_its_prop() -> None:
    in_mm = Goal(CUBE.vertices * 1e3, CUBE.vertices * 1e3, CUBE.faces)
    with pytest.raises(
        GoalError, match=r"prop 'cube': the goal's prop points span \(-50 -50 -50\)"
    ):
        made(in_mm)
    square = polygon([(0, 0), (1, 0), (1, 1)])
    flat = Goal(square.vertices, square.vertices, square.faces)
    with pytest.raises(GoalError, match="the goal's points have 2 coordinates; 3 are needed"):
        made(flat)


def test_a_remeshed_prop_is_accepted() -> None:
    middle = np.array([[0.05, 0, 0]])
    vertices = np.concatenate([CUBE.vertices, middle])
    faces = np.concatenate([CUBE.faces, [[4, 5, 8]]])
    assert made(Goal(vertices, vertices, faces)).prop_points.shape == (9, 3)


def test_a_kind_without_maker_is_told() -> None:
    class Wish:
        kind: ClassVar[str] = "transfrom"
        keys: ClassVar[tuple[str, ...]] = ()

        @classmethod
        def read(cls, table: Table, surfaces: SurfaceReader) -> Self:
            return cls()

        def entries(self) -> dict[str, Any]:
            return {}

    with pytest.raises(GoalError, match=r"unknown goal kind 'transfrom'. Did you mean 'transform'"):
        made(Wish())


def test_a_search_tells_how_far_it_is() -> None:
    told: list[tuple[str, float]] = []
    spec = AreaPreservingGoal(sphere(0.06, facet_mm=1.0), tolerance_mm=1.0)
    scene = Scene([Prop("cube", CUBE, spec)])
    goals(scene, lambda step, share: told.append((step, share)))
    assert len({step for step, _ in told}) > 1
    assert all(0 <= share <= 1 for _, share in told)
