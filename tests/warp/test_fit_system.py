"""The contact fit's second step: nodes in Ω give way near edges, and what is far off stays."""

import numpy as np
import pytest

import touchwarp as tw
from touchwarp.scene import Outer, shapes
from touchwarp.warp import fit_system
from touchwarp.warp.table_error import _quantile

GOAL = tw.TransformGoal(scale=(1.15, 0.9, 1.1), rotation_deg=(0, 0, 8))


def contact(monkeypatch, rings):
    """The fitted table of a coarse box, and its contact error."""
    monkeypatch.setattr(fit_system, "RINGS", rings)
    box = tw.Prop("box", shapes.box((0.1, 0.1, 0.1)), GOAL)
    warp = tw.solve(
        tw.Scene([box], Outer(box_scale=4.0), tw.Objective(tolerance_mm=0.5, edge_radius_mm=4.0))
    )
    return warp.bricks.values, warp.solution.contact_p99_mm


def test_nodes_near_the_tube_do_for_the_second_fit(monkeypatch):
    values, p99 = contact(monkeypatch, fit_system.RINGS)
    every, least = contact(monkeypatch, 50)
    assert p99 == pytest.approx(least, rel=1e-4)
    assert np.abs(values - every).max() < 2e-6


def test_without_their_neighbours_they_would_not(monkeypatch):
    _, p99 = contact(monkeypatch, 0)
    _, least = contact(monkeypatch, 50)
    assert p99 > 1.02 * least


@pytest.mark.parametrize("seed", range(5))
def test_quantile_is_that_of_all_values_sorted(seed):
    rng = np.random.default_rng(seed)
    size, weight = rng.exponential(1e-4, 1000), rng.uniform(0.1, 1.0, 1000)
    order = np.argsort(size)
    share = np.cumsum(weight[order])
    expected = size[order[np.searchsorted(share, 0.99 * share[-1])]]
    assert _quantile(size, weight, 0.99) == expected


def test_quantile_of_nothing_but_zeros():
    assert _quantile(np.zeros(7), np.ones(7), 0.99) == 0.0
