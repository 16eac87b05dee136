"""A mesh taken apart to a few vertices, and put together again on the hyperbolic plane.

As on the sphere and the torus, each vertex returns into the kernel of its ring and relaxes there.
It had gone onto a neighbour, and so its ring lies in that neighbour's star: which elements of the
deck group take the ring's vertices beside it need not be kept, they are read off that star.

Rings are those of `rings`; a shift is (element, 0). Of shifts `restore` asks only that the negative
is the inverse, which is so of elements.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.maps.closed_mesh import ClosedMesh
from touchwarp.goals.maps.collapse import Collapsed, collapse_to
from touchwarp.goals.maps.embed import DIRICHLET, area_scale
from touchwarp.goals.maps.hyperbolic.deck import carry, product
from touchwarp.goals.maps.hyperbolic.layout import HyperbolicLayout, laid_out
from touchwarp.goals.maps.levels import faces_of
from touchwarp.goals.maps.rings import MOST_NEIGHBOURS, place_in_ring, restore, rings_of
from touchwarp.goals.maps.star import kernel_point_on, relax_among, set_targets

Float = NDArray[np.float64]
Int = NDArray[np.int64]


class Coarsened:
    """A mesh, and what is left of it after collapses.

    Attributes:
        mesh: the whole mesh.
        coarse: what is left.
        chosen: (k,) the whole mesh's vertices that are those of `coarse`.
    """

    def __init__(self, mesh: ClosedMesh, least: int) -> None:
        """Collapse a mesh to `least` vertices, if it has more.

        Raises:
            GoalError: a vertex has too many neighbours.
        """
        self.mesh = mesh
        self.vertices = (mesh.vertices - mesh.centre) / mesh.diagonal
        nothing = np.zeros((len(mesh.faces), 3, 2))
        ring, shift, degree = rings_of(mesh.faces, nothing, len(mesh.vertices))
        self.left: Collapsed = collapse_to(self.vertices, ring, shift, degree, least)
        self.chosen = np.flatnonzero(self.left.alive)
        number = np.full(len(self.vertices), -1)
        number[self.chosen] = np.arange(len(self.chosen))
        faces, _ = faces_of(self.left.ring, self.left.shift, self.left.degree, self.left.alive)
        self.coarse = ClosedMesh(mesh.vertices[self.chosen], number[faces])

    def regrow(self, coarse: HyperbolicLayout) -> Regrown:
        """A layout of `coarse` that grows to one of the whole mesh."""
        return Regrown(self, coarse)


class Regrown:
    """A layout to which vertices return.

    Attributes:
        points: (n, 3) of all vertices; only those that are there count.
    """

    def __init__(self, whole: Coarsened, coarse: HyperbolicLayout) -> None:
        left, chosen = whole.left, whole.chosen
        self._whole = whole
        self._deck = coarse.deck
        self._ring, self._degree = left.ring.copy(), left.degree.copy()
        self._shift, self._alive = left.shift.copy(), left.alive.copy()
        self._due = len(left.removed)
        self.points = np.zeros((len(self._alive), 3))
        self.points[:, 2] = 1.0
        self.points[chosen] = coarse.points
        faces = chosen[coarse.mesh.faces]
        _set_shifts(
            faces, coarse.elements, self._ring, self._shift, self._degree, self._deck.tables
        )

    @property
    def count(self) -> int:
        """How many vertices are there."""
        return int(self._alive.sum())

    @property
    def whole(self) -> bool:
        """Whether all vertices are there."""
        return self._due == 0

    @property
    def _state(self) -> tuple[Float, Float, NDArray[np.int32], Float, NDArray[np.int32], Float]:
        return (
            self._whole.vertices,
            self.points,
            self._ring,
            self._shift,
            self._degree,
            self._deck.tables[0],
        )

    def put_back(self, count: int, around: bool = False) -> None:
        """Let vertices return until `count` are there.

        Args:
            count: how many; at most all.
            around: whether the neighbours of each relax too.

        Raises:
            GoalError: a triangle would be turned over.
        """
        left = self._whole.left
        last = max(0, self._due - max(0, count - self.count))
        vertices, points, ring, shift, degree, matrices = self._state
        turned = _return_vertices(
            vertices,
            points,
            ring,
            shift,
            degree,
            matrices,
            self._alive,
            (left.removed, left.removed_degree, left.removed_ring, left.removed_shift),
            self._due,
            last,
            self._scale(),
            around,
        )
        self._due = last
        if turned:
            raise GoalError(
                f"the mesh cannot be laid out on the hyperbolic plane: {turned} triangles would be "
                "turned over; remesh it."
            )

    def relax(self, rounds: int) -> None:
        """Move each vertex that is there towards equal areas, so many times."""
        vertices, points, ring, shift, degree, matrices = self._state
        chosen = np.flatnonzero(self._alive)
        _relax_all(vertices, points, ring, shift, degree, matrices, chosen, self._scale(), rounds)

    def now(self) -> tuple[Int, HyperbolicLayout]:
        """The vertices (k,) that are there, and the layout of their mesh."""
        whole = self._whole.mesh
        chosen = np.flatnonzero(self._alive)
        number = np.full(len(self._alive), -1)
        number[chosen] = np.arange(len(chosen))
        faces, shift = faces_of(self._ring, self._shift, self._degree, self._alive)
        mesh = ClosedMesh(whole.vertices[chosen], number[faces])
        elements = shift[:, :, 0].astype(np.int64)
        return chosen, laid_out(mesh, self.points[chosen], elements, self._deck)

    def finish(self) -> HyperbolicLayout:
        """The layout of the whole mesh, its faces as they were given."""
        self.put_back(len(self._alive))
        elements = self.elements()
        return laid_out(self._whole.mesh, self.points.copy(), elements, self._deck)

    def elements(self) -> Int:
        """(m, 3): the elements of the whole mesh's corners, once all vertices are there."""
        assert self.whole
        faces = self._whole.mesh.faces
        return np.asarray(_corner_elements(faces, self._ring, self._shift, self._degree))

    def return_unplaced(self) -> None:
        """Let all vertices return for the sake of their elements alone, without places."""
        left = self._whole.left
        _, _, ring, shift, degree, _ = self._state
        record = (left.removed, left.removed_degree, left.removed_ring, left.removed_shift)
        _return_all_to_rings(ring, shift, degree, record, self._due)
        self._alive[:] = True
        self._due = 0

    def _scale(self) -> float:
        vertices, _, ring, _, degree, _ = self._state
        return float(area_scale(vertices, ring, degree, self._alive, self._deck.area))


@njit(cache=True, error_model="numpy")
def _set_shifts(faces, elements, ring, shift, degree, tables):
    for f in range(len(faces)):
        for k in range(3):
            v, w = faces[f, k], faces[f, (k + 1) % 3]
            across = product(tables, -elements[f, k], elements[f, (k + 1) % 3])
            shift[v, place_in_ring(ring, degree, v, w), 0] = across


@njit(cache=True, error_model="numpy")
def _return_to_rings(ring, shift, degree, record, r):
    removed, counts, rings, shifts = record
    k, onto = counts[r], rings[r, 0]
    shifts[r, :k] = 0.0
    for j in range(1, k):
        shifts[r, j] = shift[onto, place_in_ring(ring, degree, onto, rings[r, j])]
    restore(ring, shift, degree, rings[r], shifts[r], k, removed[r])


@njit(cache=True, error_model="numpy")
def _return_all_to_rings(ring, shift, degree, record, due):
    for r in range(due - 1, -1, -1):
        _return_to_rings(ring, shift, degree, record, r)


@njit(cache=True, error_model="numpy")
def _gather_ring(points, ring, shift, degree, matrices, v, around):
    for j in range(degree[v]):
        x, y, z = points[ring[v, j]]
        x, y, z = carry(matrices, int(shift[v, j, 0]), x, y, z)
        around[j, 0], around[j, 1], around[j, 2] = x, y, z


@njit(cache=True, error_model="numpy")
def _relax(vertices, points, ring, shift, degree, matrices, v, scale, target, slope, around):
    set_targets(vertices, ring, degree, v, scale, target)
    # Sums of squared sides with weights below 0 can be below 0 for large triangles of this plane.
    target[: degree[v], 1:] = np.maximum(target[: degree[v], 1:], 0.0)
    _gather_ring(points, ring, shift, degree, matrices, v, around)
    relax_among(around, degree[v], points[v], target, DIRICHLET, slope, -1.0)


@njit(cache=True, error_model="numpy")
def _relax_all(vertices, points, ring, shift, degree, matrices, chosen, scale, rounds):
    target, slope = np.empty((MOST_NEIGHBOURS, 4)), np.empty(9)
    around = np.empty((MOST_NEIGHBOURS, 3))
    rest = (scale, target, slope, around)
    for _ in range(rounds):
        for v in chosen:
            _relax(vertices, points, ring, shift, degree, matrices, v, *rest)


@njit(cache=True, error_model="numpy")
def _return_vertices(
    vertices, points, ring, shift, degree, matrices, alive, record, first, last, scale, neighbours
):
    removed = record[0]
    target, slope = np.empty((MOST_NEIGHBOURS, 4)), np.empty(9)
    around = np.empty((MOST_NEIGHBOURS, 3))
    rest = (scale, target, slope, around)
    turned = 0
    for r in range(first - 1, last - 1, -1):
        v = removed[r]
        _return_to_rings(ring, shift, degree, record, r)
        alive[v] = True
        _gather_ring(points, ring, shift, degree, matrices, v, around)
        point, depth = kernel_point_on(around, degree[v], -1.0)
        points[v] = point
        turned += depth <= 0.0
        if neighbours:
            for j in range(degree[v]):
                w = ring[v, j]
                _relax(vertices, points, ring, shift, degree, matrices, w, *rest)
        for _ in range(3):
            _relax(vertices, points, ring, shift, degree, matrices, v, *rest)
    for _ in range(4):  # the new ones again, now that all of them are there
        for r in range(first - 1, last - 1, -1):
            _relax(vertices, points, ring, shift, degree, matrices, removed[r], *rest)
    return turned


@njit(cache=True, error_model="numpy")
def _corner_elements(faces, ring, shift, degree):
    elements = np.zeros(faces.shape, np.int64)
    for f in range(len(faces)):
        v = faces[f, 0]
        for k in range(1, 3):
            elements[f, k] = int(shift[v, place_in_ring(ring, degree, v, faces[f, k]), 0])
    return elements
