import numpy as np
import pytest

from touchwarp.solve.plane import encloses
from touchwarp.solve.plane_cuts import EAST, NEAREST, NORTH, SOUTH, WEST, Curves, cut_plane
from touchwarp.solve.plane_grid import PlaneGrid

GRID = PlaneGrid(np.arange(6.0), np.arange(5.0), 1.0)


def cut(*polyline):
    points = np.array(polyline, dtype=float)
    number = np.arange(len(points) - 1)
    segments = np.stack([number, number + 1], axis=1)
    return cut_plane(GRID, Curves(points, segments, np.zeros_like(points)))


def test_an_edge_is_cut_from_both_its_nodes():
    cuts = cut((2.25, 0.5), (2.25, 2.5))
    for j in (1, 2):
        assert cuts.distance[EAST, 2, j] == pytest.approx(0.25)
        assert cuts.distance[WEST, 3, j] == pytest.approx(0.75)
        assert cuts.segment[cuts.crossing[EAST, 2, j]] == 0
        assert cuts.fraction[cuts.crossing[EAST, 2, j]] == pytest.approx((j - 0.5) / 2)
    assert (cuts.crossing >= 0).sum() == 4


def test_without_a_crossing_the_next_node_is_a_spacing_away_and_the_grid_ends():
    cuts = cut((2.25, 0.5), (2.25, 2.5))
    assert cuts.distance[EAST, 0, 0] == 1.0
    assert np.isinf(cuts.distance[WEST, 0, 0])
    assert np.isinf(cuts.distance[NORTH, 0, -1])


def test_of_two_crossings_each_node_sees_the_nearer():
    cuts = cut((2.25, 0.5), (2.25, 2.5), (2.5, 2.5), (2.5, 0.5))
    assert cuts.distance[EAST, 2, 1] == pytest.approx(0.25)
    assert cuts.distance[WEST, 3, 1] == pytest.approx(0.5)


def test_a_curve_through_a_node_is_seen_on_all_sides():
    cuts = cut((1.5, 1.5), (2.5, 2.5))
    assert (cuts.distance[:, 2, 2] == NEAREST).all()
    for direction, i, j in ((EAST, 1, 2), (WEST, 3, 2), (NORTH, 2, 1), (SOUTH, 2, 3)):
        assert cuts.crossing[direction, i, j] >= 0
        assert cuts.distance[direction, i, j] == 1.0


def test_a_segment_along_a_line_cuts_where_it_ends_and_holds_its_nodes():
    cuts = cut((1.5, 2.0), (3.5, 2.0))
    assert cuts.distance[EAST, 1, 2] == pytest.approx(0.5)
    assert cuts.distance[WEST, 4, 2] == pytest.approx(0.5)
    assert (cuts.distance[NORTH, 2:4, 2] == NEAREST).all()
    assert (cuts.distance[SOUTH, 2:4, 2] == NEAREST).all()
    assert (cuts.crossing[NORTH, 2:4, 1] >= 0).all()


def test_no_line_slips_through_where_segments_meet():
    cuts = cut((2.3, 0.7), (2.6, 2.0), (2.2, 3.4))
    assert cuts.crossing[EAST, 2, 2] >= 0
    assert cuts.distance[EAST, 2, 2] == pytest.approx(0.6)


def test_a_curve_outside_the_grid_cuts_nothing():
    assert (cut((-3.0, -3.0), (-1.0, 9.0)).crossing < 0).all()


def test_a_point_is_enclosed_where_a_ray_crosses_an_odd_number_of_times():
    square = np.array([[0, 0], [4, 0], [4, 4], [0, 4]], dtype=float)
    hole = 0.25 * square + 1.0
    rings = [np.stack([ring, np.roll(ring, -1, axis=0)], axis=1) for ring in (square, hole)]
    inside = encloses(np.concatenate(rings), np.array([[0.5, 0.5], [1.5, 1.5], [5.0, 1.0]]))
    assert inside.tolist() == [True, False, False]
