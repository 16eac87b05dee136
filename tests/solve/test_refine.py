"""The indicator is the greatest trilinear error of a parabola; it knows the floor's mirror."""

import numpy as np
import pytest

from touchwarp.solve.boundary import Boundary
from touchwarp.solve.frame import Frame
from touchwarp.solve.multigrid import Multigrid
from touchwarp.solve.refine import indicate
from touchwarp.solve.region import flood_level

IN_METRES = np.array([1.0, 1.0, 1.0, 0.0], np.float32)
NO_LANES = np.zeros(4, bool)
NORMAL = np.array([False, False, True, False])


def empty_room(mirrored):
    frame = Frame(np.eye(4), np.full(3, 0.01), np.full(3, 2), mirrored)
    nothing = Boundary(np.zeros((0, 3)), np.zeros((0, 3), np.int32), np.zeros(0, np.int16))
    stage = Multigrid(frame, nothing, 0.0).stages[-1]
    return stage, flood_level(stage, None, None, nothing.owner)


def indicator(field, mirrored=False, normal_lanes=NO_LANES):
    stage, region = empty_room(mirrored)
    stage.u[:, :3] = field(stage.level.coordinates() * 0.01)
    value = indicate(stage, region, IN_METRES, normal_lanes)
    on_floor = stage.level.coordinates(slice(stage.level.n_inner))[:, 2] == 0
    return value, on_floor


def lifted(x):
    return np.stack([0 * x[:, 0], 0 * x[:, 0], 0.4 * x[:, 2]], axis=1)


@pytest.mark.parametrize(
    ("bends", "error"),
    [((1, 0, 0), 1 / 8), ((1, 1, 0), 2 / 8), ((1, -1, 0), 1 / 8), ((1, 1, -2), 2 / 8)],
)
def test_the_indicator_is_the_greatest_trilinear_error_of_a_parabola(bends, error):
    def parabola(x):
        return np.stack([0.5 * x**2 @ np.array(bends), 0 * x[:, 0], 0 * x[:, 0]], axis=1)

    value, _ = indicator(parabola)
    np.testing.assert_allclose(value, error * 0.01**2, rtol=1e-2)


def test_a_normal_component_that_grows_from_the_floor_is_linear_there():
    value, on_floor = indicator(lifted, True, NORMAL)
    assert on_floor.any()
    assert value.max() < 1e-8


def test_a_tangential_component_that_grows_from_the_floor_has_a_kink_there():
    value, on_floor = indicator(lifted, True)
    np.testing.assert_allclose(value[on_floor], 2 * 0.4 * 0.01 / 8, rtol=1e-3)
    assert value[~on_floor].max() < 1e-8
