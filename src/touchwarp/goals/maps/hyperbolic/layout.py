"""A closed mesh of genus 2 or more on the hyperbolic surface of its genus."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.goals.maps.closed_mesh import ClosedMesh
from touchwarp.goals.maps.hyperbolic.deck import METRIC, Deck, carry, product
from touchwarp.goals.maps.layout import Layout, area_and_gradient_on
from touchwarp.goals.maps.locate import OUTSIDE, Locator
from touchwarp.goals.maps.star import onto_domain, tangents_on

Float = NDArray[np.float64]
Int = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class HyperbolicLayout(Layout):
    """One point of the hyperbolic plane for each vertex, with every triangle turned outward.

    Attributes:
        mesh: of genus 2 or more.
        points: (n, 3) on the hyperboloid z² − x² − y² = 1, z > 0.
        corner_shift: (m, 3, 2) elements of the deck group, and zeros: a corner's vertex, so
            carried, stands beside the face's other corners.
        deck: the group.
    """

    deck: Deck = field(kw_only=True)

    @property
    def flat(self) -> bool:
        return False

    @property
    def domain_area(self) -> float:
        """4π (g − 1), by Gauss and Bonnet."""
        return self.deck.area

    @property
    def shares(self) -> Float:
        return np.asarray(_areas(self.corners) / self.domain_area)

    @cached_property
    def elements(self) -> Int:
        """(m, 3): the deck's element of each corner."""
        return np.ascontiguousarray(self.corner_shift[:, :, 0]).astype(np.int64)

    @cached_property
    def corners(self) -> Float:
        return np.asarray(_corners(self.points, self.mesh.faces, self.elements, self.deck.tables))

    @cached_property
    def jump_elements(self) -> Int:
        """(m, 3): the element that takes a point across the edge opposite corner k."""
        mesh = self.mesh
        return np.asarray(_jumps(mesh.faces, mesh.neighbours, self.elements, self.deck.tables))

    def frames(self) -> Float:
        return np.asarray(_frames(self.points))

    def along(self, frames: Float, move: Float) -> Float:
        """The points after moves along their frames; NaN where a move leaves the plane."""
        return np.asarray(_along(self.points, frames, move))

    def area_gradients(self, frames: Float) -> Float:
        faces, tables = self.mesh.faces, self.deck.tables
        return np.asarray(_area_gradients(self.corners, faces, self.elements, frames, tables))

    def cotangents(self) -> Float:
        corners = self.corners
        gaps = (corners[:, k - 2] - corners[:, k - 1] for k in range(3))
        sides = np.stack([gap**2 @ np.diag(METRIC) for gap in gaps], axis=1)
        areas = np.abs(self.shares)[:, None] * self.domain_area
        return np.asarray((sides.sum(axis=1, keepdims=True) - 2 * sides) / (8 * areas))

    def comparable(self, frames: Float) -> Float:
        """Far from the middle vectors are long in space: they are made shorter by z."""
        return np.asarray(frames / self.points[:, 2, None, None])

    def locator(self) -> Locator:
        return HyperbolicLocator(self)

    def moved(self, points: Float) -> HyperbolicLayout:
        return HyperbolicLayout(self.mesh, points, self.corner_shift, deck=self.deck)

    def gathered(self) -> HyperbolicLayout:
        """The same layout with every vertex in the polygon about the middle."""
        points, moved_by = gather(self.points, self.deck)
        elements = _carried_elements(self.mesh.faces, self.elements, moved_by, self.deck.tables)
        return laid_out(self.mesh, points, elements, self.deck)


def laid_out(mesh: ClosedMesh, points: Float, elements: Int, deck: Deck) -> HyperbolicLayout:
    """A layout from the elements (m, 3) of its corners."""
    shift = np.zeros((*elements.shape, 2))
    shift[:, :, 0] = elements
    return HyperbolicLayout(mesh, points, shift, deck=deck)


def unplaced(mesh: ClosedMesh, deck: Deck) -> HyperbolicLayout:
    """A mesh that has no places on the surface yet."""
    nowhere = np.full((len(mesh.vertices), 3), np.nan)
    return laid_out(mesh, nowhere, np.zeros(mesh.faces.shape, np.int64), deck)


def gather(points: Float, deck: Deck) -> tuple[Float, Int]:
    """Points (n, 3) carried into the polygon about the middle, and by which elements (n,)."""
    gathered, elements = _gather(points, deck.letters, deck.pairings(), deck.tables)
    return np.asarray(gathered), np.asarray(elements)


class HyperbolicLocator(Locator):
    """Finds points of the plane in a layout.

    Attributes:
        frame: (q,) the element that took each point to its triangle.
    """

    def __init__(self, layout: HyperbolicLayout) -> None:
        super().__init__(layout)
        self._deck = layout.deck
        self.frame: Int = np.zeros(0, np.int64)

    def find(self, points: Float, start: Int | None = None) -> Int:
        layout = self.layout
        assert isinstance(layout, HyperbolicLayout)
        if start is None:
            start = self.face if len(self.face) == len(points) else np.zeros(len(points), np.int64)
        gathered, moved_by = gather(points, self._deck)
        self.face, self.weights, self.frame = _locate(
            gathered,
            moved_by,
            start,
            layout.corners,
            layout.mesh.neighbours,
            layout.jump_elements,
            self._deck.tables,
        )
        return self.face


@njit(cache=True, error_model="numpy")
def _corners(points, faces, elements, tables):
    corners = np.empty((len(faces), 3, 3))
    for f in range(len(faces)):
        for k in range(3):
            x, y, z = points[faces[f, k]]
            x, y, z = carry(tables[0], elements[f, k], x, y, z)
            corners[f, k, 0], corners[f, k, 1], corners[f, k, 2] = x, y, z
    return corners


@njit(cache=True, error_model="numpy")
def _areas(corners):
    areas, gradient = np.empty(len(corners)), np.empty((3, 3))
    for f in range(len(corners)):
        areas[f] = area_and_gradient_on(corners[f], -1.0, gradient)
    return areas


@njit(cache=True, error_model="numpy")
def _area_gradients(corners, faces, elements, frames, tables):
    result = np.zeros((len(faces), 3, 2))
    gradient = np.empty((3, 3))
    for f in range(len(faces)):
        area_and_gradient_on(corners[f], -1.0, gradient)
        for k in range(3):
            frame = frames[faces[f, k]]
            for i in range(2):
                x, y, z = frame[0, i], frame[1, i], frame[2, i]
                x, y, z = carry(tables[0], elements[f, k], x, y, z)
                result[f, k, i] = gradient[k, 0] * x + gradient[k, 1] * y + gradient[k, 2] * z
    return result


@njit(cache=True, error_model="numpy")
def _jumps(faces, neighbours, elements, tables):
    jumps = np.zeros((len(faces), 3), np.int64)
    for f in range(len(faces)):
        for k in range(3):
            e, g = (k + 1) % 3, neighbours[f, k]
            for c in range(3):
                if faces[g, c] == faces[f, e]:
                    jumps[f, k] = product(tables, elements[g, c], -elements[f, e])
    return jumps


@njit(cache=True, error_model="numpy")
def _frames(points):
    frames = np.empty((len(points), 3, 2))
    for v in range(len(points)):
        ux, uy, uz, wx, wy, wz = tangents_on(points[v, 0], points[v, 1], points[v, 2], -1.0)
        frames[v, 0, 0], frames[v, 1, 0], frames[v, 2, 0] = ux, uy, uz
        frames[v, 0, 1], frames[v, 1, 1], frames[v, 2, 1] = wx, wy, wz
    return frames


@njit(cache=True, error_model="numpy")
def _along(points, frames, move):
    moved = np.empty_like(points)
    for v in range(len(points)):
        for d in range(3):
            step = frames[v, d, 0] * move[v, 0] + frames[v, d, 1] * move[v, 1]
            moved[v, d] = points[v, d] + step
        if not onto_domain(moved[v], -1.0):
            moved[v] = np.nan
    return moved


@njit(cache=True, error_model="numpy")
def _gather(points, letters, pairings, tables):
    gathered, elements = points.copy(), np.zeros(len(points), np.int64)
    for v in range(len(points)):
        while True:
            height, best = gathered[v, 2] * (1 - 1e-12), -1
            for j in range(len(letters)):
                row = pairings[j, 2]
                z = row[0] * gathered[v, 0] + row[1] * gathered[v, 1] + row[2] * gathered[v, 2]
                if z < height:
                    height, best = z, j
            if best < 0:
                break
            gathered[v] = pairings[best] @ gathered[v]
            elements[v] = product(tables, letters[best], elements[v])
    return gathered, elements


@njit(cache=True, error_model="numpy")
def _carried_elements(faces, elements, moved_by, tables):
    carried = np.zeros_like(elements)
    for f in range(len(faces)):
        first = product(tables, moved_by[faces[f, 0]], -elements[f, 0])
        for k in range(3):
            back = product(tables, elements[f, k], -moved_by[faces[f, k]])
            carried[f, k] = product(tables, first, back)
    return carried


@njit(cache=True, error_model="numpy")
def _locate(points, moved_by, start, corners, neighbours, jumps, tables):
    q = len(points)
    found, weights, frame = np.empty(q, np.int64), np.empty((q, 3)), np.empty(q, np.int64)
    side = np.empty(3)
    for i in range(q):
        x, y, z = points[i]
        face, came, element = start[i], -1, moved_by[i]
        for turn in range(4 * len(corners)):
            across = _edge_to_cross(corners[face], neighbours[face], came, turn, x, y, z, side)
            if across < 0:
                break
            jump = jumps[face, across]
            x, y, z = carry(tables[0], jump, x, y, z)
            element = product(tables, jump, element)
            came, face = face, neighbours[face, across]
        for k in range(3):
            weights[i, k] = max(side[k], 0.0)
        weights[i] /= weights[i].sum()
        found[i], frame[i] = face, element
    return found, weights, frame


@njit(cache=True, error_model="numpy")
def _edge_to_cross(corners, neighbours, came, turn, x, y, z, side):
    """An edge that has the point beyond it, in turn, lest the walk go in circles; -1: none."""
    across = -1
    for k in range(3):
        a, b = corners[(k + 1) % 3], corners[(k + 2) % 3]
        side[k] = (
            x * (a[1] * b[2] - a[2] * b[1])
            + y * (a[2] * b[0] - a[0] * b[2])
            + z * (a[0] * b[1] - a[1] * b[0])
        )
    for k in range(3):
        e = (k + turn) % 3
        if side[e] < OUTSIDE:
            across = e
            if neighbours[e] != came:
                break
    return across
