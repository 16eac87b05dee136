"""Sharp edges that are felt and seen apart: distances and lost lengths of boxes, in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.goals.hand_made_maps import cube_map, identity_map
from touchwarp.goals.edge_mismatch import EdgeMismatch, edge_mismatch
from touchwarp.scene.shapes import box, sphere

BOX = box([0.1, 0.1, 0.1])


def mismatch(goal) -> EdgeMismatch:
    return edge_mismatch(goal, goal.virtual_surface, 0)


def test_the_same_box_has_the_same_edges() -> None:
    found = mismatch(identity_map(BOX))
    assert found.felt_length == found.seen_length == pytest.approx(1.2)
    assert max(found.felt.max(), found.seen.max()) < 1e-12
    assert (found.lost, found.new, found.offset) == (0.0, 0.0, pytest.approx(0.0, abs=1e-12))


def test_a_shifted_box_has_shifted_edges() -> None:
    found = mismatch(identity_map(BOX, shift=[3e-3, 0, 0]))
    # eight edges are off by 3 mm; of four, a part of 3 mm sticks out by 1.5 mm on average; of the
    # edges on one side, ends of 3 mm are nearer to another edge, by 1.5 mm on average
    expected = (8 * 3.0 + 4 * 0.03 * 1.5 - 8 * 0.03 * 1.5) / 12
    assert 1e3 * found.offset == pytest.approx(expected, rel=0.01)
    assert 1e3 * mismatch(identity_map(BOX, shift=[4e-3, 0, 0])).offset > 1.2 * expected
    assert found.lost == found.new == 0.0


def test_edges_beyond_a_fingertip_are_lost_and_new() -> None:
    found = mismatch(identity_map(BOX, shift=[0, 0, 0.02]))
    # all of the top edges; of the bottom ones all but the ends that are within 8 mm of an upright
    # edge; of the upright ones the 20 mm that stick out, less the 8 mm beside the corner
    level = 4 * 0.1 + 4 * (0.1 - 2 * 0.008)
    upright = 4 * (0.02 - 0.008)
    assert found.lost == pytest.approx((level + upright) / 1.2, abs=0.01)
    assert found.new == pytest.approx(found.lost, abs=0.01)


def test_a_ball_has_none() -> None:
    found = mismatch(cube_map())
    assert found.felt_length == pytest.approx(12 * 0.08)
    assert found.lost == 1.0
    assert found.seen_length == 0.0
    assert found.new == 0.0
    assert math.isnan(found.offset)
    assert np.isinf(found.felt).all()


def test_without_edges_nothing_is_lost() -> None:
    found = mismatch(identity_map(sphere(0.05, 0.05)))
    assert (found.lost, found.new) == (0.0, 0.0)
