"""Which points lie in Ω, and how far they are from the props.

Ω is what can be reached from ∂Ω1 without crossing a surface. Sample points are classified by the
winding numbers of the props; a prop with large openings (a sheet, a bowl of one layer) has no
inside, so all of space around it is in Ω.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.check.shares import share_out
from touchwarp.check.winding import Windings
from touchwarp.goals.surface_samples import SurfaceSamples
from touchwarp.goals.surface_tree import SurfaceTree

Float = NDArray[np.float64]
Int = NDArray[np.int64]
Bool = NDArray[np.bool_]

_LEAK = 0.1
"""Beside a closed surface winding numbers are whole; farther from that than this is a leak."""

_LEAKY_SHARE = 0.1
"""A surface with more than this share of leaks is treated as open, without an inside."""


@dataclass(eq=False)
class Body:
    """One surface with its inside and its distances.

    Attributes:
        name: the prop's or fixed surface's.
        vertices: (n, d) m, scene frame.
        faces: (m, d).
    """

    name: str
    vertices: Float
    faces: Int
    closed: bool = True
    outward: float = 1.0
    _windings: Windings | None = field(default=None, repr=False)

    @cached_property
    def _tree(self) -> SurfaceTree:
        return SurfaceTree(self.vertices, self.faces)

    def inside(self, points: Float) -> Bool:
        """(n,) whether (n, d) points are inside; nowhere where the surface is open."""
        if not self.closed:
            return np.zeros(len(points), bool)
        if self._windings is None:
            self._windings = Windings(self.vertices, self.faces)
        return np.abs(self._windings.at(points)) > 0.5

    def nearest(self, points: Float) -> tuple[Float, Float, Int]:
        """Distance (n,) m, nearest points (n, d) and their faces (n,), for (n, d) points."""
        points = np.ascontiguousarray(points, dtype=np.float64)
        if len(points) == 0:
            return np.zeros(0), np.zeros_like(points), np.zeros(0, np.int64)
        if points.shape[1] == 2:
            found = np.empty(len(points)), np.empty_like(points), np.zeros(len(points), np.int64)
            share_out(
                len(points),
                lambda s: _nearest_on_segments(
                    self.vertices, self.faces, points[s], *(array[s] for array in found)
                ),
            )
            return found
        return self._tree.nearest(points)

    def first_hit(self, starts: Float, directions: Float) -> Float:
        """(n,) m along unit directions (n, 3) to where rays first meet the surface; else inf."""
        return self._tree.first_hit(starts, directions)[0]


def make_body(name: str, vertices: Float, faces: Int, samples: SurfaceSamples | None) -> Body:
    """A body that knows whether it is closed and which way its normals look.

    Args:
        name: the prop's or fixed surface's.
        vertices: (n, d) m, scene frame.
        faces: (m, d).
        samples: points of the surface to try its two sides at; None takes it for closed.
    """
    body = Body(name, np.ascontiguousarray(vertices), np.ascontiguousarray(faces))
    body._windings = Windings(body.vertices, body.faces)
    if samples is None or len(samples.points) == 0:
        return body
    tried = samples.points[:: max(1, len(samples.points) // 1000)]
    normals = samples.normals[:: max(1, len(samples.points) // 1000)]
    step = 1e-6 * float(np.ptp(body.vertices, axis=0).max())
    front = body._windings.at(tried + step * normals)
    back = body._windings.at(tried - step * normals)
    body.outward = 1.0 if np.median(np.abs(back)) >= np.median(np.abs(front)) else -1.0
    outer = front if body.outward > 0 else back
    # an inner body's surface has whole winding numbers on both sides: no leak
    leak = np.abs(outer - np.round(outer)) > _LEAK
    body.closed = bool(leak.mean() <= _LEAKY_SHARE)
    return body


@dataclass(frozen=True, eq=False)
class Region:
    """Ω of a scene, for sample points.

    Attributes:
        props: the retargeted props.
        holds: fixed surfaces given as meshes.
        planes: (point, unit normal) m of fixed planes; Ω is on the normal's side.
        box: (2, d) m, scene frame: ∂Ω1, or the bounds of `outer`.
        outer: ∂Ω1 where it is a mesh.
    """

    props: tuple[Body, ...]
    holds: tuple[Body, ...]
    planes: tuple[tuple[Float, Float], ...]
    box: Float
    outer: Body | None = None

    def contains(self, points: Float) -> Bool:
        """(n,) whether (n, d) points lie in Ω."""
        inside = ((points > self.box[0]) & (points < self.box[1])).all(axis=1)
        for point, normal in self.planes:
            inside &= (points - point) @ normal > 0
        for body in (*self.props, *self.holds):
            low, high = body.vertices.min(axis=0), body.vertices.max(axis=0)
            near = np.flatnonzero(inside & ((points >= low) & (points <= high)).all(axis=1))
            inside[near[body.inside(points[near])]] = False
        if self.outer is not None:
            left = np.flatnonzero(inside)
            inside[left[~self.outer.inside(points[left])]] = False
        return np.asarray(inside, dtype=np.bool_)

    def distance_to_props(self, points: Float) -> Float:
        """(n,) m, from (n, d) points to the nearest prop surface."""
        return np.asarray(np.min([body.nearest(points)[0] for body in self.props], axis=0))


@njit(cache=True, nogil=True)
def _nearest_on_segments(vertices, segments, points, distance, nearest, face):
    for n in range(points.shape[0]):
        distance[n] = np.inf
        for s in range(segments.shape[0]):
            ax, ay = vertices[segments[s, 0], 0], vertices[segments[s, 0], 1]
            bx, by = vertices[segments[s, 1], 0] - ax, vertices[segments[s, 1], 1] - ay
            px, py = points[n, 0] - ax, points[n, 1] - ay
            square = bx * bx + by * by
            t = min(max((px * bx + py * by) / square, 0.0), 1.0) if square > 0 else 0.0
            gap = np.hypot(px - t * bx, py - t * by)
            if gap < distance[n]:
                distance[n] = gap
                nearest[n, 0], nearest[n, 1] = ax + t * bx, ay + t * by
                face[n] = s
