"""A map is as smooth between the vertices that its search has placed as it is at them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.maps import unsheared as module
from touchwarp.goals.maps.layout import Layout
from touchwarp.goals.maps.overlay import overlay
from touchwarp.goals.maps.parameterise import lay_out, work_mesh
from touchwarp.goals.maps.refine import Weights
from touchwarp.goals.maps.search import Found, Pair, Plan, search_map
from touchwarp.goals.maps.unsheared import unsheared, untangled
from touchwarp.scene.shapes import sphere
from touchwarp.scene.surface import Surface
from touchwarp.scene.vessels import mug, tea_cup

from .conftest import ring_surface

Float = NDArray[np.float64]
MORE = 2.0
"""Pieces that stretch so much more than any face does at its corners are rough."""


@pytest.fixture(scope="module")
def matched() -> tuple[Pair, Found, Plan]:
    """A mug matched to a tea cup: what lies about a handle is sheared where areas are kept."""
    layouts = [lay_out(work_mesh(surface, "x").mesh) for surface in (mug(), tea_cup())]
    nothing = tuple(np.zeros((len(layout.points), 0)) for layout in layouts)
    pair = Pair(layouts[0], layouts[1], (nothing[0], nothing[1]))
    plan = Plan(Weights(1.0, 0.2, 0.5), (2.0, 0.5), starts=1, seed=0)
    return pair, search_map(pair, plan), plan


def images(prop: Layout, virtual: Layout) -> Float:
    """(n, 3) m: what the prop's vertices show."""
    locator = virtual.locator()
    locator.find(prop.points)
    return locator.values(virtual.mesh.vertices)


def stretch(points: Float, shown: Float, faces: NDArray[np.int64]) -> tuple[Float, Float]:
    """(m,) the greater singular value of the map of each face, and its area."""
    one, two = (
        np.stack([p[faces[:, 1]] - p[faces[:, 0]], p[faces[:, 2]] - p[faces[:, 0]]], axis=2)
        for p in (points, shown)
    )
    metric, seen = (e.transpose(0, 2, 1) @ e for e in (one, two))
    area = 0.5 * np.sqrt(np.maximum(np.linalg.det(metric), 0.0))
    solid = area > 1e-14
    squares = np.linalg.eigvals(np.linalg.solve(metric[solid], seen[solid])).real.max(axis=1)
    return np.sqrt(squares), area[solid]


def rough_share(prop: Layout, virtual: Layout) -> float:
    """The part of the prop's area where pieces stretch far more than whole faces do."""
    whole, _ = stretch(prop.mesh.vertices, images(prop, virtual), prop.mesh.faces)
    cut = overlay(prop, virtual)
    pieces, area = stretch(cut.points, cut.images, cut.faces)
    limit = MORE * np.quantile(whole, 0.999)
    return float(area[pieces > limit].sum() / area.sum())


def test_the_map_is_smooth_between_vertices(matched: tuple[Pair, Found, Plan]) -> None:
    pair, found, plan = matched
    prop, virtual = unsheared(pair, found.layout, plan.weights)
    assert (prop.shares > 0).all()
    assert (virtual.shares > 0).all()
    assert rough_share(prop, virtual) < 1e-4


def test_the_claim_rejects_the_map_on_the_domain_that_keeps_areas(
    matched: tuple[Pair, Found, Plan],
) -> None:
    pair, found, _ = matched
    assert rough_share(found.layout, pair.virtual) > 5e-4


def test_vertices_show_what_they_showed(matched: tuple[Pair, Found, Plan]) -> None:
    pair, found, plan = matched
    before = images(found.layout, pair.virtual)
    after = images(*unsheared(pair, found.layout, plan.weights))
    moved = np.linalg.norm(after - before, axis=1)
    assert (moved > 1e-9).mean() < 0.03
    assert moved.max() < 0.01


def moved_by_settling(matched: tuple[Pair, Found, Plan], patch: pytest.MonkeyPatch) -> float:
    """How far images move, on average, when all vertices settle anew; in edges of the prop."""
    pair, found, plan = matched
    mend = module.untangled

    def mend_all(layout: Layout) -> tuple[Layout, NDArray[np.bool_]]:
        mended, moved = mend(layout)
        return mended, np.ones_like(moved)

    patch.setattr(module, "untangled", mend_all)
    before = images(found.layout, pair.virtual)
    after = images(*unsheared(pair, found.layout, plan.weights))
    mesh = found.layout.mesh
    edges = mesh.vertices[mesh.faces] - mesh.vertices[np.roll(mesh.faces, 1, axis=1)]
    moved = np.linalg.norm(after - before, axis=1).mean()
    return float(moved / np.linalg.norm(edges, axis=2).mean())


def test_what_settles_anew_stays_where_it_was_best(
    matched: tuple[Pair, Found, Plan], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The energy is the same on either domain, as density makes up for what areas are there."""
    assert moved_by_settling(matched, monkeypatch) < 0.1


def test_that_claim_rejects_areas_of_the_other_domain(
    matched: tuple[Pair, Found, Plan], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_density", lambda prop, *_: np.ones(len(prop.mesh.faces)))
    assert moved_by_settling(matched, monkeypatch) > 0.3


def test_a_surface_that_cannot_be_laid_out_for_shapes_keeps_its_layout(
    matched: tuple[Pair, Found, Plan], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise GoalError("no layout")

    pair, found, plan = matched
    monkeypatch.setattr(module, "embed", refuse)
    assert unsheared(pair, found.layout, plan.weights) == (found.layout, pair.virtual)


def tangled(surface: Surface) -> Layout:
    """A layout with one vertex in twenty pushed a step beyond one of its neighbours."""
    layout = lay_out(work_mesh(surface, "x").mesh)
    points = layout.points.copy()
    for f in range(0, len(layout.mesh.faces), 40):
        a, b = layout.corners[f, :2]
        points[layout.mesh.faces[f, 0]] += 1.5 * (b - a)
    if not layout.flat:
        points /= np.linalg.norm(points, axis=1, keepdims=True)
    return layout.moved(points)


@pytest.mark.parametrize("surface", [ring_surface(), sphere(0.03, 0.5)])
def test_turned_triangles_are_turned_back_by_what_is_near_them(surface: Surface) -> None:
    layout = tangled(surface)
    turned = layout.shares <= 0
    assert turned.sum() > 20
    mended, moved = untangled(layout)
    assert (mended.shares > 0).all()
    assert np.array_equal(mended.points[~moved], layout.points[~moved])
    assert moved[layout.mesh.faces[turned]].all()
    assert moved.mean() < 0.5


def test_the_mending_claim_rejects_no_mending(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "ROUNDS", 0)
    mended, moved = untangled(tangled(ring_surface()))
    assert (mended.shares <= 0).any()
    assert not moved.any()


def test_what_cannot_be_mended_keeps_its_layouts(
    matched: tuple[Pair, Found, Plan], monkeypatch: pytest.MonkeyPatch
) -> None:
    pair, found, plan = matched
    monkeypatch.setattr(module, "untangled", lambda _: (tangled(ring_surface()), None))
    assert unsheared(pair, found.layout, plan.weights) == (found.layout, pair.virtual)
