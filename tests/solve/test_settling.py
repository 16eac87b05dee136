"""Cycling ends when u is settled; if it never is, the message tells what was measured."""

import numpy as np
import pytest

from tests.claims.multigrids import solve_exact
from tests.exact.sources import PointSources
from touchwarp.errors import SolveError
from touchwarp.scene import shapes
from touchwarp.solve import settling
from touchwarp.solve.settling import settle

IN_METRES = np.array([1.0, 1.0, 1.0, 0.0], np.float32)
ENOUGH = 2e-6


@pytest.fixture
def disturbed():
    """A converged solution, and the grid with a millimetre's disturbance of it."""
    source = PointSources(np.array([[0.003, 0.001, 0.002]]), np.full((1, 3), 1e-4))
    box = np.array([[-0.2] * 3, [0.2] * 3])
    grid, _ = solve_exact(shapes.sphere(0.05), source.displacement, box, 1)
    for _ in range(10):
        grid.cycle()
    finest = grid.stages[-1]
    exact = finest.u.copy()
    inner = slice(finest.level.n_inner)
    finest.u[inner, :3] += np.random.default_rng(0).uniform(-1e-3, 1e-3, finest.u[inner, :3].shape)
    return grid, exact


def test_what_is_left_is_less_than_what_was_asked_for(disturbed):
    grid, exact = disturbed
    residuals, changes = settle(grid, IN_METRES, ENOUGH)
    assert len(residuals) == len(changes) + 1
    assert np.abs(grid.stages[-1].u - exact).max() < ENOUGH


def test_one_cycle_would_have_left_more(disturbed):
    grid, exact = disturbed
    grid.cycle()
    assert np.abs(grid.stages[-1].u - exact).max() > ENOUGH


def test_no_convergence_tells_its_history(disturbed, monkeypatch):
    monkeypatch.setattr(settling, "MOST_CYCLES", 1)
    with pytest.raises(SolveError, match=r"No convergence in 1 cycles \(change of u in mm: .*; 0 "):
        settle(disturbed[0], IN_METRES, 0.0)
