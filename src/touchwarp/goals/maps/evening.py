"""The weight of areas raised, where a map's areas spread too much, until they no longer do.

Of all maps with one spread of area ratios the one wanted is that whose other terms are least. The
search's energy finds it: its barrier is the square of that spread, to second order, and the weight
the multiplier. Which weight belongs to a spread depends on the shapes, so it is raised step by
step, each time refining the map that is there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from touchwarp.goals.goal import Goal
from touchwarp.goals.maps.areas import spread, target_shares
from touchwarp.goals.maps.layout import Layout
from touchwarp.goals.maps.refine import Weights
from touchwarp.goals.maps.search import Pair

WANTED = 0.15
"""The spread of area ratios on the goal's triangles that is small enough."""
AIM = 0.97
"""Of `WANTED`, lest most of a last step be for a hair."""
LEAST_GROWTH, MOST_GROWTH = 1.15, 2.0
"""Of the weight, at a time."""
MOST = 16.0
"""The weight is raised no farther."""
STEPS = 20
LEAST_GAIN = 0.1
"""What a step must take of the spread beyond `WANTED`, or it moves points for nothing."""


@dataclass(frozen=True, eq=False)
class Evened:
    """A goal, the weight of areas that it has, and why it has that."""

    goal: Goal
    area_weight: float
    reason: str


def even_areas(
    pair: Pair, layout: Layout, weights: Weights, make: Callable[[Layout, Weights], Goal]
) -> Evened:
    """The goal of a map, its areas evened out if they spread too much.

    A goal that is hardly better than the one before, or has more folds, ends it: the one before
    counts. So it does where the spread is not of the map but of its straight lines within faces.

    Args:
        pair: the surfaces.
        layout: the map found, the prop's mesh over `pair.virtual`.
        weights: of the energy that found it.
        make: the goal of a map that was found with such weights, measured.
    """
    goal, first = make(layout, weights), weights.area
    start = f"at {first:g} areas spread by {goal.report['area_std']:.2g}"
    if goal.report["area_std"] <= WANTED:
        return Evened(goal, first, start)
    problem = pair.problem(layout, np.arange(len(layout.points)))
    target = target_shares(layout.mesh.face_areas)
    higher = weights
    while goal.report["area_std"] > WANTED:
        if higher.area >= MOST:
            return Evened(goal, weights.area, f"{start}; it goes no farther than {MOST:g}")
        # What the domain does not show of the goal's spread is taken to be the same part of it.
        now = spread(layout.shares, target)
        enough = AIM * WANTED * now / goal.report["area_std"]
        while higher.area < MOST and now > enough:
            growth = np.clip(now / enough, LEAST_GROWTH, MOST_GROWTH)
            higher = replace(higher, area=min(float(growth) * higher.area, MOST))
            layout = problem.refine(layout, higher, STEPS)
            now = spread(layout.shares, target)
        tried = make(layout, higher)
        if not _better(tried, goal):
            return Evened(goal, weights.area, f"{start}; {higher.area:.3g} is hardly better")
        goal, weights = tried, higher
    return Evened(goal, weights.area, start)


def _better(one: Goal, other: Goal) -> bool:
    excess = [goal.report["area_std"] - WANTED for goal in (one, other)]
    unfolded = one.report["flips"] <= other.report["flips"]
    return bool(unfolded and excess[0] <= (1 - LEAST_GAIN) * excess[1])
