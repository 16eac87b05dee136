"""Transform goals against the formula of the scene file, worked out by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from touchwarp.errors import GoalError
from touchwarp.goals import goals
from touchwarp.scene import Prop, Scene, TransformGoal, pose_matrix
from touchwarp.scene.shapes import box, cylinder, polygon

# Least corner (0.1, 0, 0), greatest (0.3, 0.2, 0.4).
BOX = box((0.2, 0.2, 0.4)).transformed(pose_matrix((0.2, 0.1, 0.2), (0, 0, 0)))
CORNER = np.array([0.3, 0.2, 0.4])


def image(spec: TransformGoal, point: np.ndarray = CORNER) -> np.ndarray:
    """Where the goal sends a vertex of the box."""
    goal = goals(Scene([Prop("box", BOX, spec)]))["box"]
    row = np.flatnonzero((np.abs(goal.prop_points - point) < 1e-12).all(axis=1))[0]
    return goal.virtual_points[row]


@pytest.mark.parametrize(
    ("spec", "expected"),
    [
        (TransformGoal(), (0.3, 0.2, 0.4)),
        (TransformGoal(scale=2.0), (0.4, 0.3, 0.8)),
        (TransformGoal(pivot="base", scale=(1, 1, 0.5)), (0.3, 0.2, 0.2)),
        (TransformGoal(pivot="centre", scale=(1, 1, 0.5)), (0.3, 0.2, 0.3)),
        (TransformGoal(pivot=(0, 0, 0), scale=(2, 1, 1)), (0.6, 0.2, 0.4)),
        (TransformGoal(translation=(0.01, 0.02, 0.03)), (0.31, 0.22, 0.43)),
        # About z by 90° round the base (0.2, 0.1): (0.1, 0.1) turns to (−0.1, 0.1).
        (TransformGoal(rotation_deg=(0, 0, 90)), (0.1, 0.2, 0.4)),
        # R·S: the stretch is along the axes before the turn.
        (TransformGoal(scale=(2, 1, 1), rotation_deg=(0, 0, 90)), (0.1, 0.3, 0.4)),
        # R = Rz·Ry·Rx: x first. (0.1, 0.1, 0.4) → (0.1, −0.4, 0.1) → (0.4, 0.1, 0.1), then + base.
        (TransformGoal(rotation_deg=(90, 0, 90)), (0.6, 0.2, 0.1)),
        (
            TransformGoal(matrix=((1, 0, 0, 0.5), (0, 1, 0, 0), (0, 0, 2, 0), (0, 0, 0, 1))),
            (0.8, 0.2, 0.8),
        ),
        (TransformGoal(pivot="centre", scale=(-1, 1, 1), allow_mirror=True), (0.1, 0.2, 0.4)),
    ],
)
def test_a_corner_goes_where_the_formula_says(
    spec: TransformGoal, expected: tuple[float, ...]
) -> None:
    assert image(spec) == pytest.approx(expected, abs=1e-12)


def test_the_formula_rejects_the_order_s_times_r() -> None:
    # S·R instead of R·S would give (0.0, 0.2, 0.4).
    assert image(TransformGoal(scale=(2, 1, 1), rotation_deg=(0, 0, 90))) != pytest.approx(
        (0.0, 0.2, 0.4), abs=1e-3
    )


@given(
    hnp.arrays(np.float64, 3, elements=st.floats(-180, 180)),
    hnp.arrays(np.float64, 3, elements=st.floats(0.2, 3)),
    hnp.arrays(np.float64, 3, elements=st.floats(-0.1, 0.1)),
)
def test_the_matrix_is_the_map(angles: np.ndarray, scale: np.ndarray, shift: np.ndarray) -> None:
    prop = Prop("can", cylinder(0.03, 0.1, 1.0), TransformGoal("base", scale, angles, shift))
    goal = goals(Scene([prop]))["can"]
    assert goal.matrix is not None
    mapped = goal.prop_points @ goal.matrix[:3, :3].T + goal.matrix[:3, 3]
    assert np.allclose(mapped, goal.virtual_points, atol=1e-14)
    assert np.linalg.det(goal.matrix) == pytest.approx(scale.prod())
    # The base is a cylinder's foot, so it moves by the translation alone.
    assert goal.matrix @ [0, 0, 0, 1] == pytest.approx([*shift, 1], abs=1e-12)
    again = goals(Scene([Prop("can", prop.surface, TransformGoal(matrix=goal.matrix))]))["can"]
    assert np.allclose(again.virtual_points, goal.virtual_points, atol=1e-14)


def test_a_goal_in_the_plane() -> None:
    triangle = polygon([(0, 0), (0.2, 0), (0.1, 0.3)])
    spec = TransformGoal(scale=(2, 1), rotation_deg=90.0, translation=(0, 0.1))
    goal = goals(Scene([Prop("t", triangle, spec)], dimension=2))["t"]
    # Base (0.1, 0): the tip (0, 0.3) from it turns to (−0.3, 0), a foot (0.1, 0) to (0, 0.2).
    expected = [[0.1, -0.1], [0.1, 0.3], [-0.2, 0.1]]
    assert goal.virtual_points == pytest.approx(np.array(expected), abs=1e-12)
    assert goal.matrix is not None
    assert goal.matrix.shape == (3, 3)


def test_the_goal_keeps_the_prop_s_faces_and_kind() -> None:
    goal = goals(Scene([Prop("box", BOX, TransformGoal(scale=2))]))["box"]
    assert goal.kind == "transform"
    assert np.array_equal(goal.faces, BOX.faces)
    assert np.array_equal(goal.prop_points, BOX.vertices)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"scale": (1, 0, 1)}, r"the goal is singular \(determinant 0\)"),
        ({"scale": 0}, "the goal is singular"),
        ({"scale": (1, 1, 1e-7)}, r"the goal is singular \(determinant 1e-07\)"),
        ({"matrix": np.diag([1.0, 1, 0, 1])}, "the goal is singular"),
        ({"scale": (-1, 1, 1)}, r"the goal mirrors the prop \(determinant -1\)"),
        ({"matrix": np.diag([1.0, -2, 1, 1])}, r"the goal mirrors the prop \(determinant -2\)"),
        ({"pivot": "center"}, r"goal.pivot is 'center'. Did you mean 'centre'?"),
        ({"pivot": "top"}, "goal.pivot is 'top'. Known: centre, base"),
        ({"scale": (1, float("nan"), 1)}, "goal.scale is .*; finite numbers are needed"),
        ({"translation": ("a", 0, 0)}, "goal.translation is .*; numbers are needed"),
        ({"scale": 2, "matrix": np.eye(4)}, r"goal.matrix stands beside goal.scale; give either"),
        ({"pivot": "centre", "matrix": np.eye(4)}, r"goal.matrix stands beside goal.pivot"),
        ({"matrix": np.eye(5)}, r"goal.matrix has shape \(5, 5\)"),
        ({"matrix": np.ones((4, 4))}, "goal.matrix has the last row"),
    ],
)
def test_maps_that_are_no_goal(values: dict[str, Any], message: str) -> None:
    with pytest.raises(GoalError, match=message):
        TransformGoal(**values)


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        (TransformGoal(scale=(1, 2)), r"goal.scale is \(1.0, 2.0\); 3 numbers are needed"),
        (TransformGoal(translation=(1, 2)), "goal.translation is .*; 3 numbers are needed"),
        (TransformGoal(pivot=(1, 2)), "goal.pivot is .*; 3 numbers are needed"),
        (TransformGoal(rotation_deg=90), "goal.rotation_deg is 90.0; three angles is needed"),
        (TransformGoal(matrix=np.eye(3)), r"goal.matrix has shape \(3, 3\); \(4, 4\) is needed"),
    ],
)
def test_numbers_of_another_dimension_name_the_prop(spec: TransformGoal, message: str) -> None:
    with pytest.raises(GoalError, match="prop 'box': " + message):
        goals(Scene([Prop("box", BOX, spec)]))
