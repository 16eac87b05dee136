"""Layouts: nothing turned over, equal areas, points found again; and the cache that keeps them."""

from __future__ import annotations

import numpy as np
import pytest

from touchwarp.errors import GoalError
from touchwarp.goals.maps.areas import KEPT, polish_areas, spread, target_shares
from touchwarp.goals.maps.closed_mesh import closed_mesh
from touchwarp.goals.maps.embed import embed
from touchwarp.goals.maps.layout import Layout, area_and_gradient, frames_at, moved_along
from touchwarp.goals.maps.layout_cache import LAYOUTS, load_layout
from touchwarp.goals.maps.locate import Locator, value_and_slopes
from touchwarp.goals.maps.parameterise import lay_out, work_mesh
from touchwarp.goals.maps.rings import build_rings
from touchwarp.goals.maps.settle import star_area
from touchwarp.scene.shapes import box
from touchwarp.scene.surface import Surface

from .conftest import crowded_surface, ring_surface

SURFACES = {"box": box([0.1, 0.06, 0.04]), "ring": ring_surface()}


@pytest.fixture(params=SURFACES)
def layout(request: pytest.FixtureRequest) -> Layout:
    return lay_out(work_mesh(SURFACES[request.param], "x").mesh)


def test_no_triangle_is_turned_over_and_the_domain_is_covered_once(layout: Layout) -> None:
    assert (layout.shares > 0).all()
    assert layout.shares.sum() == pytest.approx(1, abs=1e-9)


def test_areas_keep_their_shares_within_half_a_percent(layout: Layout) -> None:
    target = target_shares(layout.mesh.face_areas)
    assert spread(polish_areas(layout, target, KEPT).shares, target) <= 0.005


def test_the_area_claim_rejects_a_layout_before_its_polish() -> None:
    mesh = work_mesh(SURFACES["box"], "x").mesh
    bare = Layout(
        mesh, embed(mesh, np.zeros((len(mesh.faces), 3, 2))), np.zeros((len(mesh.faces), 3, 2))
    )
    assert (bare.shares > 0).all()
    assert spread(bare.shares, target_shares(mesh.face_areas)) > 0.02


def test_points_of_the_mesh_are_found_where_they_are(layout: Layout) -> None:
    rng = np.random.default_rng(0)
    face = rng.integers(len(layout.mesh.faces), size=500)
    weights = rng.dirichlet(np.ones(3), size=500)
    points = np.einsum("qk,qkd->qd", weights, layout.corners[face])
    if not layout.flat:
        points /= np.linalg.norm(points, axis=1, keepdims=True)
    locator = Locator(layout)
    found = locator.find(points)
    assert (found == face).mean() > 0.99
    assert locator.weights[found == face] == pytest.approx(weights[found == face], abs=1e-6)


def test_slopes_are_those_of_small_moves(layout: Layout) -> None:
    locator = Locator(layout)
    points = layout.corners[:200].mean(axis=1)
    if not layout.flat:
        points /= np.linalg.norm(points, axis=1, keepdims=True)
    frames = frames_at(points, layout.flat)
    mesh, start = layout.mesh, locator.find(points)
    virtual = (layout.corners, mesh.neighbours, layout.jumps, mesh.faces, mesh.vertices)
    values, slopes = np.empty((len(points), 3)), np.empty((len(points), 3, 2))
    for i, point in enumerate(points):
        frame = tuple(frames[i].T.ravel())
        value_and_slopes(point, start[i], virtual, frame, values[i], slopes[i], layout.flat)
    assert values == pytest.approx(locator.values(mesh.vertices), abs=1e-12)
    for axis in range(2):
        ends = []
        for sign in (1, -1):
            move = np.zeros((len(points), 2))
            move[:, axis] = sign * 1e-6
            locator.find(moved_along(points, frames, move, layout.flat), start)
            ends.append(locator.values(mesh.vertices))
        assert slopes[:, :, axis] == pytest.approx((ends[0] - ends[1]) / 2e-6, abs=1e-6)
        assert slopes[:, :, 1 - axis] != pytest.approx((ends[0] - ends[1]) / 2e-6, abs=1e-6)


@pytest.mark.parametrize("flat", [True, False])
def test_area_gradients_are_those_of_small_moves(flat: bool) -> None:
    corners = np.array([[0.1, 0.2, 1.0], [0.4, 0.1, 1.0], [0.3, 0.6, 1.0]])
    if not flat:
        corners /= np.linalg.norm(corners, axis=1, keepdims=True)
    gradient, other = np.empty((3, 3)), np.empty((3, 3))
    area_and_gradient(corners, flat, gradient)
    frames = frames_at(corners, flat)
    for k in range(3):
        for axis in range(2):
            ends = []
            for sign in (1, -1):
                move = np.zeros((3, 2))
                move[k, axis] = sign * 1e-6
                moved = moved_along(corners, frames, move, flat)
                ends.append(area_and_gradient(moved, flat, other))
            slope = gradient[k] @ frames[k, :, axis]
            assert slope == pytest.approx((ends[0] - ends[1]) / 2e-6, abs=1e-8)
    octant = np.eye(3)
    assert area_and_gradient(octant, False, other) == pytest.approx(np.pi / 2)


@pytest.mark.parametrize(("turned", "agree"), [(0, True), (1, False)])
def test_a_vertex_by_itself_sees_the_triangles_of_the_layout(
    layout: Layout, turned: int, agree: bool
) -> None:
    """What single vertices descend by is what all together do; the next triangle is another."""
    faces, flat = layout.mesh.faces, layout.flat
    ring, shift, degree, _ = build_rings(faces, layout.corner_shift, len(layout.points))
    frames = layout.frames()
    areas, slopes = layout.shares * layout.domain_area, layout.area_gradients(frames)[:, 0]
    differ = []
    for f in range(0, len(faces), 20):
        v = faces[f, 0]
        i = (np.flatnonzero(ring[v] == faces[f, 1])[0] + turned) % degree[v]
        area, *gradient = star_area(
            v, layout.points[v], i, (ring, shift, degree), layout.points, flat
        )
        found = np.array([area, *(gradient @ frames[v])])
        differ.append(np.abs(found - [areas[f], *slopes[f]]).max() / areas[f])
    assert (max(differ) < 1e-9) == agree


def test_a_layout_is_kept_and_found_by_content() -> None:
    mesh = work_mesh(SURFACES["box"], "x").mesh
    layout = lay_out(mesh)
    again = load_layout(closed_mesh(Surface(mesh.vertices, mesh.faces), "x"))
    assert again is not None
    assert np.array_equal(again.points, layout.points)
    moved = closed_mesh(Surface(mesh.vertices + 1e-3, mesh.faces), "x")
    assert load_layout(moved) is None


def test_a_damaged_layout_is_made_anew() -> None:
    layout = lay_out(work_mesh(SURFACES["box"], "x").mesh)
    assert LAYOUTS.folder is not None
    (kept,) = LAYOUTS.folder.iterdir()
    kept.write_bytes(b"not an archive")
    assert load_layout(layout.mesh) is None
    assert np.array_equal(lay_out(layout.mesh).points, layout.points)
    assert load_layout(layout.mesh) is not None


def test_a_vertex_with_too_many_neighbours_is_told() -> None:
    mesh = closed_mesh(crowded_surface(), "x")
    with pytest.raises(GoalError, match="a vertex with more than 64 neighbours"):
        embed(mesh, np.zeros((len(mesh.faces), 3, 2)))
