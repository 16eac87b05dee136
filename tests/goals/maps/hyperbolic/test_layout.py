"""Layouts on the hyperbolic surface: canonical loops, nothing turned over, areas, places found."""

from __future__ import annotations

import numpy as np
import pytest

from touchwarp.errors import GoalError
from touchwarp.goals.maps.areas import spread, target_shares
from touchwarp.goals.maps.closed_mesh import closed_mesh
from touchwarp.goals.maps.hyperbolic import marking as marking_module
from touchwarp.goals.maps.hyperbolic.coarsened import Coarsened
from touchwarp.goals.maps.hyperbolic.deck import METRIC, Deck
from touchwarp.goals.maps.hyperbolic.layout import HyperbolicLayout
from touchwarp.goals.maps.hyperbolic.mapping_classes import twists
from touchwarp.goals.maps.hyperbolic.marking import (
    Marking,
    find_marking,
    seifert_form,
    twists_to_standard,
)
from touchwarp.goals.maps.hyperbolic.overlay import overlay
from touchwarp.goals.maps.hyperbolic.parameterise import lay_out
from touchwarp.goals.maps.hyperbolic.words import identity, inverse
from touchwarp.goals.maps.parameterise import work_mesh

from ..conftest import crowded_surface
from .conftest import vase

STANDARD = np.kron(np.eye(2, dtype=int), np.array([[0, 1], [0, 0]]))


@pytest.fixture(scope="module")
def marking() -> Marking:
    return find_marking(work_mesh(vase(), "x").whole)


@pytest.fixture(scope="module")
def layout(marking: Marking) -> HyperbolicLayout:
    return lay_out(marking, Deck(2))


def test_canonical_loops_run_round_and_through_the_handles(marking: Marking) -> None:
    form = seifert_form(marking.coarsened, marking.springs, marking.images)
    assert (form == STANDARD).all()
    twisted = marking.springs.moved(marking.images, twists(2)["A1"])  # the twin
    form = seifert_form(marking.coarsened, marking.springs, twisted)
    assert not (form == STANDARD).all()
    assert twists_to_standard(form) != []


def test_a_detour_of_the_base_point_makes_no_class_far(marking: Marking) -> None:
    springs, detour = marking.springs, 3 * (1, 3)
    far = {k: (*detour, *word, *inverse(detour)) for k, word in marking.images.items()}
    back = springs.moved(far, identity(2))
    assert sum(map(len, back.values())) <= sum(map(len, marking.images.values()))
    assert springs.key(back) == springs.key(marking.images)
    least = springs.energy(marking.images)
    assert springs.energy(back) == pytest.approx(least, rel=1e-3)
    assert springs.energy(far) > 1e6 * least  # the twin


def test_no_triangle_is_turned_over_and_the_surface_is_covered_once(
    layout: HyperbolicLayout,
) -> None:
    assert (layout.shares > 0).all()
    assert layout.shares.sum() == pytest.approx(1, abs=1e-9)  # Gauss and Bonnet: 4π (g − 1)
    square = np.einsum("nd,de,ne->n", layout.points, METRIC, layout.points)
    assert square == pytest.approx(-1, abs=1e-9)
    turned = layout.points.copy()
    turned[0] = layout.points[layout.mesh.faces[-1, 0]]  # the twin
    assert not (layout.moved(turned).shares > 0).all()


def test_areas_keep_about_their_shares(marking: Marking, layout: HyperbolicLayout) -> None:
    target = target_shares(layout.mesh.face_areas)
    bare = marking.coarsened.regrow(marking.lay_coarse(marking.images, Deck(2))).finish()
    assert (bare.shares > 0).all()
    assert spread(layout.shares, target) < 0.5 * spread(bare.shares, target)


def test_points_of_the_mesh_are_found_where_they_are(layout: HyperbolicLayout) -> None:
    rng = np.random.default_rng(0)
    face = rng.integers(len(layout.mesh.faces), size=300)
    weights = rng.dirichlet(np.ones(3), size=300)
    points = np.einsum("qk,qkd->qd", weights, layout.corners[face])
    points /= np.sqrt(-np.einsum("qd,de,qe->q", points, METRIC, points))[:, None]
    locator = layout.locator()
    found = locator.find(points)
    assert (found == face).mean() > 0.98
    assert locator.weights[found == face] == pytest.approx(weights[found == face], abs=1e-6)


def test_area_gradients_are_those_of_small_moves(layout: HyperbolicLayout) -> None:
    frames = layout.frames()
    gradients = layout.area_gradients(frames)
    rng = np.random.default_rng(1)
    move = rng.normal(size=(len(layout.points), 2))
    ends = [layout.moved(layout.along(frames, s * 1e-7 * move)).shares for s in (1, -1)]
    measured = (ends[0] - ends[1]) / 2e-7 * layout.domain_area
    foreseen = np.einsum("mki,mki->m", gradients, move[layout.mesh.faces])
    assert foreseen == pytest.approx(measured, abs=1e-6)


def test_a_layout_gathered_or_carried_is_the_same(layout: HyperbolicLayout) -> None:
    deck = layout.deck
    far = layout.moved(layout.points @ deck.tables[0][1].T)
    assert far.gathered().shares.sum() != pytest.approx(0)
    assert layout.gathered().shares == pytest.approx(layout.shares, abs=1e-12)


def test_a_vertex_with_too_many_neighbours_is_told() -> None:
    with pytest.raises(GoalError, match="a vertex with more than 64 neighbours"):
        Coarsened(closed_mesh(crowded_surface(), "x"), 10)


def test_a_coarse_layout_without_room_is_told(marking: Marking) -> None:
    coarse = marking.lay_coarse(marking.images, Deck(2))
    flat = coarse.moved(np.tile([0.0, 0.0, 1.0], (len(coarse.points), 1)))
    with pytest.raises(GoalError, match="triangles would be turned over; remesh it"):
        marking.coarsened.regrow(flat).finish()


def test_a_surface_that_crosses_itself_is_told(
    marking: Marking, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(marking_module, "pushed_linking", lambda *_: np.full((4, 4), 0.5))
    with pytest.raises(GoalError, match="the surface crosses itself"):
        seifert_form(marking.coarsened, marking.springs, marking.images)
    monkeypatch.setattr(marking_module, "MOST_FORMS", 50)
    with pytest.raises(GoalError, match="the surface crosses itself"):
        twists_to_standard(7 * np.ones((4, 4), np.int64))


def test_a_layout_over_itself_shows_each_face_once(layout: HyperbolicLayout) -> None:
    cells = overlay(layout, layout)
    moved = np.linalg.norm(cells.images - cells.points, axis=1)
    # every corner lies on one: only the fourth try's moves, 1e-5 of the plane's unit, tell them all
    # apart, and that unit is up to 0.26 m of the vase
    assert moved.max() < 4e-6
    area = np.linalg.norm(_crossed(cells.images, cells.faces), axis=1).sum() / 2
    assert area == pytest.approx(layout.mesh.area, rel=1e-9)


def test_triangles_too_thin_are_told(layout: HyperbolicLayout) -> None:
    thin = layout.points.copy()
    a, b, _ = layout.mesh.faces[np.flatnonzero((layout.elements == 0).all(axis=1))[0]]
    thin[a] = thin[b]
    with pytest.raises(GoalError, match="triangles too thin to be told from turned ones"):
        overlay(layout.moved(thin), layout)


def _crossed(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    a, b, c = (points[faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a)
