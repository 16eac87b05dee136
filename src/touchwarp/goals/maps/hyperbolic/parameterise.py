"""From a mesh of genus 2 or more to its area-preserving layout on the hyperbolic surface."""

from __future__ import annotations

from touchwarp.goals.maps.areas import polish_areas, spread, target_shares
from touchwarp.goals.maps.hyperbolic.coarsened import Regrown
from touchwarp.goals.maps.hyperbolic.deck import Deck
from touchwarp.goals.maps.hyperbolic.layout import HyperbolicLayout
from touchwarp.goals.maps.hyperbolic.marking import Marking

POLISHES, AREA_AIM = 3, 4e-3
SOUND = 0.7
"""Of all vertices: those that stay this long make no needles."""
GROWTH = 1.4
"""After so much growth all vertices relax."""
FEW, ROUNDS_OF_FEW, ROUNDS, ROUNDS_BETWEEN = 1500, 40, 6, 30


def lay_out(marking: Marking, deck: Deck) -> HyperbolicLayout:
    """The mesh's layout, with each triangle's share of the area about its share of the surface.

    Areas are polished where there are no needles, which would hold back all others; these return
    at the end.

    Raises:
        GoalError: a triangle would be turned over.
    """
    grown = marking.coarsened.regrow(marking.lay_coarse(marking.images, deck))
    sound = int(SOUND * len(grown.points))
    while True:
        grown.relax(ROUNDS_OF_FEW if grown.count < FEW else ROUNDS)
        if grown.count >= sound:
            break
        grown.put_back(min(sound, int(GROWTH * grown.count) + 1), around=True)
    _polish(grown)
    return grown.finish().gathered()


def _polish(grown: Regrown) -> None:
    for _ in range(POLISHES):
        chosen, layout = grown.now()
        target = target_shares(layout.mesh.face_areas)
        polished = polish_areas(layout, target, AREA_AIM)
        grown.points[chosen] = polished.points
        if spread(polished.shares, target) <= AREA_AIM:
            break
        grown.relax(ROUNDS_BETWEEN)  # a needle that stopped the steps of all gets out of the way
