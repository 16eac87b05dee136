from dataclasses import replace

import numpy as np
import pytest

from touchwarp.errors import SolveError, WarpFileError
from touchwarp.goals import goals
from touchwarp.scene import Fixed, Objective, Outer, Prop, Scene, Surface, TransformGoal
from touchwarp.solve import plane
from touchwarp.warp.file import read
from touchwarp.warp.plane_file import plane_warp_of
from touchwarp.warp.plane_solver import solve_plane
from touchwarp.warp.plane_table import PlaneTableWarp
from touchwarp.warp.plane_values import TENSORS, PlaneTable
from touchwarp.warp.protocol import Warp

SIDES = [[0, 1], [1, 2], [2, 3], [3, 0]]
SQUARE = Surface([[-0.05, 0], [0.05, 0], [0.05, 0.1], [-0.05, 0.1]], SIDES)
ROOM = Surface([[-0.2, -0.13], [0.21, -0.1], [0.2, 0.3], [-0.22, 0.28]], SIDES)
TABLE = Fixed("table", plane=((0, 0), (0, 1)))


def make_scene(outer=None, fixed=()):
    goal = TransformGoal(scale=[1.2, 0.8], translation=(0.01, 0.0))
    return Scene(
        [Prop("block", SQUARE, goal)],
        outer or Outer(),
        Objective(tolerance_mm=0.5),
        fixed,
        dimension=2,
    )


def warp_of(scene, **options):
    return solve_plane(scene, goals(scene), **options)


@pytest.fixture(scope="module", params=["box", "polygon", "box on table", "polygon on table"])
def warp(request):
    outer = Outer(surface=ROOM) if "polygon" in request.param else None
    return warp_of(make_scene(outer, [TABLE] if "table" in request.param else []))


@pytest.fixture
def points():
    return np.random.default_rng(4).uniform(-0.25, 0.32, (3000, 2))


def test_it_is_a_warp(warp):
    assert isinstance(warp, Warp)
    assert warp.dimension == 2


def test_shapes_are_kept_and_displacement_is_what_is_added(warp):
    x = np.full((2, 26, 2), 0.07)
    assert warp(x).shape == (2, 26, 2)
    assert warp.jacobian(x).shape == (2, 26, 2, 2)
    np.testing.assert_allclose(warp(x), x + warp.displacement(x))


def test_a_lost_joint_stays_lost(warp):
    x = np.array([[np.nan, 0.1], [0.07, 0.05], [0.07, np.nan]])
    for values in (warp(x), warp.displacement(x), warp.jacobian(x), warp.inverse(x).points):
        lost = np.isnan(values.reshape(3, -1))
        assert lost.all(axis=1).tolist() == [True, False, True]
        assert lost.any(axis=1).tolist() == [True, False, True]


@pytest.mark.parametrize("x", [0.1, [0.1, 0.2, 0.3], np.zeros((4, 3))])
def test_a_wrong_shape_is_refused(warp, x):
    with pytest.raises(ValueError, match=r"\(\.\.\., 2\) is needed"):
        warp(x)


def test_nothing_moves_outside_the_outer_boundary(warp):
    far = np.array([[0.5, 0.0], [0.0, -0.4], [0.0, 0.9], [-3.0, 3.0]])
    assert (warp.displacement(far) == 0).all()
    assert (warp.jacobian(far) == np.eye(2)).all()
    corner = np.array([[-0.219, -0.129]])  # in the polygon's bounding box, outside it
    if len(warp.table.outer):
        assert (warp.displacement(corner) == 0).all()


def test_the_jacobian_is_the_warp_s_slope(warp, points):
    step = 1e-9
    for axis in range(2):
        offset = np.zeros(2)
        offset[axis] = step
        slope = (warp(points + offset) - warp(points - offset)) / (2 * step)
        gap = np.abs(slope - warp.jacobian(points)[..., axis]).max(axis=1)
        assert np.quantile(gap, 0.99) < 1e-5  # not where a step crosses a grid line


def test_the_inverse_leads_back(warp, points):
    shown = warp(points[:300])
    real = warp.inverse(shown)
    assert real.found.mean() > 0.99
    np.testing.assert_allclose(warp(real.points[real.found]), shown[real.found], atol=1e-8)


def test_under_a_sliding_line_the_warp_is_mirrored_and_fades():
    warp = warp_of(make_scene(fixed=[TABLE]))
    depth = warp.table.mirror_depth
    above, under = np.array([0.08, 0.02]), np.array([0.08, -0.02])
    expected = warp.displacement(above) * [1, -1] * (1 - 0.02 / depth)
    np.testing.assert_allclose(warp.displacement(under), expected)
    assert (warp.displacement([0.08, -depth - 1e-6]) == 0).all()


def test_resampling_gives_the_same_values(warp):
    regular = warp.resample((17, 9))
    assert regular.displacement.shape == (17, 9, 2)
    x = regular.origin + regular.spacing * [5, 6]
    np.testing.assert_allclose(regular.displacement[5, 6], warp.displacement(x), atol=1e-15)


@pytest.mark.parametrize("shape", [(1, 4), (4, 4, 4)])
def test_resampling_to_no_plane_grid_is_refused(warp, shape):
    with pytest.raises(ValueError, match="two numbers of nodes"):
        warp.resample(shape)


def test_a_transform_that_is_not_rigid_is_refused(warp):
    with pytest.raises(ValueError, match="not rigid"):
        warp.at(np.diag([2.0, 2.0, 1.0]))


def test_a_table_survives_its_tensors(warp, points):
    table = PlaneTable.from_tensors(warp.table.to_tensors(), warp.table.mirror_depth)
    assert (PlaneTableWarp(table, warp.meta)(points) == warp(points)).all()


@pytest.mark.parametrize(("dtype", "lost"), [("float32", 0.0), ("float16", 1e-5)])
def test_a_warp_survives_its_file(warp, points, tmp_path, dtype, lost):
    warp.save(tmp_path / "plane.warp", dtype)
    again = plane_warp_of(*read(tmp_path / "plane.warp"))
    assert np.abs(again(points) - warp(points)).max() <= lost
    assert 1e-3 * again.meta.storage_error_mm <= 2 * lost
    assert again.solution is None
    assert again.meta.scene_text == warp.meta.scene_text
    np.testing.assert_array_equal(again.meta.goals["block"], warp.meta.goals["block"])


def test_a_type_that_warps_are_not_stored_in_is_refused(warp, tmp_path):
    with pytest.raises(ValueError, match="cannot be stored as 'float8'"):
        warp.save(tmp_path / "plane.warp", "float8")
    assert not list(tmp_path.iterdir())


def test_values_too_large_for_float16_are_refused(warp, tmp_path):
    table = replace(warp.table, values=warp.table.values + np.float32(1e5))
    with pytest.raises(ValueError, match="store the warp as float32"):
        PlaneTableWarp(table, warp.meta).save(tmp_path / "plane.warp", "float16")


@pytest.mark.parametrize("name", TENSORS)
def test_a_missing_tensor_is_refused(warp, name):
    tensors = warp.table.to_tensors()
    del tensors[name]
    with pytest.raises(WarpFileError, match=f"lacks the array '{name}'"):
        PlaneTable.from_tensors(tensors, None)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("values", np.zeros((3, 3, 2), np.float32), "'values' has shape"),
        ("values", np.zeros((3, 3, 2)), "are of type float64"),
        ("T_scene_table", np.full((3, 3), np.nan), "'T_scene_table' has NaN"),
        ("x_lines", slice(None, None, -1), "'x_lines' does not ascend"),
    ],
)
def test_damaged_tensors_are_refused(warp, name, value, message):
    tensors = warp.table.to_tensors()
    tensors[name] = tensors[name][value] if isinstance(value, slice) else value
    with pytest.raises(WarpFileError, match=message):
        PlaneTable.from_tensors(tensors, None)


@pytest.mark.parametrize("tolerance_mm", [0.0, -1.0, np.nan])
def test_a_tolerance_that_is_no_length_is_refused(tolerance_mm):
    with pytest.raises(SolveError, match="a finite length in mm > 0 is needed"):
        warp_of(make_scene(), tolerance_mm=tolerance_mm)


def test_a_tolerance_out_of_memory_s_reach_names_the_nearest_that_fits():
    with pytest.raises(SolveError, match=r"about \d\S* mm fits; raise tolerance_mm or memory"):
        warp_of(make_scene(), tolerance_mm=1e-3, memory_limit_gb=0.05)


def test_memory_that_holds_no_grid_at_all_is_refused():
    with pytest.raises(SolveError, match="raise memory_limit_gb or coarsen"):
        warp_of(make_scene(), memory_limit_gb=0.001)


def test_the_solution_and_the_meta_tell_how_it_was_made():
    scene = make_scene()
    steps = []
    warp = warp_of(scene, progress=lambda step, done: steps.append((step, done)))
    assert warp.solution.nodes == warp.table.values[..., 0].size
    assert max(warp.solution.residual_history) < 1e-12
    assert warp.solution.estimated_error_max_mm <= 0.5
    assert warp.meta.scene_text == scene.text
    assert warp.meta.prop_names == ("block",)
    assert steps[0] == ("solving", 0.0)
    assert steps[-1] == ("solving", 1.0)


def test_a_grid_too_large_to_factorise_names_the_cure(monkeypatch):
    def fails(*_, **__):
        raise MemoryError("no room")

    monkeypatch.setattr(plane, "splu", fails)
    with pytest.raises(SolveError, match="a greater tolerance makes a smaller grid"):
        warp_of(make_scene())
