"""The table that a scan stands on: found, and cut away."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.scan.cleaning import largest_body
from touchwarp.scan.deviation import diagonal, face_areas, face_normals, sample
from touchwarp.scene.surface import Surface

Float = NDArray[np.float64]

DRAWS = 2_000
"""RANSAC planes, each through a point of the surface along its normal there."""
SAMPLES = 4_000
THICKNESS = 0.004
"""Of the diagonal: how far off the plane the scanned table may lie."""
LEAST_SHARE = 0.15
"""Of the area: a table has at least so much."""
LEAST_STANDING = 0.005
"""Of the area: so much stands on it at least; a hammer on a square metre of table is 3 %."""
WIDER = 1.6
"""A table reaches at least this much farther than what stands on it, by area of the box around."""
STEEP = np.cos(np.radians(25))
CLEAR = 2.0
"""Thicknesses off the plane beyond which nothing is table."""
CUT = 4.0
"""Standard deviations of the table's noise above the plane where the object is cut off: the floor
of a cup may lie 2 mm above the table."""


@dataclass(frozen=True, eq=False)
class Tabletop:
    """A scan without the table it stood on.

    Attributes:
        surface: the object, open where it stood; m, the scan's frame.
        point, normal: (3,) the table's plane; the normal points to the object's side.
        share: the part of the scan's area that was table.
    """

    surface: Surface
    point: Float
    normal: Float
    share: float


def crop_tabletop(surface: Surface, seed: int = 0) -> Tabletop | None:
    """Find the table of a scan and cut it away; None where the scan shows no table.

    A table is the plane with the most area in it (RANSAC, Fischler and Bolles 1981, then least
    squares), if that is at least 15 % of all, everything else lies on one side of it, and it
    reaches beyond what stands on it: so a box's own bottom is no table.

    Args:
        surface: m.
        seed: of the random draws.
    """
    random = np.random.default_rng(seed)
    points, face = sample(surface, SAMPLES, random)
    normals = face_normals(surface)[face]
    thickness = THICKNESS * diagonal(surface)
    best = np.zeros(SAMPLES, dtype=np.bool_)
    for i in random.integers(SAMPLES, size=DRAWS):
        off = np.abs((points - points[i]) @ normals[i]) < thickness
        flat = off & (np.abs(normals @ normals[i]) > STEEP)
        if flat.sum() > best.sum():
            best = flat
    if best.mean() < LEAST_SHARE:
        return None
    point, normal = _fitted(points[best])
    height = (points - point) @ normal
    beyond = np.abs(height) > CLEAR * thickness
    if beyond.mean() < LEAST_STANDING:
        return None
    normal = normal if height[beyond].mean() > 0 else -normal
    height = (points - point) @ normal
    below = height < -CLEAR * thickness
    if below.mean() > 0.02 or not _reaches_beyond(points[best], points[beyond & ~below], normal):
        return None
    noise = 1.4826 * float(np.median(np.abs(height[best])))  # of a normal distribution
    cut = min(CUT * noise + 1e-3 * thickness, CLEAR * thickness)
    heights = (surface.vertices - point) @ normal
    above = heights[surface.faces].max(axis=1) > cut
    # what is left of the foot goes down onto the table, where a flat cap can close it
    foot = np.where(heights < cut, heights, 0.0)
    standing = Surface(surface.vertices - foot[:, None] * normal, surface.faces[above])
    area = face_areas(surface)
    return Tabletop(largest_body(standing), point, normal, float(area[~above].sum() / area.sum()))


def _fitted(points: Float) -> tuple[Float, Float]:
    """The plane of least squares: its centroid and unit normal."""
    centre = points.mean(axis=0)
    return centre, np.linalg.svd(points - centre, full_matrices=False)[2][2]


def _reaches_beyond(table: Float, above: Float, normal: Float) -> bool:
    """Whether the table's points spread wider than the points that stand above it."""
    side = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    side /= np.linalg.norm(side)
    plane = np.stack([side, np.cross(normal, side)], axis=1)
    spreads = [np.prod(np.ptp(points @ plane, axis=0)) for points in (table, above)]
    return bool(spreads[0] > WIDER * spreads[1])
