"""Primitives are found again from noisy points on them."""

from __future__ import annotations

import re

import igl
import numpy as np
import pytest

from touchwarp.errors import SceneError
from touchwarp.scan import primitives
from touchwarp.scan.deviation import deviation, sample
from touchwarp.scan.fitting import Fitting
from touchwarp.scan.primitives import fit_primitive
from touchwarp.scene.pose import pose_matrix
from touchwarp.scene.shapes import box, cylinder, ellipsoid, make_shape, sphere
from touchwarp.scene.surface import Surface

T = pose_matrix((0.3, 0.1, 0.5), (20, 30, 40))
SHAPES = {
    "box": box([0.1, 0.06, 0.03]),
    "cylinder": cylinder(0.03, 0.12, 0.001),
    "sphere": sphere(0.04, 0.001),
    "ellipsoid": ellipsoid([0.1, 0.06, 0.05], 0.001),
}


def points_on(surface: Surface, noise: float) -> np.ndarray:
    random = np.random.default_rng(1)
    points = sample(surface.transformed(T), 80, random)[0]
    return np.asarray(points + random.normal(0, noise, points.shape))


@pytest.mark.parametrize("kind", list(SHAPES))
def test_a_shape_is_found_again(kind: str) -> None:
    found = fit_primitive(kind, points_on(SHAPES[kind], 3e-4))
    fitted = make_shape(kind, found.shape).transformed(found.T_points_shape)
    # 80 points of 0.3 mm noise fix ten numbers to a few tenths of a millimetre
    assert deviation(fitted, SHAPES[kind].transformed(T)).max_mm < 0.8
    # noise along the normal alone is left over, less what the fit takes up
    assert found.rms_mm == pytest.approx(0.3, rel=0.25)


@pytest.mark.parametrize(("kind", "other"), [("sphere", "box"), ("box", "cylinder")])
def test_the_wrong_shape_leaves_a_large_residual(kind: str, other: str) -> None:
    assert fit_primitive(kind, points_on(SHAPES[other], 3e-4)).rms_mm > 1.0


def test_a_start_turns_and_never_mirrors() -> None:
    """Angles in a scene say rotations alone, and eigenvectors may be left-handed."""
    points = points_on(SHAPES["box"], 0.0)
    start = Fitting(primitives._KINDS["box"], points)._around(np.diag([1.0, 1.0, -1.0]))
    assert np.linalg.det(start.frame) == pytest.approx(1)


def test_a_cylinder_stands_on_its_lower_end() -> None:
    found = fit_primitive("cylinder", points_on(SHAPES["cylinder"], 0.0))
    assert found.T_points_shape[2, 2] > 0
    np.testing.assert_allclose(found.T_points_shape[:3, 3], T[:3, 3], atol=1e-4)


STOOD = pose_matrix((0.3, 0.1, 0.5), (0, 0, 40))


def touched(surface: Surface, places: list[list[float]], seed: int = 0) -> np.ndarray:
    """By hand: the surface's nearest points to some places (n, 3), 0.3 mm of noise, upright."""
    aim = np.array(places, dtype=np.float64)
    foot = igl.point_mesh_squared_distance(aim, surface.vertices, surface.faces)[2]
    noise = np.random.default_rng(seed).normal(0, 3e-4, foot.shape)
    return np.asarray((foot + noise) @ STOOD[:3, :3].T + STOOD[:3, 3])


def around(radius: float, heights: tuple[float, ...], to: float = 360) -> list[list[float]]:
    angles = np.radians(np.arange(0, to, to / 6))
    return [[radius * np.cos(a), radius * np.sin(a), z] for z in heights for a in angles]


TOP = [[0, 0, 0.121], [0.015, 0, 0.121], [-0.01, 0.01, 0.121]]
BOTTOM = [[0, 0, -0.001], [0.015, 0, -0.001], [-0.01, 0.01, -0.001]]
SIDE = around(0.03, (0.005, 0.06, 0.115))


def test_a_few_touches_on_all_sides_tell_how_exactly_it_is_known() -> None:
    can = cylinder(0.03, 0.12, 1e-4)
    for seed in range(5):
        found = fit_primitive("cylinder", touched(can, SIDE + TOP + BOTTOM, seed))
        fitted = make_shape("cylinder", found.shape).transformed(found.T_points_shape)
        assert not found.standing
        # two standard deviations of each end; a corner lies off by two ends at once
        assert deviation(fitted, can.transformed(STOOD)).max_mm < 1.5 * found.known_mm < 2.0


def test_a_thing_that_stands_ends_at_its_lowest_point() -> None:
    found = fit_primitive("cylinder", touched(cylinder(0.03, 0.12, 1e-4), SIDE + TOP))
    assert found.standing
    # touched to 5 mm above the table, where six points of 0.3 mm noise are the lowest
    assert found.T_points_shape[2, 3] == pytest.approx(0.505, abs=1e-3)
    assert found.shape["height"] == pytest.approx(0.115, abs=1.5e-3)


@pytest.mark.parametrize(
    ("kind", "surface", "places", "towards"),
    [
        # only its side: its upper end could be anywhere above; the lower one is where it stands
        ("cylinder", cylinder(0.03, 0.12, 1e-4), SIDE, (0, 0, 1)),
        # from one side: its width is open
        ("sphere", sphere(0.04, 3e-4), around(0.012, (0.038, 0.037, 0.036)), (0, 0, -1)),
        ("box", box([0.1, 0.06, 0.03]), [[x, y, 0.015] for x, y, _ in SIDE[:13]], (1, 0, 0)),
    ],
)
def test_what_no_point_tells_is_refused(
    kind: str, surface: Surface, places: list[list[float]], towards: tuple[float, ...]
) -> None:
    points = touched(surface, places)
    with pytest.raises(SceneError, match="do not tell where the") as refused:
        fit_primitive(kind, points)
    told = re.findall(r"\(([-\d.]+), ([-\d.]+), ([-\d.]+)\)", str(refused.value))
    ends = np.array(told, dtype=float) @ STOOD[:3, :3]
    assert (ends @ towards).max() > 0.57  # 1/√3: no direction is farther from all axes of a frame
    if kind == "cylinder":
        return
    # the twin: the distances alone look as good as those of a shape that is known
    one = Fitting(primitives._KINDS[kind], points / np.ptp(points, axis=0).max())
    assert np.sqrt(one.best().cost / len(points)) * np.ptp(points, axis=0).max() < 3e-4


def test_a_box_is_found_from_few_points_on_all_sides() -> None:
    """Principal axes alone end in a local minimum on half of these."""
    brick = box([0.1, 0.06, 0.04])
    for seed in range(4):
        random = np.random.default_rng(seed)
        side = np.array([0.05, 0.03, 0.02])
        places = []
        for axis in range(3):
            for sign in (1, -1):
                aim = random.uniform(-0.8, 0.8, (4, 3)) * side
                aim[:, axis] = sign * side[axis]
                places += aim.tolist()
        found = fit_primitive("box", touched(brick, places, seed))
        fitted = make_shape("box", found.shape).transformed(found.T_points_shape)
        assert deviation(fitted, brick.transformed(STOOD)).max_mm < 2.5


@pytest.mark.parametrize(
    ("kind", "points", "message"),
    [
        ("cone", np.zeros((9, 3)), "unknown shape 'cone'"),
        ("box", np.zeros((5, 3)), "at least 12 points"),
        ("sphere", np.full((9, 3), np.nan), "NaN or infinite"),
        ("sphere", np.random.default_rng(0).random((9, 3)) * [1, 1, 0], "lie in a plane"),
    ],
)
def test_points_that_will_not_do(kind: str, points: np.ndarray, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        fit_primitive(kind, points)
