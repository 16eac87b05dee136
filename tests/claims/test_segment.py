"""Claim: on the segment of eq. 9 the cut-end solve is second order, wherever its ends lie."""

import numpy as np
import pytest

from tests.exact import segment as exact
from tests.exact.order import observed_order
from touchwarp.solve.segment import Segment, solve_segment

START, STOP, MOVED, BACK = 0.0513, 0.4371, 0.02, -0.005
SPACINGS = np.array([8e-3, 4e-3, 2e-3, 1e-3, 0.5e-3])
ORIGINS = np.linspace(0, 1, 8, endpoint=False)  # of a spacing: ends are cut at eight places


def max_error(spacing, screening, wall_shift=0):
    """Largest error at the nodes, averaged over eight places of the lattice, m."""
    moved_wall = Segment(START - wall_shift * spacing, STOP, MOVED, BACK, screening)
    errors = []
    for origin in ORIGINS * spacing:
        x, u = solve_segment(moved_wall, spacing, origin)
        kept = x > START
        truth = exact.displacement(x[kept], START, STOP, MOVED, BACK, screening)
        errors.append(np.abs(u[kept] - truth).max())
    return np.mean(errors)


@pytest.mark.parametrize("screening", [10.0, 100.0, 1000.0])
def test_cut_ends_are_second_order_against_eq_9(screening):
    errors = [max_error(spacing, screening) for spacing in SPACINGS]
    assert observed_order(SPACINGS, errors) == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize("screening", [10.0, 100.0, 1000.0])
def test_order_claim_rejects_a_wall_one_node_off(screening):
    errors = [max_error(spacing, screening, wall_shift=1) for spacing in SPACINGS]
    assert observed_order(SPACINGS, errors) < 1.5


def test_without_a_mismatch_weight_the_solve_is_exact():
    assert max_error(8e-3, 0.0) < 1e-15


def test_exactness_claim_rejects_a_wall_one_node_off():
    assert max_error(8e-3, 0.0, wall_shift=1) > 1e-5
