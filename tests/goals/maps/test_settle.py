"""Vertices that settle one by one lower the energy that all share, and turn nothing over."""

from __future__ import annotations

import numpy as np
import pytest

from touchwarp.goals.maps.areas import moved_unturned
from touchwarp.goals.maps.layout import Layout
from touchwarp.goals.maps.parameterise import lay_out, work_mesh
from touchwarp.goals.maps.refine import MapProblem, Weights
from touchwarp.goals.maps.search import Pair
from touchwarp.scene.shapes import box, ellipsoid

from .conftest import ring_surface

SURFACES = {
    "egg over egg": ellipsoid([0.05, 0.06, 0.09], 0.5),
    "ring over ring": ring_surface(),
    "box over box": box([0.1, 0.06, 0.04]),
}
WEIGHTS = Weights(displacement=1.0, smoothness=0.2, area=0.3)


def roughened(layout: Layout, by: float) -> Layout:
    """Each point moved at random, by a part of its triangles' size, none turned over."""
    rng = np.random.default_rng(3)
    size = np.sqrt(layout.domain_area / len(layout.points))
    move = by * size * rng.normal(size=(len(layout.points), 2))
    return moved_unturned(layout, layout.shares, layout.frames(), move)[0]


@pytest.fixture(params=SURFACES)
def rough(request: pytest.FixtureRequest) -> tuple[MapProblem, Layout, Layout]:
    layout = lay_out(work_mesh(SURFACES[request.param], "x").mesh)
    normals = layout.mesh.vertex_normals
    pair = Pair(layout, layout, (0.2 * normals, 0.2 * normals))
    rough = roughened(layout, 0.3)
    return pair.problem(rough, np.arange(len(layout.points))), rough, layout


def test_the_energy_of_all_falls_towards_the_map_that_moves_nothing(
    rough: tuple[MapProblem, Layout, Layout],
) -> None:
    problem, start, _ = rough
    energies = [problem.energy(problem.settle(start, WEIGHTS, r), WEIGHTS) for r in (0, 2, 20)]
    assert energies[0] == pytest.approx(problem.energy(start, WEIGHTS))  # the twin: no rounds
    assert energies[1] < 0.5 * energies[0]
    assert energies[2] < 0.02 * energies[0]
    assert (problem.settle(start, WEIGHTS, 20).shares > 0).all()


def test_a_long_move_is_shortened_where_a_triangle_would_turn_over() -> None:
    layout = lay_out(work_mesh(SURFACES["box over box"], "x").mesh)
    frames = layout.frames()
    move = np.zeros((len(layout.points), 2))
    move[0] = 3 * np.sqrt(layout.domain_area / len(layout.points))
    move[40] = 1e-3 * move[0]
    far = layout.moved(layout.along(frames, move))
    assert (far.shares <= 0).any()  # the twin: the whole move turns triangles over
    near, shares = moved_unturned(layout, layout.shares, frames, move)
    assert (shares > 0).all()
    assert np.array_equal(shares, near.shares)
    assert np.linalg.norm(near.points[0] - layout.points[0]) > 0
    # who is not beside it goes all the way
    assert near.points[40] == pytest.approx(far.points[40], abs=1e-12)
