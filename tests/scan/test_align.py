"""The pose of a virtual object is found from anywhere, and its symmetries are told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.scan.scans import fine_mug
from touchwarp.cli.align import alignment_rows
from touchwarp.errors import SceneError
from touchwarp.scan.align import align
from touchwarp.scan.preparation import place
from touchwarp.scene.mesh_file import read_mesh
from touchwarp.scene.pose import pose_matrix
from touchwarp.scene.shapes import box, cylinder, make_shape, polygon, sphere
from touchwarp.scene.surface import Surface

POSES = [((0.3, -0.2, 0.1), (90, 20, 130)), ((0, 0, 0.5), (180, 0, 77)), ((1, 0, 0), (0, 90, 0))]


@pytest.fixture(scope="module")
def mug() -> Surface:
    return fine_mug(5e-3)


def turn_deg(T: np.ndarray) -> float:
    R = T[:3, :3] / np.cbrt(np.linalg.det(T[:3, :3]))
    return float(np.degrees(Rotation.from_matrix(R).magnitude()))


@pytest.mark.parametrize(("position", "rotation_deg"), POSES)
def test_a_mug_is_found_from_any_pose(
    mug: Surface, position: tuple[float, ...], rotation_deg: tuple[float, ...]
) -> None:
    T = pose_matrix(position, rotation_deg)
    found = align(mug, mug.transformed(T))
    assert turn_deg(found.T_prop_virtual @ T) < 0.01
    assert np.abs((found.T_prop_virtual @ T)[:3, 3]).max() < 1e-5
    assert found.to_prop.max_mm < 0.01
    assert (found.equal_poses, found.free_axes) == (1, ())


def test_without_turning_the_mug_on_its_side_is_not_found(mug: Surface) -> None:
    lying = mug.transformed(pose_matrix((0, 0, 0), (90, 0, 0)))
    assert align(mug, lying, rotation="none").to_prop.p95_mm > 10
    assert align(mug, lying, rotation="upright").to_prop.p95_mm > 10


def test_the_scale_is_found_too(mug: Surface) -> None:
    T = pose_matrix((0.3, -0.2, 0.1), (90, 20, 130)) @ np.diag([7.0, 7, 7, 1])
    found = align(mug, mug.transformed(T), scale=True)
    assert found.scale == pytest.approx(1 / 7, rel=1e-5)
    assert found.to_prop.max_mm < 0.02


def test_the_pose_as_a_scene_writes_it_is_the_matrix(mug: Surface) -> None:
    found = align(mug, mug.transformed(pose_matrix((0.1, 0.2, 0.3), (30, 40, 50))))
    again = pose_matrix(found.position, found.rotation_deg)
    np.testing.assert_allclose(again, found.T_prop_virtual, atol=1e-9)


def test_symmetries_are_told() -> None:
    T = pose_matrix((0.1, 0.2, 0), (40, 50, 60))
    brick, can, ball = box([0.1, 0.06, 0.03]), cylinder(0.03, 0.12), sphere(0.05, 0.1)
    found = align(brick, brick.transformed(T))
    assert (found.equal_poses, found.free_axes) == (4, ())
    found = align(can, can.transformed(T))
    assert len(found.free_axes) == 1
    np.testing.assert_allclose(np.abs(found.free_axes[0]), (0, 0, 1), atol=0.02)
    assert found.equal_poses == 2
    assert len(align(ball, ball.transformed(T)).free_axes) == 3


def test_a_tea_cup_on_its_side_is_stood_on_a_mug_handle_on_handle(mug: Surface) -> None:
    cup = make_shape("tea_cup", {})
    T = pose_matrix((0, 0, 0), (90, 0, 0)) @ pose_matrix((0, 0, 0), (0, 0, 90))
    found = place(mug, cup.transformed(T), on_table=True)
    whole = found.T_prop_virtual @ T
    np.testing.assert_allclose(whole[2, :3], (0, 0, 1), atol=1e-9)  # upright, not tilted
    assert turn_deg(whole) < 10  # both handles are in +x
    assert cup.transformed(whole).bounds[0, 2] == pytest.approx(0, abs=1e-12)


def handle_deg(surface: Surface) -> float:
    """Azimuth of the point farthest from the vertical through the middle, below rim and spout."""
    low, high = surface.bounds[:, 2]
    below = surface.vertices[surface.vertices[:, 2] < low + 0.7 * (high - low)]
    rim = surface.vertices[surface.vertices[:, 2] < low + 0.1 * (high - low)]
    x, y = below[:, :2].T - (rim[:, :2].min(0) + rim[:, :2].max(0))[:, None] / 2
    far = int((x**2 + y**2).argmax())
    return float(np.degrees(np.arctan2(y[far], x[far])))


@pytest.mark.needs_shared_data
def test_a_pitcher_is_stood_on_a_cup_handle_on_handle(shared_data: Path) -> None:
    cup, pitcher = (
        read_mesh(shared_data / "data" / name, "m") for name in ("cup_blue.obj", "pitcher_ycb.obj")
    )
    T = place(cup, pitcher).T_prop_virtual
    np.testing.assert_allclose(T[2, :3], (0, 0, 1), atol=1e-9)
    apart = handle_deg(cup) - handle_deg(pitcher.transformed(T))
    assert abs((apart + 180) % 360 - 180) < 20
    # the twin: by distances alone it is laid on its side
    assert abs(align(cup, pitcher).T_prop_virtual[2, 2]) < 0.5


def test_a_brick_on_its_side_is_stood_on_a_tall_one() -> None:
    tall, lying = box([0.06, 0.05, 0.18]), box([0.16, 0.07, 0.06])
    found = place(tall, lying)
    np.testing.assert_allclose(np.abs(found.T_prop_virtual[2, :3]), (1, 0, 0), atol=1e-9)
    # that it is turned over is told, and how much worse it would lie upright
    upright = align(tall, lying, rotation="upright")
    worse = upright.to_prop.p95_mm + upright.to_virtual.p95_mm
    nearest = align(tall, lying)
    least = nearest.to_prop.p95_mm + nearest.to_virtual.p95_mm
    assert found.upright_times == pytest.approx(worse / least, rel=1e-9)
    assert ("turned over", "the up axis") in [(a, b[:11]) for a, b in alignment_rows(found)]
    # the twin: nothing is told of what stands
    assert place(tall, tall).upright_times is None


@pytest.mark.parametrize(
    ("prop", "rotation", "message"),
    [
        (box([0.1, 0.1, 0.1]), "sideways", "unknown rotation 'sideways'"),
        (polygon([(0, 0), (1, 0), (0, 1)]), "any", "the prop is a polygon"),
        (Surface(np.zeros((3, 3)), np.array([[0, 1, 2]])), "any", "the prop has no area"),
    ],
)
def test_what_cannot_be_aligned(prop: Surface, rotation: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        align(prop, box([0.1, 0.1, 0.1]), rotation=rotation)
