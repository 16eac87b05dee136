"""The search for a map between two surfaces of genus 2 or more: several classes, coarse to fine.

On the hyperbolic surface a map cannot be turned or shifted; instead there are many classes of maps,
none of which can be deformed into another. Those that nearest points suggest, and then those that
keep handles handles and tunnels tunnels, by their springs' energy, are laid over the virtual
surface and refined on a few vertices; the best go on.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from touchwarp.errors import GoalError
from touchwarp.goals.maps.hyperbolic.coarsened import Regrown
from touchwarp.goals.maps.hyperbolic.layout import HyperbolicLayout
from touchwarp.goals.maps.hyperbolic.mapping_classes import near_moves
from touchwarp.goals.maps.hyperbolic.marking import Marking
from touchwarp.goals.maps.hyperbolic.nearest_class import nearest_classes
from touchwarp.goals.maps.hyperbolic.parameterise import SOUND
from touchwarp.goals.maps.hyperbolic.words import Word
from touchwarp.goals.maps.layout import Layout
from touchwarp.goals.maps.search import (
    COARSE_STEPS,
    COARSEST,
    GROWTH,
    Found,
    Pair,
    Plan,
    Progress,
)

MOST_CLASSES = 40
MOST_STEPS = 60
FARTHEST = 20.0
"""Classes whose springs have more than so many times the least energy only lead to others."""
FIRST_STEPS, FIRST_AREA, FIRST_ENOUGH = 15, 2.0, 1e-3
MIDDLE_STEPS, FINE_STEPS = 40, 5
RELAXING_ROUNDS = 40


@dataclass(frozen=True, eq=False)
class MarkedPair(Pair):
    """Two surfaces of genus 2 or more; the prop has no places yet.

    Attributes:
        marking: of the prop.
        virtual_marking: of the virtual object.
    """

    marking: Marking = field(kw_only=True)
    virtual_marking: Marking = field(kw_only=True)

    def search(self, plan: Plan, progress: Progress | None = None) -> Found:
        """The best map found; see `search_classes`."""
        return search_classes(self, plan, progress)


def search_classes(pair: MarkedPair, plan: Plan, progress: Progress | None = None) -> Found:
    """The best map of all classes tried, refined on the prop's whole mesh.

    Args:
        pair: the surfaces.
        plan: weights and starts; there is nothing random.
        progress: called with the step's name and the part of it that is done.

    Raises:
        GoalError: no class gives a map.
    """

    def tell(step: str, done: float) -> None:
        if progress is not None:
            progress(step, done)

    virtual, marking = pair.virtual, pair.marking
    assert isinstance(virtual, HyperbolicLayout)
    tried: list[tuple[float, HyperbolicLayout]] = []
    for k, images in enumerate(classes(marking, pair.virtual_marking)):
        tell("first maps", k / MOST_CLASSES)
        first = marking.lay_coarse(images, virtual.deck)
        grown = marking.coarsened.regrow(first)
        grown.relax(RELAXING_ROUNDS)
        chosen, layout = grown.now()
        if not (layout.shares > 0).all():
            continue  # the class is so far that rounding turns triangles over
        problem = pair.problem(layout, chosen)
        refined: Layout = layout
        for area in (FIRST_AREA, plan.weights.area):
            weights = replace(plan.easiest, area=area)
            refined = problem.refine(refined, weights, FIRST_STEPS, FIRST_ENOUGH)
        energy = problem.energy(refined, plan.easiest)
        if np.isfinite(energy):
            first = first.moved(refined.points)
            tried.append((energy, first))
    if not tried:
        raise GoalError(
            "no map between the prop and the virtual object was found; turn or remesh one of both."
        )
    tried.sort(key=lambda each: each[0])
    energies = []
    best: Regrown | None = None
    firsts = tried[: plan.starts]
    for k, (_, first) in enumerate(firsts):
        tell("coarse maps", k / len(firsts))
        grown = marking.coarsened.regrow(first.gathered())
        grown.put_back(COARSEST)
        energies.append(_coarse(pair, plan, grown))
        if energies[-1] <= min(energies):
            best = grown
    assert best is not None
    weights = plan.fine_weights
    sound = int(SOUND * len(best.points))
    while not best.whole:
        if best.count >= sound:
            best.put_back(len(best.points))
        else:
            best.put_back(min(GROWTH * best.count, sound))
        chosen, layout = best.now()
        steps = FINE_STEPS if best.whole else MIDDLE_STEPS
        problem = pair.problem(layout, chosen)
        refined = problem.refine(
            layout, weights, steps, progress=lambda done: tell("fine map", done)
        )
        best.points[chosen] = refined.points
    tell("fine map", 1.0)
    return Found(best.finish().gathered(), energies, pair.size)


def classes(marking: Marking, virtual: Marking) -> Iterator[dict[int, Word]]:
    """Images of the classes to try: those of nearest points, then others, laxest springs first.

    Moves that keep handles handles and tunnels tunnels lead from class to class; of those reached,
    the laxest is always the next.
    """
    springs = marking.springs
    moves = near_moves(springs.mesh.genus)
    least = springs.energy(marking.images)
    seen = set()
    queue: list[tuple[float, int, dict[int, Word]]] = []
    found = 0
    for images in nearest_classes(marking, virtual):
        key = springs.key(images)
        if key not in seen:
            seen.add(key)
            heapq.heappush(queue, (-1.0, len(seen), images))
    key = springs.key(marking.images)
    if key not in seen:
        seen.add(key)
        heapq.heappush(queue, (least, len(seen), marking.images))
    for _ in range(MOST_STEPS):
        if not queue or found == MOST_CLASSES:
            return
        energy, _, images = heapq.heappop(queue)
        if energy < FARTHEST * least:
            found += 1
            yield images
        for move in moves.values():
            reached = springs.moved(images, move)
            key = springs.key(reached)
            if key not in seen:
                seen.add(key)
                heapq.heappush(queue, (springs.energy(reached), len(seen), reached))


def _coarse(pair: Pair, plan: Plan, grown: Regrown) -> float:
    """Refine the coarsest level along the plan's path; its energy at the end."""
    chosen, first = grown.now()
    problem = pair.problem(first, chosen)
    layout: Layout = first
    for weights in plan.path():
        layout = problem.refine(layout, weights, COARSE_STEPS)
    grown.points[chosen] = layout.points
    return problem.energy(layout, plan.weights)
