"""Primitives are found again from noisy points on them."""

from __future__ import annotations

import numpy as np
import pytest

from touchwarp.errors import SceneError
from touchwarp.scan.deviation import deviation, sample
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


def test_a_cylinder_stands_on_its_lower_end() -> None:
    found = fit_primitive("cylinder", points_on(SHAPES["cylinder"], 0.0))
    assert found.T_points_shape[2, 2] > 0
    np.testing.assert_allclose(found.T_points_shape[:3, 3], T[:3, 3], atol=1e-4)


@pytest.mark.parametrize(
    ("kind", "points", "message"),
    [
        ("cone", np.zeros((9, 3)), "unknown shape 'cone'"),
        ("box", np.zeros((5, 3)), "at least 9 points"),
        ("sphere", np.full((9, 3), np.nan), "NaN or infinite"),
        ("sphere", np.random.default_rng(0).random((9, 3)) * [1, 1, 0], "lie in a plane"),
    ],
)
def test_points_that_will_not_do(kind: str, points: np.ndarray, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        fit_primitive(kind, points)
