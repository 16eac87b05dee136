"""Triangles of a prop cut finer until their straight image lies on the virtual surface."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.goals.surface_tree import SurfaceTree
from touchwarp.scene.surface import Surface

Float = NDArray[np.float64]
Int = NDArray[np.int64]

ImageOf = Callable[[Int, Float], Float]
"""g at points of the prop: rows of faces (k,) and barycentric coordinates (k, 3) to (k, 3) m."""

MOST_FACES = 200_000


def _on_edges(count: int) -> Float:
    """(3, count, 3): places along the edge from corner `side` to the next, barycentric, by side."""
    share = (np.arange(count) + 1.0) / (count + 1)
    places = np.zeros((3, count, 3))
    for side in range(3):
        places[side, :, side], places[side, :, (side + 1) % 3] = 1 - share, share
    return places


# Long edges and large faces are looked at in more places than their middle.
_ON_EDGE = {count: _on_edges(count) for count in (1, 3, 7)}
_CENTRE = np.full((1, 3), 1 / 3)
_INSIDE = np.array([(4, 1, 1), (1, 4, 1), (1, 1, 4), (1, 2, 2), (2, 1, 2), (2, 2, 1)])
_INSIDE = _INSIDE / _INSIDE.sum(axis=1, keepdims=True)


@dataclass(frozen=True, eq=False)
class Subdivided:
    """A goal's arrays on triangles that are fine enough.

    Attributes:
        points: (n, 3) m, scene frame: on the prop; the given points come first.
        virtual_points: (n, 3) m, scene frame: their images.
        faces: (m, 3).
        parents: (m,): the given face that each face is part of.
        distance: m, the greatest found between the triangles' images and the virtual surface.
        capped: more faces would have been needed than were allowed.
    """

    points: Float
    virtual_points: Float
    faces: Int
    parents: Int
    distance: float
    capped: bool

    @property
    def report(self) -> dict[str, float | bool]:
        """What a goal's report says of it; lengths in m."""
        return {"image_distance_max": self.distance, "subdivision_capped": self.capped}


def subdivide(
    points: Float,
    faces: Int,
    image_of: ImageOf,
    virtual: Surface | None,
    tolerance: float,
    most_faces: int = MOST_FACES,
) -> Subdivided:
    """Split triangles whose straight image strays from the virtual surface.

    Edges are halved where an image strays, always with the longest edge of their triangle (Rivara
    1984), so that angles stay bounded and neighbours share all their vertices. The prop's
    own shape does not change.

    Args:
        points: (n, 3) m: the prop.
        faces: (m, 3).
        image_of: g; on an edge it must be the same from either face.
        virtual: the virtual surface; None where g itself is all that is known of it: then its
            straight image must not stray from g.
        tolerance: m.
        most_faces: not to be exceeded.
    """
    mesh = _Mesh(points, faces, image_of, virtual)
    settled = 0.0
    fresh = np.ones(len(faces), dtype=np.bool_)
    while True:
        marked, passed, failed = mesh.judge(fresh, tolerance)
        settled = max(settled, passed)
        if not marked.any():
            return mesh.result(settled, capped=False)
        if mesh.count_after(marked) > most_faces:
            return mesh.result(max(settled, failed), capped=True)
        fresh = mesh.split(marked)


class _Mesh:
    """The triangles while they are split, each with its corners' places on the given face."""

    def __init__(
        self, points: Float, faces: Int, image_of: ImageOf, virtual: Surface | None
    ) -> None:
        self.image_of = image_of
        self.virtual = None if virtual is None else SurfaceTree(virtual.vertices, virtual.faces)
        self.points = np.array(points, dtype=np.float64)
        self.faces = np.array(faces, dtype=np.int64)
        self.parents = np.arange(len(faces))
        self.places = np.tile(np.eye(3), (len(faces), 1, 1))
        self.images = np.zeros_like(self.points)
        # Every corner once, from any of its faces.
        vertex, row = np.unique(self.faces, return_index=True)
        self.images[vertex] = image_of(self.parents[row // 3], self.places[row // 3, row % 3])
        unused = np.ones(len(self.points), dtype=np.bool_)
        unused[vertex] = False
        self.images[unused] = self.points[unused]

    def judge(
        self, fresh: NDArray[np.bool_], tolerance: float
    ) -> tuple[NDArray[np.bool_], float, float]:
        """Edges to split (m, 3), the greatest distance that passed, and the greatest of all, m."""
        self._find_edges()
        scale = float(np.ptp(self.images, axis=0).max()) or 1.0
        at_edge = self._edge_distances(np.unique(self.edge_of_face[fresh]), scale)
        in_face = self._face_distances(np.flatnonzero(fresh), scale)
        # At a jump of g nothing is gained by halving for ever.
        span = self._lengths(self.points)
        can_split = span > tolerance / 4
        marked = (at_edge > tolerance) & can_split
        inner = self.edge_of_face[in_face > tolerance]
        inner = inner[~marked[inner].any(axis=1)]
        longest = self._lengths(self.images)[inner].argmax(axis=1)[:, None]
        marked[np.take_along_axis(inner, longest, axis=1)] = True
        marked &= can_split
        marked = self._with_longest(marked, span)
        of_face = marked[self.edge_of_face]
        passed = np.r_[at_edge[~marked], in_face[~of_face.any(axis=1)], 0.0]
        return of_face, float(passed.max()), float(max(at_edge.max(), in_face.max()))

    def count_after(self, marked: NDArray[np.bool_]) -> int:
        """How many faces there are once the marked edges (m, 3) are split."""
        return len(self.faces) + int(marked.sum())

    def split(self, marked: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Split the marked edges of each face (m, 3); tells which faces are new."""
        edges = np.unique(self.edge_of_face[marked])
        number = np.full(len(self.edges), -1)
        number[edges] = len(self.points) + np.arange(len(edges))
        span = self._lengths(self.points)
        face, side = np.divmod(self.row_of_edge[edges], 3)
        middle = (self.places[face, side] + self.places[face, (side + 1) % 3]) / 2
        # The straight middle, so that the prop keeps its shape to the last bit of rounding.
        self.points = np.concatenate([self.points, self.points[self.edges[edges]].mean(axis=1)])
        self.images = np.concatenate([self.images, self.image_of(self.parents[face], middle)])

        touched = marked.any(axis=1)
        new_faces, new_places, new_parents = [], [], []
        which = np.flatnonzero(touched)
        first = span[self.edge_of_face[which]].argmax(axis=1)
        turn = (first[:, None] + np.arange(3)) % 3
        v = np.take_along_axis(self.faces[which], turn, axis=1)
        p = np.take_along_axis(self.places[which], turn[:, :, None], axis=1)
        m = number[np.take_along_axis(self.edge_of_face[which], turn, axis=1)]
        # Corners 0, 1, 2 and the middles 3 (of 0-1, the longest), 4 (of 1-2), 5 (of 2-0).
        v = np.c_[v, m]
        p = np.concatenate([p, (p + np.roll(p, -1, axis=1)) / 2], axis=1)
        for middle_of, whole, halves in (
            (4, (3, 1, 2), ((3, 1, 4), (3, 4, 2))),
            (5, (0, 3, 2), ((0, 3, 5), (5, 3, 2))),
        ):
            cut = v[:, middle_of] >= 0
            for corners, some in ((whole, ~cut), *((half, cut) for half in halves)):
                new_faces.append(v[some][:, corners])
                new_places.append(p[some][:, corners])
                new_parents.append(self.parents[which[some]])
        kept = ~touched
        self.faces = np.concatenate([self.faces[kept], *new_faces])
        self.places = np.concatenate([self.places[kept], *new_places])
        self.parents = np.concatenate([self.parents[kept], *new_parents])
        fresh = np.ones(len(self.faces), dtype=np.bool_)
        fresh[: kept.sum()] = False
        return fresh

    def result(self, distance: float, capped: bool) -> Subdivided:
        return Subdivided(self.points, self.images, self.faces, self.parents, distance, capped)

    def _find_edges(self) -> None:
        pairs = np.stack([self.faces, np.roll(self.faces, -1, axis=1)], axis=2).reshape(-1, 2)
        low, high = pairs.min(axis=1), pairs.max(axis=1)
        base = len(self.points)
        keys, self.row_of_edge, of_face = np.unique(
            low * base + high, return_index=True, return_inverse=True
        )
        self.edges = np.stack([keys // base, keys % base], axis=1)
        self.edge_of_face = of_face.reshape(-1, 3)

    def _lengths(self, points: Float) -> Float:
        """(e,) m: the length of every edge between `points`."""
        ends = points[self.edges]
        return np.asarray(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))

    def _edge_distances(self, edges: Int, scale: float) -> Float:
        """(e,) m: how far the images of these edges stray; 0 for all others."""
        strayed = np.zeros(len(self.edges))
        length = self._lengths(self.images)[edges]
        for places, some in (
            (_ON_EDGE[1], length <= scale / 30),
            (_ON_EDGE[3], (length > scale / 30) & (length <= scale / 8)),
            (_ON_EDGE[7], length > scale / 8),
        ):
            face, side = np.divmod(self.row_of_edge[edges[some]], 3)
            strayed[edges[some]] = self._strayed(face, places[side])
        return strayed

    def _face_distances(self, faces: Int, scale: float) -> Float:
        """(m,) m: how far the images of these faces' insides stray; 0 for all others."""
        strayed = np.zeros(len(self.faces))
        corners = self.images[self.faces[faces]]
        length = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
        for places, some in ((_CENTRE, length <= scale / 8), (_INSIDE, length > scale / 8)):
            rows = faces[some]
            strayed[rows] = self._strayed(rows, np.broadcast_to(places, (len(rows), *places.shape)))
        return strayed

    def _strayed(self, faces: Int, places: Float) -> Float:
        """(f,) m: the greatest distance at places (f, p, 3) of faces (f,)."""
        if len(faces) == 0:
            return np.zeros(0)
        straight = np.einsum("fpk,fkd->fpd", places, self.images[self.faces[faces]]).reshape(-1, 3)
        if self.virtual is not None:
            distance = self.virtual.nearest(straight).distance
        else:
            on_parent = np.einsum("fpk,fkc->fpc", places, self.places[faces]).reshape(-1, 3)
            parents = np.repeat(self.parents[faces], places.shape[1])
            distance = np.linalg.norm(straight - self.image_of(parents, on_parent), axis=1)
        return np.asarray(distance.reshape(len(faces), -1).max(axis=1))

    def _with_longest(self, marked: NDArray[np.bool_], span: Float) -> NDArray[np.bool_]:
        """The marked edges, and the longest edge of every face that has one."""
        longest = span[self.edge_of_face].argmax(axis=1)[:, None]
        of_face = np.take_along_axis(self.edge_of_face, longest, axis=1)[:, 0]
        while True:
            more = of_face[marked[self.edge_of_face].any(axis=1) & ~marked[of_face]]
            if len(more) == 0:
                return marked
            marked[more] = True
