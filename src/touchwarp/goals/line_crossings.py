"""Where lines of a bundle, parallel or out of one point, cross a surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from touchwarp.scene.surface import Surface

Float = NDArray[np.float64]
Int = NDArray[np.int64]

MOST_CROSSINGS = 8
# A line through an edge or a vertex counts as inside of all its triangles; they give one value.
EDGE_TOLERANCE = 1e-9
SAME_PLACE = 1e-7


@dataclass(frozen=True, eq=False)
class Crossings:
    """Where n lines cross a surface.

    Attributes:
        count: (n,) at how many places; more than 8 are counted as 8.
        places: (n, 8) m along each line, ascending; NaN beyond the count.
        last: (n,) m: the greatest of all places, also where there are more; −∞ where there is none.
    """

    count: Int
    places: Float
    last: Float


class ParallelLines:
    """Lines along one direction, and the heights at which they cross a surface.

    Args:
        surface: in space.
        normal: (3,) unit vector: the lines' direction; heights are x · normal.
    """

    def __init__(self, surface: Surface, normal: Float) -> None:
        self.normal = np.asarray(normal, dtype=np.float64)
        self.across = across(self.normal)
        feet = self.feet(surface.vertices)
        self._scale = float(np.abs(feet[:, :2]).max()) or 1.0
        feet[:, :2] /= self._scale
        corners = feet[surface.faces]
        values = (surface.vertices @ self.normal)[surface.faces]
        self._bins = _Bins(corners, values, corners.min(axis=1), corners.max(axis=1))

    def feet(self, points: Float) -> Float:
        """(n, 3): two coordinates across the lines, m, and 1."""
        return np.asarray(np.c_[points @ self.across.T, np.ones(len(points))])

    def crossings(self, points: Float) -> Crossings:
        """Heights at which the lines through points (n, 3) m cross the surface."""
        keys = self.feet(points)
        keys[:, :2] /= self._scale
        return self._bins.crossings(keys)


class RadialLines:
    """Rays out of a centre, and the distances at which they cross a surface.

    Args:
        surface: in space; no vertex at the centre.
        centre: (3,) m.
    """

    def __init__(self, surface: Surface, centre: Float) -> None:
        arms = surface.vertices - centre
        length = np.linalg.norm(arms, axis=1)
        corners = (arms / length[:, None])[surface.faces]
        # The cap around a spherical triangle: its box is the box of a ball around its middle.
        middle = corners.sum(axis=1)
        middle /= np.maximum(np.linalg.norm(middle, axis=1), 1e-9)[:, None]
        reach = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)
        reach[reach > 1.3] = 4.0
        self._bins = _Bins(
            corners, 1 / length[surface.faces], middle - reach[:, None], middle + reach[:, None]
        )

    def crossings(self, directions: Float) -> Crossings:
        """Distances at which the rays along unit vectors (n, 3) cross the surface."""
        found = self._bins.crossings(np.ascontiguousarray(directions))
        # Inverse distances are linear on a triangle, so these are what the bins hold.
        places = np.sort(1 / found.places, axis=1)
        return Crossings(found.count, places, np.fmax.reduce(places, axis=1, initial=-np.inf))


def across(normal: Float) -> Float:
    """(2, 3): two unit vectors that complete a unit vector to a right-handed frame."""
    aside = np.eye(3)[np.abs(normal).argmin()]
    first = np.cross(aside, normal)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first)])


class _Bins:
    """Triangles in a grid of bins by where their lines are.

    A line is a vector d, a triangle three vectors: it is crossed where d = Σ μ_i a_i with μ_i ≥ 0,
    and a quantity that is v_i at its corners is Σ μ_i v_i there.
    """

    def __init__(self, corners: Float, values: Float, low: Float, high: Float) -> None:
        self.corners, self.values = np.ascontiguousarray(corners), np.ascontiguousarray(values)
        self.low = low.min(axis=0).clip(-1.01, 1.01) - 1e-6
        extent = high.max(axis=0).clip(-1.01, 1.01) + 1e-6 - self.low
        # About one triangle a bin, whether they fill a plane or a sphere.
        side = np.sqrt(len(corners))
        flat = extent < 1e-3
        self.shape = np.where(flat, 1, int(np.clip(side if flat.any() else side / 2, 2, 64)))
        self.step = extent / self.shape
        first = self._cell(low - 1e-6)
        last = self._cell(high + 1e-6)
        self.starts, self.items = _fill(first, last, self.shape)

    def crossings(self, keys: Float) -> Crossings:
        cells = self._cell(keys)
        count = np.zeros(len(keys), dtype=np.int64)
        places = np.full((len(keys), MOST_CROSSINGS), np.nan)
        flat = (cells[:, 0] * self.shape[1] + cells[:, 1]) * self.shape[2] + cells[:, 2]
        last = np.full(len(keys), -np.inf)
        _cross(keys, flat, self.starts, self.items, self.corners, self.values, count, places, last)
        return Crossings(count, places, last)

    def _cell(self, keys: Float) -> Int:
        cell = np.floor((keys - self.low) / self.step).astype(np.int64)
        return np.asarray(np.clip(cell, 0, self.shape - 1))


@njit(cache=True)
def _fill(first, last, shape):
    """Triangles by bin: where each bin's list starts, and the lists."""
    counts = np.zeros(shape[0] * shape[1] * shape[2] + 1, dtype=np.int64)
    for t in range(len(first)):
        for i in range(first[t, 0], last[t, 0] + 1):
            for j in range(first[t, 1], last[t, 1] + 1):
                for k in range(first[t, 2], last[t, 2] + 1):
                    counts[(i * shape[1] + j) * shape[2] + k + 1] += 1
    starts = np.cumsum(counts)
    items = np.empty(starts[-1], dtype=np.int64)
    fill = starts[:-1].copy()
    for t in range(len(first)):
        for i in range(first[t, 0], last[t, 0] + 1):
            for j in range(first[t, 1], last[t, 1] + 1):
                for k in range(first[t, 2], last[t, 2] + 1):
                    cell = (i * shape[1] + j) * shape[2] + k
                    items[fill[cell]] = t
                    fill[cell] += 1
    return starts, items


@njit(cache=True, parallel=True)
def _cross(keys, cells, starts, items, corners, values, count, places, last):
    """Count and places of the crossings of each line, in ascending order, and the last of all."""
    for n in prange(len(keys)):
        d = keys[n]
        for item in range(starts[cells[n]], starts[cells[n] + 1]):
            t = items[item]
            a, b, c = corners[t, 0], corners[t, 1], corners[t, 2]
            bc = np.cross(b, c)
            det = a[0] * bc[0] + a[1] * bc[1] + a[2] * bc[2]
            if abs(det) < 1e-14:
                continue  # seen edge on: the line runs within it, or misses it
            ca, ab = np.cross(c, a), np.cross(a, b)
            u = (d[0] * bc[0] + d[1] * bc[1] + d[2] * bc[2]) / det
            v = (d[0] * ca[0] + d[1] * ca[1] + d[2] * ca[2]) / det
            w = (d[0] * ab[0] + d[1] * ab[1] + d[2] * ab[2]) / det
            if u < -EDGE_TOLERANCE or v < -EDGE_TOLERANCE or w < -EDGE_TOLERANCE:
                continue
            place = u * values[t, 0] + v * values[t, 1] + w * values[t, 2]
            last[n] = max(last[n], place)
            _insert(places[n], count, n, place)


@njit(cache=True)
def _insert(sorted_places, count, n, place):
    """Put a place where it belongs, unless it is there already."""
    k = count[n]
    for i in range(k):
        if abs(sorted_places[i] - place) <= SAME_PLACE * max(1.0, abs(place)):
            return
    if k == len(sorted_places):
        return
    while k > 0 and sorted_places[k - 1] > place:
        sorted_places[k] = sorted_places[k - 1]
        k -= 1
    sorted_places[k] = place
    count[n] += 1
