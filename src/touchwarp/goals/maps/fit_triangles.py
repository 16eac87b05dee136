"""Triangles of a map cut finer until their straight images lie on the virtual surface.

A new vertex goes where the middle of its edge's image meets the virtual surface, so that images
stay as round as they are; where that would turn a triangle over on the domain, or fold its image,
it goes to the middle on the domain. Where that folds too, the edge is not divided: images are then
coarser than the tolerance there, but none winds the other way. The prop keeps its shape.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.goals.maps.base import Base
from touchwarp.goals.maps.iron import folded_faces, iron
from touchwarp.goals.maps.layout import Layout, triangle_areas
from touchwarp.goals.maps.locate import Locator
from touchwarp.goals.surface_tree import SurfaceTree
from touchwarp.scene.surface import Surface

Float = NDArray[np.float64]
Int = NDArray[np.int64]

MOST_FACES = 200_000
ROUNDS = 14
NEAR = 0.35
"""The middle of an image is moved onto the surface by at most this part of the edge's length."""
LEAST_PART = 1e-3
"""No new triangle may have less than this part of its parent's share of the domain."""


@dataclass(eq=False)
class Fitted:
    """A map on fine triangles.

    Attributes:
        points, images: (n, 3) m, scene frame: on the prop, and on the virtual surface.
        faces: (m, 3).
        standing: (n,) which points stand on the base that must stay in its plane.
        corner_shift: (m, 3, 2); places: (n, 3): the map on the domain, as in `Layout`.
        distance: m, the greatest that was found between images of triangles and the surface.
        capped: more triangles would have been needed than are allowed, or than go without folds.
    """

    points: Float
    images: Float
    places: Float
    faces: Int
    corner_shift: Float
    standing: NDArray[np.bool_]
    distance: float = 0.0
    capped: bool = False


def fit_triangles(
    layout: Layout,
    virtual: Layout,
    surface: Surface,
    tolerance: float,
    base: Base | None = None,
    most: int = MOST_FACES,
) -> Fitted:
    """The map of a prop's layout over the virtual one's, within `tolerance`, m, of the surface.

    Args:
        layout: the prop's mesh on the virtual layout's domain; no triangle turned over.
        virtual: the layout of a mesh that lies within micrometres of the surface.
        surface: the virtual surface, onto which all images go.
        tolerance: m.
        base: whose vertices' images are put on the plane.
        most: triangles at most.
    """
    ground = _Ground(virtual, surface)
    images = ground.at_places(layout.points)
    standing = np.zeros(len(images), np.bool_)
    if base is not None:
        standing = base.standing
        images[standing] = base.tree.nearest(images[standing]).points
    mesh = layout.mesh
    images = iron(images, mesh.faces, surface, base)
    fitted = Fitted(mesh.vertices, images, layout.points, mesh.faces, layout.corner_shift, standing)
    for _ in range(ROUNDS):
        edges, edge_of_face = _edges(fitted.faces)
        marked, distance = _mark(fitted, edges, edge_of_face, ground, tolerance)
        fitted.distance = distance
        if not marked.any():
            return fitted
        if len(fitted.faces) + int(marked[edge_of_face].sum()) > most:
            break
        finer = _split_unfolded(fitted, edges, edge_of_face, marked, ground)
        if len(finer.faces) == len(fitted.faces):
            break
        fitted = finer
    fitted.distance, fitted.capped = distance, True
    return fitted


class _Ground:
    """The virtual surface, reached from space and from the domain."""

    def __init__(self, virtual: Layout, surface: Surface) -> None:
        self.virtual = virtual
        self.mesh_tree = SurfaceTree(virtual.mesh.vertices, virtual.mesh.faces)
        self.tree = SurfaceTree(surface.vertices, surface.faces)
        corners = surface.vertices[surface.faces]
        self.normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.locator = Locator(virtual)

    def at_places(self, places: Float) -> Float:
        """(k, 3) m: points of the surface at places (k, 3) of the domain."""
        self.locator.find(places)
        return self.tree.nearest(self.locator.values(self.virtual.mesh.vertices)).points

    def place_of(self, points: Float, near: Float) -> Float:
        """(k, 3): places on the domain of points (k, 3) m, on the side of the cuts of `near`."""
        mesh = self.virtual.mesh
        found = self.mesh_tree.nearest(points)
        weights = barycentric(mesh.vertices[mesh.faces[found.elements]], found.points)
        places = np.einsum("kc,kcd->kd", weights, self.virtual.corners[found.elements])
        if self.virtual.flat:
            places[:, :2] += np.rint(near[:, :2] - places[:, :2])
        else:
            places /= np.linalg.norm(places, axis=1, keepdims=True)
        return np.asarray(places)


def barycentric(corners: Float, points: Float) -> Float:
    """(k, 3) barycentric coordinates of points (k, 3) in triangles (k, 3, 3)."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    parts = np.stack(
        [
            (np.cross(corners[:, k - 2] - points, corners[:, k - 1] - points) * normal).sum(axis=1)
            for k in range(3)
        ],
        axis=1,
    )
    parts = np.maximum(parts, 0.0)
    return np.asarray(parts / np.maximum(parts.sum(axis=1, keepdims=True), np.finfo(float).tiny))


def _edges(faces: Int) -> tuple[Int, Int]:
    """Edges (e, 2), and which one follows each corner of each face (m, 3)."""
    after = faces[:, [1, 2, 0]]
    base = int(faces.max()) + 1
    keys, of_face = np.unique(
        np.minimum(faces, after) * base + np.maximum(faces, after), return_inverse=True
    )
    return np.stack([keys // base, keys % base], axis=1), of_face.reshape(-1, 3)


def _lengths(fitted: Fitted, edges: Int) -> Float:
    """(e,) m: of edges on the prop; halving the longest keeps its angles (Rivara 1984)."""
    return np.asarray(
        np.linalg.norm(fitted.points[edges[:, 0]] - fitted.points[edges[:, 1]], axis=1)
    )


def _mark(
    fitted: Fitted, edges: Int, edge_of_face: Int, ground: _Ground, tolerance: float
) -> tuple[NDArray[np.bool_], float]:
    """Edges to split (e,), and the greatest distance found, m."""
    images = fitted.images
    strayed = ground.tree.nearest(images[edges].mean(axis=1)).distance
    in_face = ground.tree.nearest(images[fitted.faces].mean(axis=1)).distance
    length = _lengths(fitted, edges)
    can_split = length > tolerance
    marked = (strayed > tolerance) & can_split
    longest = _longest(length, edge_of_face)
    marked[longest[in_face > tolerance]] = True
    marked &= can_split
    while True:  # a face is split across its longest edge before others, so that it stays round
        more = longest[marked[edge_of_face].any(axis=1) & ~marked[longest]]
        if len(more) == 0:
            break
        marked[more] = True
    return marked, float(max(strayed.max(), in_face.max()))


def _longest(length: Float, edge_of_face: Int) -> Int:
    """(m,): each face's longest edge."""
    which = length[edge_of_face].argmax(axis=1)[:, None]
    return np.asarray(np.take_along_axis(edge_of_face, which, axis=1)[:, 0])


def _split_unfolded(
    fitted: Fitted, edges: Int, edge_of_face: Int, marked: NDArray[np.bool_], ground: _Ground
) -> Fitted:
    """Those of the marked edges (e,) split that leave no new triangle's image folded."""
    longest = _longest(_lengths(fitted, edges), edge_of_face)
    while marked.any():
        finer, spoiled = _split(fitted, edges, edge_of_face, marked, ground)
        if len(spoiled) == 0:
            return finer
        marked = marked.copy()
        marked[spoiled] = False
        while True:  # nor are faces split across a shorter edge alone
            idle = edge_of_face[~marked[longest]]
            if not marked[idle].any():
                break
            marked[idle] = False
    return fitted


def _split(
    fitted: Fitted, edges: Int, edge_of_face: Int, marked: NDArray[np.bool_], ground: _Ground
) -> tuple[Fitted, Int]:
    """All marked edges (e,) split; and which of them still have folded images beside them."""
    flat = ground.virtual.flat
    faces, shift = fitted.faces, fitted.corner_shift
    halved = np.flatnonzero(marked)
    number = np.full(len(edges), -1)
    number[halved] = len(fitted.points) + np.arange(len(halved))
    # Each new vertex's place, on the side of the cuts of the first face that has its edge.
    _, first = np.unique(edge_of_face.ravel(), return_index=True)
    face, side = first[halved] // 3, first[halved] % 3
    ends = [_place(fitted, face, (side + k) % 3) for k in (0, 1)]
    on_domain = (ends[0] + ends[1]) / 2
    if not flat:
        on_domain /= np.linalg.norm(on_domain, axis=1, keepdims=True)
    origin = np.zeros((len(edges), 2))
    origin[halved] = shift[face, side]
    lead = np.full(len(edges), -1)
    lead[halved] = faces[face, side]

    pair = fitted.images[edges[halved]]
    middle = pair.mean(axis=1)
    projected = ground.tree.nearest(middle)
    straight = projected.distance < NEAR * np.linalg.norm(pair[:, 0] - pair[:, 1], axis=1)
    in_space = ground.place_of(projected.points, on_domain)
    parents, new_faces, new_shift = _children(fitted, edges, edge_of_face, number, origin, lead)
    before = triangle_areas(fitted.places, faces, shift, flat)[parents]
    divided = np.flatnonzero((new_faces >= len(fitted.points)).any(axis=1))
    images_on_domain = ground.at_places(on_domain)
    standing = fitted.standing[edges[halved]].all(axis=1)
    images_on_domain[standing] = projected.points[standing]  # nothing lifts these off the plane
    while True:
        places = np.concatenate([fitted.places, np.where(straight[:, None], in_space, on_domain)])
        images = np.where(straight[:, None], projected.points, images_on_domain)
        images = np.concatenate([fitted.images, images])
        after = triangle_areas(places, new_faces, new_shift, flat)
        unsound = after < LEAST_PART * before
        beside = new_faces[divided]
        unsound[divided] |= folded_faces(images, beside, ground.tree, ground.normals) > 0
        turned = np.unique(new_faces[unsound]) - len(fitted.points)
        turned = turned[turned >= 0]
        if not straight[turned].any():
            break
        straight[turned] = False
    points = np.concatenate([fitted.points, fitted.points[edges[halved]].mean(axis=1)])
    standing = np.concatenate([fitted.standing, standing])
    return Fitted(points, images, places, new_faces, new_shift, standing), halved[turned]


def _place(fitted: Fitted, face: Int, corner: Int) -> Float:
    place = fitted.places[fitted.faces[face, corner]]
    place[:, :2] += fitted.corner_shift[face, corner]
    return place


def _children(
    fitted: Fitted, edges: Int, edge_of_face: Int, number: Int, origin: Float, lead: Int
) -> tuple[Int, Int, Float]:
    """Each new face's parent, the faces, and their corner shifts.

    Args:
        fitted: before the split.
        edges: (e, 2); edge_of_face: (m, 3).
        number: (e,) the new vertex of each edge, or -1.
        origin: (e, 2) the shift of the vertex `lead` (e,) where the new vertex's place was taken.
        lead: (e,) one end of each edge.
    """
    faces = fitted.faces
    length = _lengths(fitted, edges)[edge_of_face]
    turn = (length.argmax(axis=1)[:, None] + np.arange(3)) % 3
    v = np.take_along_axis(faces, turn, axis=1)
    s = np.take_along_axis(fitted.corner_shift, turn[:, :, None], axis=1)
    e = np.take_along_axis(edge_of_face, turn, axis=1)
    from_first = (lead[e] == v)[:, :, None]
    middle_shift = np.where(from_first, s, np.roll(s, -1, axis=1)) - origin[e]
    # Corners 0, 1, 2 and the middles 3 (of 0-1, the longest), 4 (of 1-2), 5 (of 2-0).
    v = np.concatenate([v, number[e]], axis=1)
    s = np.concatenate([s, middle_shift], axis=1)
    split = v[:, 3] >= 0
    parts = [(~split, (0, 1, 2))]
    for cut, whole, halves in (
        (v[:, 4] >= 0, (3, 1, 2), ((3, 1, 4), (3, 4, 2))),
        (v[:, 5] >= 0, (0, 3, 2), ((0, 3, 5), (5, 3, 2))),
    ):
        parts.append((split & ~cut, whole))
        parts += [(split & cut, half) for half in halves]
    parents = np.concatenate([np.flatnonzero(some) for some, _ in parts])
    new_faces = np.concatenate([v[some][:, corners] for some, corners in parts])
    new_shift = np.concatenate([s[some][:, corners] for some, corners in parts])
    return parents, new_faces, np.ascontiguousarray(new_shift)
