"""Where sharp edges are felt but not seen, or seen but not felt.

The measure is of lines, not of angles: an edge that turns by 31° counts as one that turns by 90°.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from touchwarp.goals.fingertip_curvature import FINGERTIP_RADIUS
from touchwarp.goals.goal import Goal
from touchwarp.goals.surface_samples import find_sharp_edges
from touchwarp.goals.surface_tree import SurfaceTree
from touchwarp.scene.surface import Surface

Float = NDArray[np.float64]

SAMPLES = 10_000


class EdgeMismatch(NamedTuple):
    """Distances between the images of the prop's sharp edges and the virtual surface's own.

    Attributes:
        felt_points: (n, 3) m: points of the prop's sharp edges, uniform in length.
        felt: (n,) m: from their images to the nearest sharp edge of the virtual surface; inf where
            it has none.
        felt_length: m, of the prop's sharp edges.
        seen_points: (k, 3) m: points of the virtual surface's sharp edges, uniform in length.
        seen: (k,) m: from them to the nearest image of a sharp edge of the prop; inf where it has
            none.
        seen_length: m, of the virtual surface's sharp edges.
    """

    felt_points: Float
    felt: Float
    felt_length: float
    seen_points: Float
    seen: Float
    seen_length: float

    @property
    def lost(self) -> float:
        """Share of the felt edges' length with no seen edge within a fingertip's radius."""
        return _share_beyond(self.felt)

    @property
    def new(self) -> float:
        """Share of the seen edges' length with no felt edge within a fingertip's radius."""
        return _share_beyond(self.seen)

    @property
    def offset(self) -> float:
        """Mean distance, m, of the edges that have a partner; NaN where none has."""
        paired = np.concatenate([self.felt, self.seen])
        paired = paired[paired <= FINGERTIP_RADIUS]
        return float(paired.mean()) if len(paired) else float("nan")


def edge_mismatch(goal: Goal, virtual: Surface, seed: int) -> EdgeMismatch:
    """Compare the edges that turn by more than 30°, and open rims, of both surfaces."""
    own = find_sharp_edges(goal.prop_points, goal.faces)
    other = find_sharp_edges(virtual.vertices, virtual.faces)
    rng = np.random.default_rng(seed)
    felt_points, images = own.sample(goal, SAMPLES, rng)
    itself = Goal(virtual.vertices, virtual.vertices, virtual.faces)
    seen_points, _ = other.sample(itself, SAMPLES, rng)
    return EdgeMismatch(
        felt_points=felt_points,
        felt=_distance(images, virtual.vertices, other.ends),
        felt_length=float(own.length.sum()),
        seen_points=seen_points,
        seen=_distance(seen_points, goal.virtual_points, own.ends),
        seen_length=float(other.length.sum()),
    )


def _distance(points: Float, vertices: Float, ends: NDArray[np.int64]) -> Float:
    if len(ends) == 0:
        return np.full(len(points), np.inf)
    return SurfaceTree(vertices, ends).nearest(points).distance


def _share_beyond(distance: Float) -> float:
    return float((distance > FINGERTIP_RADIUS).mean()) if len(distance) else 0.0
