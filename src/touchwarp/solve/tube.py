"""The tube around edges, rims and thin walls, in which only contact is promised."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from touchwarp.solve.cuts import cut_along
from touchwarp.solve.frame import Frame
from touchwarp.solve.level import beside
from touchwarp.solve.multigrid import Stage
from touchwarp.solve.region import Region
from touchwarp.solve.threads import threads


@dataclass(eq=False)
class Tube:
    """All points within `radius` m of the given points (k, 3) m, scene frame."""

    points: NDArray[np.float64]
    radius: float

    def __post_init__(self) -> None:
        self._tree = cKDTree(self.points) if len(self.points) else None

    def contains(self, points: NDArray[np.float64], margin: float = 0.0) -> NDArray[np.bool_]:
        """(n,) for points (n, 3) m, scene frame; `margin`: m from the border, that are not."""
        radius = self.radius - margin
        if self._tree is None or len(points) == 0 or radius <= 0.0:
            return np.zeros(len(points), bool)
        distance, _ = self._tree.query(
            points, distance_upper_bound=radius, workers=threads() if len(points) > 1000 else 1
        )
        return np.asarray(np.isfinite(distance))

    def greatest_outside(
        self,
        frame: Frame,
        stages: list[Stage],
        regions: list[Region],
        errors: list[NDArray[np.float32]],
        least: float,
    ) -> float:
        """m: the greatest of a field's errors in Ω outside the tube; 0 where all are below `least`.

        `errors` has (n,) m for each stage.
        """
        worst = 0.0
        for stage, region, size in zip(stages, regions, errors, strict=True):
            nodes = np.flatnonzero((region == 1) & (size > least))
            if stage.level.depth < 0 or len(nodes) == 0:
                continue
            where = stage.level.coordinates(nodes) / 2.0**stage.level.depth
            outside = ~self.contains(frame.to_scene(where))
            worst = max(worst, float(size[nodes][outside].max(initial=0.0)))
        return worst

    def with_thin_parts(self, finest: Stage, region: Region, frame: Frame) -> Tube:
        """The tube with the finest level's thin walls and sheets added."""
        cuts = finest.cuts
        if len(cuts.node) == 0:
            return self
        thin = _thin(finest.level.places, cuts, region)
        nodes = cuts.node[thin]
        if len(nodes) == 0:
            return self
        coordinates = finest.level.coordinates(nodes) / 2.0**finest.level.depth
        return Tube(np.concatenate([self.points, frame.to_scene(coordinates)]), self.radius)


@njit(cache=True, nogil=True)
def _thin(places, cuts, region):
    """Nodes in Ω whose edge is cut though its other end is in Ω, or whose wall has one node."""
    node, around, site = places.node, places.around, places.site
    row, start, direction = cuts.row, cuts.start, cuts.direction
    result = np.zeros(len(cuts.node), np.bool_)
    for r in range(len(cuts.node)):
        m = cuts.node[r]
        if m >= places.n_inner:
            continue
        if region[m] == 1:
            for k in range(start[r], start[r + 1]):
                if region[beside(node, around, site[m], direction[k])] == 1:
                    result[r] = True
        elif region[m] == 0:
            for d in range(0, 6, 2):
                if (
                    cut_along(row, start, direction, m, d) >= 0
                    and cut_along(row, start, direction, m, d + 1) >= 0
                    and region[beside(node, around, site[m], d)] == 1
                    and region[beside(node, around, site[m], d + 1)] == 1
                ):
                    result[r] = True
    return result
