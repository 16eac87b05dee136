"""What does not fit together is refused; what merely stands close is not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from touchwarp.errors import SceneError
from touchwarp.goals import goals, outer_box, validate
from touchwarp.scene import Fixed, Outer, Prop, Scene, Surface, TransformGoal, pose_matrix
from touchwarp.scene.shapes import box, make_shape, polygon, sphere

ROOM = Outer(box=[[-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]])
ROUND_ROOM = Outer(surface=sphere(0.5, 1.0))
IDENTITY = TransformGoal()


def cube(x: float = 0.0, z: float = 0.0, side: float = 0.1) -> Surface:
    return box((side,) * 3).transformed(pose_matrix((x, 0, z), (0, 0, 0)))


def accept(scene: Scene) -> None:
    validate(scene, goals(scene))


def refusal(scene: Scene) -> str:
    with pytest.raises(SceneError) as error:
        validate(scene, goals(scene))
    return str(error.value)


def one(
    surface: Surface,
    goal: TransformGoal = IDENTITY,
    outer: Outer = ROOM,
    fixed: Sequence[Fixed] = (),
) -> Scene:
    return Scene([Prop("cube", surface, goal)], outer, fixed=fixed)


def table(height: float, contact: str = "slide", up: float = 1.0) -> list[Fixed]:
    return [Fixed("table", plane=((0, 0, height), (0, 0, up)), contact=contact)]


def test_the_outer_cube_surrounds_props_and_virtual_objects() -> None:
    goal = TransformGoal(pivot="centre", scale=(3, 1, 1), translation=(0.1, 0, 0))
    scene = one(cube(), goal, Outer(box_scale=2))
    # Virtual x from −0.05 to 0.25, so the longest side is 0.3 m around x = 0.1.
    expected = [[-0.2, -0.3, -0.3], [0.4, 0.3, 0.3]]
    assert outer_box(scene, goals(scene)) == pytest.approx(np.array(expected))
    alone = one(cube(), outer=Outer(box_scale=2))
    assert outer_box(alone, goals(alone)) == pytest.approx(np.array([[-0.1] * 3, [0.1] * 3]))


def test_the_outer_box_of_boxes_and_surfaces() -> None:
    scene = one(cube())
    assert np.array_equal(outer_box(scene, goals(scene)), ROOM.box)  # type: ignore[arg-type]
    scene = one(cube(), outer=ROUND_ROOM)
    assert outer_box(scene, goals(scene)) == pytest.approx(
        np.array([[-0.5] * 3, [0.5] * 3]), abs=2e-3
    )


def test_the_outer_box_in_the_plane() -> None:
    flat = Prop("flat", polygon([(0, 0), (0.2, 0), (0.2, 0.1)]))
    scene = Scene([flat], dimension=2)
    assert outer_box(scene, goals(scene)) == pytest.approx(np.array([[-0.3, -0.35], [0.5, 0.45]]))
    accept(scene)


@pytest.mark.parametrize(
    ("x", "message"),
    [
        (0.45, "prop 'cube' must lie inside the outer boundary, but touches it in +x"),
        (-0.45, "touches it in -x"),
        (0.46, "prop 'cube' must lie inside the outer boundary, but reaches 10 mm beyond it in +x"),
        (2.0, "reaches 1550 mm beyond it in +x"),
    ],
)
def test_a_prop_at_or_beyond_the_outer_box(x: float, message: str) -> None:
    assert message in refusal(one(cube(x)))
    accept(one(cube(np.sign(x) * 0.4499)))


def test_a_virtual_object_beyond_the_outer_box() -> None:
    message = refusal(one(cube(), TransformGoal(translation=(0, 0, -0.46))))
    assert "the virtual object of prop 'cube' must lie inside the outer boundary" in message
    assert "reaches 10 mm beyond it in -z" in message
    accept(one(cube(), TransformGoal(translation=(0, 0, -0.45))))


def test_a_prop_at_or_beyond_an_outer_surface() -> None:
    assert "prop 'cube' touches or crosses the outer surface" in refusal(
        one(cube(0.446), outer=ROUND_ROOM)
    )
    corner = box((0.05,) * 3).transformed(pose_matrix((0.4, 0.4, 0.4), (0, 0, 0)))
    assert "prop 'cube' lies outside the outer surface" in refusal(one(corner, outer=ROUND_ROOM))
    assert "the virtual object of prop 'cube' touches or crosses" in refusal(
        one(cube(), TransformGoal(translation=(0.446, 0, 0)), ROUND_ROOM)
    )
    accept(one(cube(0.4), outer=ROUND_ROOM))


def test_one_body_outside_is_found() -> None:
    far = cube().vertices + 0.4
    two = Surface(
        np.concatenate([cube().vertices, far * 0.99]),
        np.concatenate([cube().faces, cube().faces + 8]),
    )
    assert "wholly or with one of its bodies" in refusal(one(two, outer=ROUND_ROOM))


@pytest.mark.parametrize("depth", [0.0, 0.9e-4, -0.01])
def test_props_may_stand_on_a_plane(depth: float) -> None:
    accept(one(cube(), fixed=table(-0.05 + depth)))
    accept(one(cube(), fixed=table(-0.05 + depth, "hold")))


def test_a_plane_that_cuts_a_prop() -> None:
    message = refusal(one(cube(), fixed=table(-0.05 + 2e-4)))
    assert "the plane 'table' cuts through prop 'cube', which reaches 0.2 mm behind it" in message
    assert "cuts through prop" in refusal(one(cube(), fixed=table(0.0, "hold")))


def test_a_sliding_plane_has_props_on_one_side() -> None:
    message = refusal(one(cube(), fixed=table(0.05)))
    assert "prop 'cube' lies behind the sliding plane 'table'" in message
    accept(one(cube(), fixed=table(0.05, up=-1.0)))
    accept(one(cube(), fixed=table(0.05, "hold")))


def test_fixed_surfaces_may_touch_props() -> None:
    accept(one(cube(), fixed=[Fixed("wall", surface=cube(0.1))]))


@pytest.mark.parametrize("x", [0.0, 0.05, 0.1, 0.1 + 1e-7])
def test_props_that_overlap_or_touch(x: float) -> None:
    scene = Scene([Prop("left", cube()), Prop("right", cube(x))], ROOM)
    assert "props 'left' and 'right' overlap or touch" in refusal(scene)


def test_props_that_merely_stand_close() -> None:
    accept(Scene([Prop("left", cube()), Prop("right", cube(0.1 + 1e-5))], ROOM))


def test_a_spoon_may_lie_in_a_mug() -> None:
    spoon = box((0.01, 0.01, 0.06)).transformed(pose_matrix((0, 0, 0.04), (0, 0, 0)))
    accept(Scene([Prop("mug", make_shape("mug", {})), Prop("spoon", spoon)], ROOM))


def test_plane_scenes_are_checked_too() -> None:
    def moved(x: float, y: float) -> Surface:
        return polygon([(x, y), (x + 0.2, y), (x + 0.1, y + 0.3)])

    outer = Outer(surface=polygon([(-1, -1), (1, -1), (1, 1), (-1, 1)]))
    floor = Fixed("floor", plane=((0, 0), (0, 1)))
    left = Prop("left", moved(0, 0))
    right = Prop("right", moved(0.3, 0))
    accept(Scene([left, right], outer, fixed=[floor], dimension=2))
    near = Prop("near", moved(0.1, 0))
    assert "props 'left' and 'near' overlap" in refusal(Scene([left, near], outer, dimension=2))
    edge = Prop("edge", moved(0.9, 0))
    assert "prop 'edge' must lie inside" in refusal(Scene([edge], outer, dimension=2))
    diamond = Outer(surface=polygon([(-1, 0), (0, -1), (1, 0), (0, 1)]))
    corner = Prop("corner", moved(0.7, 0.6))
    assert "lies outside the outer surface" in refusal(Scene([corner], diamond, dimension=2))
