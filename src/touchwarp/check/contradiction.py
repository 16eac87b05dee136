"""Where a fixed surface forbids what a goal asks for, so that contact cannot be kept.

A table lets nothing through, and a goal may lift the foot of a prop that stands on it. Near the
line of contact one is then blended into the other over the fixed surface's `blend_mm`: no warp can
meet such a goal there, and to say so is something else than to find a warp wanting.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from touchwarp.check.region import Body, Region
from touchwarp.goals.surface_samples import SurfaceSamples
from touchwarp.scene.scene import Fixed, Scene

Float = NDArray[np.float64]
Bool = NDArray[np.bool_]

TOUCHING = 1e-5
"""m: samples of a prop nearer than this to a fixed surface touch it. A rounded foot that a goal
stretches ten times contradicts its table by less than a tenth of a millimetre so near to it."""

PITCH = 5e-4
"""m: samples that touch closer together than this add nothing."""


@dataclass(frozen=True, eq=False)
class Contradiction:
    """One fixed surface that forbids part of one prop's goal.

    Attributes:
        fixed: the surface.
        forbidden: m, the greatest displacement asked for at the contact that it does not let be.
    """

    fixed: Fixed
    forbidden: float
    _hold: Body | None
    _feet: cKDTree
    _contradicted: Bool

    def at(self, points: Float) -> Bool:
        """(n,) whether at (n, d) points of the prop, m, the goal gives way to the surface.

        Those within its `blend_mm` whose nearest point of contact is forbidden its goal.
        """
        near = np.flatnonzero(
            _distance(self.fixed, self._hold, points) < 1e-3 * self.fixed.blend_mm
        )
        result = np.zeros(len(points), bool)
        foot = self._feet.query(points[near], workers=-1)[1]
        result[near] = self._contradicted[foot]
        return result


def find_contradictions(
    scene: Scene, region: Region, samples: SurfaceSamples, tolerance: float
) -> tuple[Contradiction, ...]:
    """The fixed surfaces that forbid one prop's goal more than `tolerance`, m, where they touch it.

    What a sliding plane forbids is the part of g(x) − x along its normal, a held surface all of it.

    Args:
        scene: of the fixed surfaces.
        region: of the held ones' distances.
        samples: of the prop.
        tolerance: m, what a table may miss anyway.
    """
    found = []
    for fixed in scene.fixed:
        hold = next((body for body in region.holds if body.name == fixed.name), None)
        touching = np.flatnonzero(_distance(fixed, hold, samples.points) < TOUCHING)
        if len(touching) == 0:
            continue
        cells = np.floor(samples.points[touching] / PITCH).astype(np.int64)
        touching = touching[np.unique(cells, axis=0, return_index=True)[1]]
        asked = samples.targets[touching] - samples.points[touching]
        if fixed.contact == "slide":
            assert fixed.plane is not None, "only planes slide"
            forbidden = np.abs(asked @ np.asarray(fixed.plane[1]))
        else:
            forbidden = np.linalg.norm(asked, axis=1)
        if forbidden.max() > tolerance:
            feet = cKDTree(samples.points[touching])
            found.append(
                Contradiction(fixed, float(forbidden.max()), hold, feet, forbidden > tolerance)
            )
    return tuple(found)


def _distance(fixed: Fixed, hold: Body | None, points: Float) -> Float:
    """(n,) m, from (n, d) points to a fixed surface; inf where that is beyond its blend."""
    if fixed.plane is not None:
        point, normal = (np.asarray(v) for v in fixed.plane)
        away: Float = np.abs((points - point) @ normal)
        return away
    assert hold is not None
    distance = np.full(len(points), np.inf)
    reach = max(1e-3 * fixed.blend_mm, TOUCHING)
    low, high = hold.vertices.min(axis=0) - reach, hold.vertices.max(axis=0) + reach
    close = ((points >= low) & (points <= high)).all(axis=1)
    distance[close] = hold.nearest(points[close])[0]
    return distance
