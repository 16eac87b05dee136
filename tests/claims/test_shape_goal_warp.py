"""A warp made for a goal to another shape shows a touching finger on that shape."""

from __future__ import annotations

import numpy as np
import pytest

import touchwarp as tw
from touchwarp.goals.surface_samples import sample_surface
from touchwarp.scene.shapes import fillet_box

PROP, VIRTUAL = (fillet_box((0.1, 0.1, 0.1), radius) for radius in (0.01, 0.03))
FILLET = tw.Patch((1, 1, 0), (0.05, 0.02, 0))


@pytest.fixture(scope="module")
def scene() -> tw.Scene:
    goal = tw.PlaneProjectionGoal(VIRTUAL, patches=[FILLET])
    objective = tw.Objective(tolerance_mm=0.5)
    return tw.Scene([tw.Prop("block", PROP, goal)], objective=objective)


def off_the_fillet(points: np.ndarray) -> np.ndarray:
    """m: distances of points near the edge at +x, +y from the rounding of 30 mm."""
    return np.abs(np.linalg.norm(points[:, :2] - 0.02, axis=1) - 0.03)


def test_a_finger_on_the_edge_shows_on_the_rounder_edge(scene: tw.Scene) -> None:
    warp = tw.solve(scene)
    goal = tw.goals(scene)["block"]
    samples = sample_surface(goal, 200_000, np.random.default_rng(0))
    on_edge = (samples.points[:, :2] > 0.021).all(axis=1) & (np.abs(samples.points[:, 2]) < 0.048)
    touched = samples.points[on_edge]
    assert len(touched) > 10_000
    missed = off_the_fillet(warp(touched))
    assert np.percentile(missed, 99) < 2e-4
    assert missed.max() < 5e-4
    assert np.percentile(off_the_fillet(touched), 50) > 1e-3  # the twin: with no warp it misses
