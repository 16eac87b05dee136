"""A map refined from coarse to fine: few vertices of the prop first, then more of them.

The coarse levels are collapses of the prop's mesh. They are what lets a map move far at little
cost, and past the needles of CAD meshes, which would stop every long step. A vertex that returns is
put into the kernel of its ring on the domain, so each level's map is as one-to-one as the last.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.goals.maps.closed_mesh import ClosedMesh
from touchwarp.goals.maps.collapse import collapse_to
from touchwarp.goals.maps.embed import DIRICHLET, area_scale, sweep
from touchwarp.goals.maps.layout import Layout
from touchwarp.goals.maps.rings import MOST_NEIGHBOURS, build_rings, restore
from touchwarp.goals.maps.star import kernel_point, relax, set_targets

RELAXING_ROUNDS = 10


class Levels:
    """The prop's mesh at several resolutions, with points of the domain that the finer inherit.

    Attributes:
        points: (n, 3) of all vertices; only those that are there now count.
    """

    def __init__(self, layout: Layout, least: int) -> None:
        """Collapse the layout's mesh to `least` vertices, if it has more."""
        self._layout = layout
        mesh = layout.mesh
        self.points = layout.points.copy()
        self._vertices = (mesh.vertices - mesh.centre) / mesh.diagonal
        ring, shift, degree, _ = build_rings(mesh.faces, layout.corner_shift, len(self.points))
        self._left = collapse_to(self._vertices, ring, shift, degree, least, self.points)
        self._due = len(self._left.removed)

    @property
    def whole(self) -> bool:
        """Whether all vertices are there."""
        return self._due == 0

    @property
    def count(self) -> int:
        """How many vertices are there."""
        return int(self._left.alive.sum())

    def now(self) -> tuple[NDArray[np.int64], Layout]:
        """The vertices (k,) that are there, and the layout of their mesh."""
        left = self._left
        chosen = np.flatnonzero(left.alive)
        number = np.full(len(left.alive), -1)
        number[chosen] = np.arange(len(chosen))
        faces, shifts = faces_of(left.ring, left.shift, left.degree, left.alive)
        mesh = ClosedMesh(self._layout.mesh.vertices[chosen], number[faces])
        return chosen, Layout(mesh, self.points[chosen], shifts)

    def whole_layout(self) -> Layout:
        """The layout of the given mesh, once all vertices are there."""
        assert self.whole
        return self._layout.moved(self.points)

    def relax(self, rounds: int) -> None:
        """Move each vertex that is there towards equal areas, so many times.

        A collapse leaves some triangles next to nothing; one of them would stop every step of all.
        """
        left, flat = self._left, self._layout.flat
        rings = (left.ring, left.shift, left.degree)
        total = self._layout.domain_area
        scale = area_scale(self._vertices, left.ring, left.degree, left.alive, total)
        target, slope = np.empty((MOST_NEIGHBOURS, 4)), np.empty(9)
        state = (self._vertices, self.points, *rings, left.alive)
        sweep(*state, scale, target, slope, flat, rounds, DIRICHLET)

    def put_back(self, count: int) -> None:
        """Let vertices return until `count` are there."""
        left = self._left
        last = max(0, self._due - max(0, count - self.count))
        return_vertices(
            self._vertices,
            self.points,
            left.ring,
            left.shift,
            left.degree,
            left.alive,
            left.removed,
            left.removed_degree,
            left.removed_ring,
            left.removed_shift,
            self._due,
            last,
            self._layout.domain_area / (self._layout.mesh.area / self._layout.mesh.diagonal**2),
            self._layout.flat,
        )
        self._due = last
        self.relax(RELAXING_ROUNDS)


@njit(cache=True, error_model="numpy")
def faces_of(ring, shift, degree, alive):
    """Faces (m, 3) and corner shifts (m, 3, 2) from rings."""
    count = 0  # of corners: every face is counted by its three
    for v in range(len(alive)):
        count += degree[v] if alive[v] else 0
    count //= 3
    faces = np.empty((count, 3), np.int64)
    shifts = np.zeros((count, 3, 2))
    found = 0
    for v in range(len(alive)):
        if not alive[v]:
            continue
        for j in range(degree[v]):
            i = (j + 1) % degree[v]
            if v < ring[v, j] and v < ring[v, i]:
                faces[found, 0], faces[found, 1], faces[found, 2] = v, ring[v, j], ring[v, i]
                for d in range(2):
                    shifts[found, 1, d], shifts[found, 2, d] = shift[v, j, d], shift[v, i, d]
                found += 1
    return faces, shifts


@njit(cache=True, error_model="numpy", nogil=True)
def return_vertices(
    vertices,
    points,
    ring,
    shift,
    degree,
    alive,
    removed,
    removed_degree,
    removed_ring,
    removed_shift,
    first,
    last,
    scale,
    flat,
):
    """Let the vertices removed[last:first] return, the last one first, and relax them."""
    target = np.empty((MOST_NEIGHBOURS, 4))
    slope = np.empty(9)
    corners = np.empty((MOST_NEIGHBOURS, 3))
    for r in range(first - 1, last - 1, -1):
        v, k = removed[r], removed_degree[r]
        for j in range(k):
            w = removed_ring[r, j]
            corners[j, 0] = points[w, 0] + removed_shift[r, j, 0]
            corners[j, 1] = points[w, 1] + removed_shift[r, j, 1]
            corners[j, 2] = points[w, 2]
        points[v], _ = kernel_point(corners, k, flat)
        restore(ring, shift, degree, removed_ring[r], removed_shift[r], k, v)
        alive[v] = True
        for _ in range(3):
            set_targets(vertices, ring, degree, v, scale, target)
            relax(points, ring, shift, degree, v, target, DIRICHLET, slope, flat)
    for _ in range(RELAXING_ROUNDS):  # the new ones again, now that all of them are there
        for r in range(first - 1, last - 1, -1):
            v = removed[r]
            set_targets(vertices, ring, degree, v, scale, target)
            relax(points, ring, shift, degree, v, target, DIRICHLET, slope, flat)
