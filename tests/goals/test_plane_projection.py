"""Height fields share their projected position; patches meet; what has no partner is told."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from touchwarp.errors import GoalError
from touchwarp.goals import Goal, goals
from touchwarp.goals.surface_samples import face_areas
from touchwarp.scene import Patch, PlaneProjectionGoal, Prop, Scene, Surface
from touchwarp.scene.plane_cut import cut_by_plane
from touchwarp.scene.pose import pose_matrix
from touchwarp.scene.shapes import box, cylinder, ellipsoid, fillet_box, make_shape, sphere
from touchwarp.scene.topology import open_edge_count

UP = (0.0, 0.0, 1.0)


def made(prop: Surface, virtual: Surface, **keys: Any) -> Goal:
    return goals(Scene([Prop("it", prop, PlaneProjectionGoal(virtual, **keys))]))["it"]


def relief(height: Any, n: int = 24) -> Surface:
    """A sheet of n × n squares over [−0.05, 0.05]², at height(x, y)."""
    x, y = (a.ravel() for a in np.meshgrid(*[np.linspace(-0.05, 0.05, n + 1)] * 2, indexing="ij"))
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    a, b, c, d = (p * (n + 1) + q for p, q in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return Surface(np.stack([x, y, height(x, y)], axis=1), faces)


# Pairs whose map is known: prop, virtual object, and what it does to the prop's points.
def squash(factor: float) -> Any:
    return lambda points: points * [1, 1, factor]


CLOSED_FORMS = {
    "sphere to lens": (sphere(0.04), ellipsoid((0.08, 0.08, 0.03)), squash(0.375)),
    "cylinder to lower one": (cylinder(0.03, 0.1), cylinder(0.03, 0.06), squash(0.6)),
    "box to higher one": (box((0.1, 0.06, 0.04)), box((0.1, 0.06, 0.1)), squash(2.5)),
    "sheet to slope": (
        relief(lambda x, y: 0 * x),
        relief(lambda x, y: 0.3 * x - 0.2 * y, n=5),
        lambda points: points + np.outer(points @ [0.3, -0.2, 0], UP),
    ),
}


@pytest.mark.parametrize("name", CLOSED_FORMS)
@pytest.mark.parametrize("turned", [False, True])
def test_closed_forms_are_met_exactly(name: str, turned: bool) -> None:
    prop, virtual, expected = CLOSED_FORMS[name]
    T = pose_matrix((0.1, 0.2, 0.3), (20, 30, 40)) if turned else np.eye(4)
    goal = made(prop.transformed(T), virtual.transformed(T), normal=T[:3, 2])
    still = (goal.prop_points - T[:3, 3]) @ T[:3, :3]
    shown = expected(still) @ T[:3, :3].T + T[:3, 3]
    np.testing.assert_allclose(goal.virtual_points, shown, atol=1e-12)
    assert goal.kind == "plane_projection"
    assert goal.virtual_surface is not None
    assert goal.report["image_distance_max"] < 1e-10


def test_the_closed_form_claim_rejects_a_normal_a_degree_off() -> None:
    prop, virtual, expected = CLOSED_FORMS["sphere to lens"]
    off = (np.sin(np.deg2rad(1)), 0, np.cos(np.deg2rad(1)))
    goal = made(prop, virtual, normal=off, gap_mm=1)
    assert np.abs(goal.virtual_points - expected(goal.prop_points)).max() > 1e-4


def test_a_curved_relief_is_followed_within_the_tolerance() -> None:
    def wave(x: Any, y: Any) -> Any:
        return 0.01 * np.cos(60 * x) * np.cos(50 * y)

    flat, waved = relief(lambda x, y: 0 * x, n=2), relief(wave, n=200)
    goal = made(flat, waved, normal=UP, tolerance_mm=0.1)
    np.testing.assert_allclose(goal.virtual_points[:, :2], goal.prop_points[:, :2], atol=1e-12)
    middles = goal.virtual_points[goal.faces].mean(axis=1)
    assert np.abs(middles[:, 2] - wave(*middles[:, :2].T)).max() < 1.5e-4
    assert len(goal.faces) < len(waved.faces)


FILLET = Patch((1, 1, 0), (0.05, 0.02, 0))  # through the lines where the greater fillet begins


def fillets(patches: list[Patch] | None = None, small: float = 0.01) -> Goal:
    prop, virtual = (fillet_box((0.1, 0.1, 0.1), r) for r in (small, 0.03))
    return made(prop, virtual, patches=patches or [FILLET])


def on_fillet_box(points: np.ndarray, radius: float) -> np.ndarray:
    """The distance, at least, of points from the box whose edge at +x, +y is rounded."""
    from_axis = points[:, :2] - (0.05 - radius)
    in_corner = (from_axis > 0).all(axis=1)
    to_round = np.abs(np.linalg.norm(from_axis, axis=1) - radius)
    to_flat = np.abs(np.abs(points) - 0.05).min(axis=1)
    caps = np.abs(np.abs(points[:, 2]) - 0.05)
    return np.where(in_corner, np.minimum(to_round, caps), to_flat)


def test_a_small_fillet_is_felt_as_a_large_one() -> None:
    goal = fillets()
    assert on_fillet_box(goal.virtual_points, 0.03).max() < 2.1e-5  # the facets' depth
    assert on_fillet_box(goal.prop_points, 0.01).max() < 2.1e-5
    # Over the plane nothing moves sideways; behind it nothing moves at all.
    along = np.array([1, 1, 0]) / np.sqrt(2)
    sideways = goal.displacement - np.outer(goal.displacement @ along, along)
    assert np.abs(sideways).max() < 1e-12
    behind = (goal.prop_points[:, :2].sum(axis=1)) < 0.07 - 1e-9
    assert behind.any()
    assert np.abs(goal.displacement[behind]).max() < 1e-12
    # The corner of a box of sides 0.1 m is (√2 − 1) r away from a fillet of radius r.
    deepest = np.linalg.norm(goal.displacement, axis=1).max()
    assert deepest == pytest.approx((np.sqrt(2) - 1) * 0.02, abs=3e-5)
    assert open_edge_count(goal.faces) == 0
    assert goal.report["gap_max"] < 1e-12


def test_the_fillet_claim_rejects_another_radius() -> None:
    assert on_fillet_box(fillets().virtual_points, 0.029).max() > 3e-4


def test_several_patches_meet_without_a_gap() -> None:
    def both(radius: float) -> Surface:
        """A box with two opposite rounded edges: two half boxes that share a hidden plane."""
        half = fillet_box((0.1, 0.1, 0.1), radius)
        flip = np.diag([-1.0, -1, 1, 1])
        cut = cut_by_plane(half, np.zeros(3), np.array([1.0, 1, 0]))
        keep = (cut.vertices[cut.faces].mean(axis=1) @ [1, 1, 0]) > 0
        front = Surface(cut.vertices, cut.faces[keep])
        back = front.transformed(flip)
        vertices = np.concatenate([front.vertices, back.vertices])
        return Surface(vertices, np.concatenate([front.faces, back.faces + len(front.vertices)]))

    behind = Patch((-1, -1, 0), (-0.05, -0.02, 0))
    goal = made(both(0.01), both(0.03), patches=[FILLET, behind])
    assert goal.report["gap_max"] < 1e-12
    flipped = goal.prop_points * [-1, -1, 1]
    for sign in (1, -1):
        here = sign * (goal.prop_points @ [1, 1, 0]) >= 0
        points = (goal.virtual_points if sign == 1 else goal.virtual_points * [-1, -1, 1])[here]
        assert on_fillet_box(points, 0.03).max() < 2.1e-5
    assert len(flipped) == len(goal.virtual_points)


AXES = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]


def bulge(x: Any, y: Any) -> Any:
    """m: a cushion over [−0.05, 0.05]², 0 at its border."""
    return 0.01 * (1 - (x / 0.05) ** 2) * (1 - (y / 0.05) ** 2)


def pillow(height: Any, n: int = 40) -> Surface:
    """A cube of sides 0.1 m with `height` put on each of its six faces."""
    sheet = relief(lambda x, y: 0.05 + height(x, y), n)
    turns = [(0, 90, 0), (0, -90, 0), (-90, 0, 0), (90, 0, 0), (0, 0, 0), (180, 0, 0)]
    sides = [sheet.transformed(pose_matrix((0, 0, 0), turn)) for turn in turns]
    offsets = np.arange(6)[:, None, None] * len(sheet.vertices)
    faces = (np.array([side.faces for side in sides]) + offsets).reshape(-1, 3)
    return Surface(np.concatenate([side.vertices for side in sides]), faces)


def test_six_patches_make_a_pillow_of_a_cube() -> None:
    cube = box((0.1, 0.1, 0.1))
    goal = made(cube, pillow(bulge), patches=[Patch(axis) for axis in AXES])
    assert goal.report["gap_max"] < 1e-12  # the cube's edges stay where they are
    assert open_edge_count(goal.faces) == 0
    x = goal.prop_points
    axis = np.abs(x).argmax(axis=1)
    across = np.array([[1, 2], [0, 2], [0, 1]])[axis]
    lifted = bulge(*np.take_along_axis(x, across, axis=1).T)
    shown = np.take_along_axis(np.abs(goal.virtual_points), axis[:, None], axis=1)[:, 0]
    # The pillow's facets: h²/8 (|f_xx| + |f_yy| + 2 |f_xy|) on a grid of h = 2.5 mm.
    assert np.abs(shown - 0.05 - lifted).max() < 4e-5
    sideways = np.take_along_axis(goal.displacement, across, axis=1)
    assert np.abs(sideways).max() < 1e-12


def test_the_pillow_claim_rejects_another_height() -> None:
    flatter = made(
        box((0.1, 0.1, 0.1)),
        pillow(lambda x, y: 0.99 * bulge(x, y)),
        patches=[Patch(axis) for axis in AXES],
    )
    top = np.abs(flatter.virtual_points).max()
    assert 0.06 - top > 5e-5


@pytest.mark.parametrize(
    ("virtual", "patches", "message"),
    [
        (
            box((0.12, 0.12, 0.12)),
            AXES,
            r"patch \d and patch \d do not meet: the point \(-?50, -?50, -?50\) mm of both would "
            r"show at two places 14.1 mm apart. Choose planes",
        ),
        (
            pillow(bulge),
            AXES[:5],
            r"the face at \(.*, -50\) mm faces away from every patch's normal",
        ),
    ],
)
def test_patches_by_normal_that_do_not_fit_are_told(
    virtual: Surface, patches: list[Any], message: str
) -> None:
    with pytest.raises(GoalError, match=message):
        made(box((0.1, 0.1, 0.1)), virtual, patches=[Patch(normal) for normal in patches])


def test_a_patch_behind_another_part_of_the_prop_is_told() -> None:
    mug = make_shape("mug", {})
    with pytest.raises(
        GoalError,
        match=r"the prop's patch along \(1, 0, 0\) is no height field: \(.*\) mm lies .* mm",
    ):
        made(mug, mug, patches=[Patch(axis) for axis in AXES])


@pytest.mark.parametrize(
    ("prop", "virtual", "keys", "message"),
    [
        (
            box((0.1, 0.1, 0.1)),
            box((0.1, 0.08, 0.1)),
            {"normal": UP},
            r"8 of 8 points have no partner: on the line along \(0, 0, 1\) through "
            r"\(-?50, -?50, -?50\) mm there is nothing of the virtual object, which is 10 mm aside",
        ),
        (
            make_shape("mug", {}),
            make_shape("mug", {}),
            {"normal": (1, 0, 0)},
            r"the prop is no height field: the line along \(1, 0, 0\) through .* mm crosses it "
            r"[3-8] times, and so do 0.\d+ of all; .* at most twice, in and out",
        ),
        (
            relief(lambda x, y: 0 * x),
            box((0.1, 0.1, 0.1)),
            {"normal": UP},
            "the prop is a sheet over the plane, but the virtual object has two sides, up to 100",
        ),
        (
            box((0.1, 0.1, 0.1)),
            relief(lambda x, y: 0 * x),
            {"normal": UP},
            "the virtual object is a sheet over the plane, but the prop has two sides",
        ),
        (
            fillet_box((0.1, 0.1, 0.1), 0.01),
            fillet_box((0.11, 0.1, 0.1), 0.03).transformed(pose_matrix((-0.005, 0, 0), (0, 0, 0))),
            {"patches": [FILLET]},
            "no patch holds the point .* so it would stay, but the virtual surface is 10 mm away",
        ),
        (
            fillet_box((0.1, 0.1, 0.1), 0.01),
            fillet_box((0.1, 0.1, 0.1), 0.03),
            {"patches": [Patch((1, 1, 0), (0.05, 0.03, 0))]},
            "so it would stay, but the virtual surface is .* away from it; add a patch",
        ),
        (
            relief(lambda x, y: 0.01 * (x > 0)),
            relief(lambda x, y: 0.01 * (x > -0.02)),
            {"patches": [Patch(UP, (0, 0, 0.001))], "gap_mm": 2},
            r"the prop leaves the patch's plane, but the virtual object is 9 mm in front of it",
        ),
    ],
)
def test_what_has_no_partner_is_told(
    prop: Surface, virtual: Surface, keys: dict[str, Any], message: str
) -> None:
    with pytest.raises(GoalError, match=message) as error:
        made(prop, virtual, **keys)
    assert str(error.value).startswith("prop 'it': ")


def test_patches_that_disagree_are_told() -> None:
    # 1.5 mm over the border of the first patch passes for touching it, along the second patch's
    # slanting normal it is three times as far.
    prop = Surface(relief(lambda x, y: 0 * x).vertices * [0.5, 0.5, 1], relief(np.add).faces)
    virtual = relief(lambda x, y: 0 * x + 0.0015)
    patches = [Patch((0.3, 0, 1), (0, 0, 0)), Patch((-3, 0, 1), (0.02, 0, 0))]
    with pytest.raises(
        GoalError, match=r"patch 1 and patch 2 do not meet: the point .* 4.\d+ mm apart. Choose"
    ):
        made(prop, virtual, patches=patches, gap_mm=2)


def test_cutting_changes_no_shape() -> None:
    mug = make_shape("mug", {})
    cut = cut_by_plane(mug, np.array([0, 0, 0.05]), np.array([0.1, 0.2, 1.0]))
    height = (cut.vertices - [0, 0, 0.05]) @ [0.1, 0.2, 1.0]
    of_face = height[cut.faces]
    assert not ((of_face.min(axis=1) < -1e-8) & (of_face.max(axis=1) > 1e-8)).any()
    assert len(cut.faces) > len(mug.faces)
    assert open_edge_count(cut.faces) == 0
    areas = [face_areas(s.vertices, s.faces).sum() for s in (cut, mug)]
    assert areas[0] == pytest.approx(areas[1], rel=1e-12)
    assert cut_by_plane(mug, np.array([0, 0, 1.0]), np.array(UP)) is mug
