"""Flat cuts through Ω: outlines, and the warp on a lattice of points in the cut."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.check.case import Case, PropCase
from touchwarp.check.probes import determinants, singular_values

Float = NDArray[np.float64]

PIXELS = 260
"""Along the longer side of a cut."""

_MARGIN = 0.55
"""Of the objects' longest side, around them."""

_UNDER = 0.15
"""Of the margin, shown under a level fixed plane."""

AXES = "xyz"


@dataclass(frozen=True, eq=False)
class Slice:
    """One cut.

    Attributes:
        title: what it shows.
        axes: the two axes in the picture.
        fixed: the third axis's place, m; None in the plane.
        low, high: (2,) m, the picture's corners.
        felt, seen: segments (s, 2, 2) m, where the cut meets props and virtual objects.
        points: (rows, columns, d) m, scene frame, pixel centres, lowest row first.
        in_region: (rows, columns) whether in Ω.
        displayed: (rows, columns, d) m: f there.
        gain_high, gain_low, determinant: (rows, columns).
        ground: height of a horizontal fixed plane in the picture, or None.
    """

    title: str
    axes: tuple[int, int]
    fixed: float | None
    low: Float
    high: Float
    felt: Float
    seen: Float
    points: Float
    in_region: NDArray[np.bool_]
    displayed: Float
    gain_high: Float
    gain_low: Float
    determinant: Float
    ground: float | None

    def place(self, flat: Float) -> Float:
        """Points (n, 2) m of the picture in the scene, (n, d) m."""
        d = self.points.shape[-1]
        points = np.empty((len(flat), d))
        points[:, self.axes[0]], points[:, self.axes[1]] = flat[:, 0], flat[:, 1]
        if self.fixed is not None:
            points[:, 3 - sum(self.axes)] = self.fixed
        return points

    @property
    def extent_mm(self) -> tuple[float, float, float, float]:
        """Left, right, bottom, top in mm."""
        return (
            1e3 * self.low[0],
            1e3 * self.high[0],
            1e3 * self.low[1],
            1e3 * self.high[1],
        )


def cut(case: Case, prop: PropCase) -> list[Slice]:
    """A vertical and a horizontal cut through one prop; in the plane, the scene itself."""
    goal = prop.goal
    both = np.concatenate([goal.prop_points[goal.faces], goal.virtual_points[goal.faces]])
    low, high = both.min(axis=(0, 1)), both.max(axis=(0, 1))
    own = goal.prop_points[goal.faces]
    centre = 0.5 * (own.min(axis=(0, 1)) + own.max(axis=(0, 1)))
    margin = _MARGIN * float((high - low).max())
    low = np.maximum(low - margin, case.region.box[0])
    high = np.minimum(high + margin, case.region.box[1])
    # of what lies under a table a strip will do
    for point, normal in case.region.planes:
        if normal[-1] > 0.999:
            low[-1] = max(low[-1], point[-1] - _UNDER * margin)
    if case.dimension == 2:
        return [_slice(case, "In the plane", (0, 1), None, low, high)]
    # the upright cut along which more of the displacement happens, seen in full
    sideways = np.abs(goal.displacement).mean(axis=0)
    across = 0 if sideways[0] < 0.98 * sideways[1] else 1
    upright = _slice(case, "Upright cut", (1 - across, 2), float(centre[across]), low, high)
    # the level cut takes the same shape, so that the two stand side by side
    shape = (high[2] - low[2]) / (high[1 - across] - low[1 - across])
    middle, half = 0.5 * (low[1] + high[1]), 0.5 * shape * (high[0] - low[0])
    low[1] = max(middle - half, case.region.box[0, 1])
    high[1] = min(middle + half, case.region.box[1, 1])
    return [upright, _slice(case, "Level cut", (0, 1), float(centre[2]), low, high)]


def _slice(
    case: Case,
    title: str,
    axes: tuple[int, int],
    fixed: float | None,
    low: Float,
    high: Float,
) -> Slice:
    corner, far = low[list(axes)], high[list(axes)]
    pixel = float((far - corner).max()) / PIXELS
    counts = np.maximum(((far - corner) / pixel).astype(int), 2)
    across = corner[0] + (np.arange(counts[0]) + 0.5) * (far[0] - corner[0]) / counts[0]
    up = corner[1] + (np.arange(counts[1]) + 0.5) * (far[1] - corner[1]) / counts[1]
    flat = np.stack(np.meshgrid(across, up), axis=-1)
    points = np.empty((*flat.shape[:2], case.dimension))
    points[..., axes[0]], points[..., axes[1]] = flat[..., 0], flat[..., 1]
    if fixed is not None:
        points[..., 3 - sum(axes)] = fixed
        title = f"{title}, {AXES[3 - sum(axes)]} = {1e3 * fixed:.0f} mm"
    every = points.reshape(-1, case.dimension)
    slopes = case.warp.jacobian(every)
    gain = singular_values(np.nan_to_num(slopes))
    shape = flat.shape[:2]
    return Slice(
        title=title,
        axes=axes,
        fixed=fixed,
        low=corner,
        high=far,
        felt=_outlines(case, axes, fixed, virtual=False),
        seen=_outlines(case, axes, fixed, virtual=True),
        points=points,
        in_region=case.region.contains(every).reshape(shape),
        displayed=case.warp(every).reshape(points.shape),
        gain_high=gain[:, 0].reshape(shape),
        gain_low=gain[:, -1].reshape(shape),
        determinant=determinants(slopes).reshape(shape),
        ground=_ground(case, axes),
    )


def _outlines(case: Case, axes: tuple[int, int], fixed: float | None, virtual: bool) -> Float:
    parts = []
    for prop in case.props:
        points = prop.goal.virtual_points if virtual else prop.goal.prop_points
        corners = points[prop.goal.faces]
        if fixed is None:
            parts.append(corners)
        else:
            normal = 3 - sum(axes)
            parts.append(cut_triangles(corners, normal, fixed)[:, :, list(axes)])
    return np.concatenate(parts)


def cut_triangles(corners: Float, axis: int, height: float) -> Float:
    """Segments (s, 2, 3) where triangles (m, 3, 3) meet the plane at `height` along `axis`."""
    above = corners[:, :, axis] > height
    crossing = above.any(axis=1) & ~above.all(axis=1)
    corners, above = corners[crossing], above[crossing]
    # turn each triangle so that its first corner is alone on its side
    lone = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), (~above).argmax(axis=1))
    rows = np.arange(len(corners))
    a, b, c = (corners[rows, (lone + k) % 3] for k in range(3))
    ends = []
    for other in (b, c):
        t = (height - a[:, axis]) / (other[:, axis] - a[:, axis])
        ends.append(a + t[:, None] * (other - a))
    return np.stack(ends, axis=1) if len(corners) else np.empty((0, 2, 3))


def _ground(case: Case, axes: tuple[int, int]) -> float | None:
    """Where a fixed plane whose normal points up in the picture lies."""
    for point, normal in case.region.planes:
        if normal[axes[1]] > 0.999:
            return float(point[axes[1]])
    return None
