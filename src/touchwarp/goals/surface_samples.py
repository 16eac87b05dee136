"""Seeded samples of surfaces, uniform in area, and of sharp edges, uniform in length."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.goals.goal import Goal
from touchwarp.scene.weld import distinct_places

Float = NDArray[np.float64]
Int = NDArray[np.int64]

SHARP_TURN_DEG = 30.0
"""An edge is sharp where its two faces' normals differ by more than this, or where it is a rim."""


@dataclass(frozen=True, eq=False)
class SurfaceSamples:
    """Points of a prop's surface with their goals.

    Attributes:
        points: (n, d) m, scene frame.
        targets: (n, d) m, scene frame: g at the points.
        face: (n,) the face each lies on.
        normals: (n, d) unit normals of those faces, by their winding.
    """

    points: Float
    targets: Float
    face: Int
    normals: Float


@dataclass(frozen=True, eq=False)
class SharpEdges:
    """The sharp edges and open rims of a surface (the sharp corners, in the plane).

    Attributes:
        ends: (e, 2) vertex indices of the edges; in the plane (e, 1) vertices.
        rim: (e,) bool: an open rim, with one face only.
        length: (e,) m; in the plane 1.
        turn: (e,) rad, between the two faces' normals; π at rims.
        faces: (e, 2) the two faces; a rim has its one face twice.
    """

    ends: Int
    rim: NDArray[np.bool_]
    length: Float
    turn: Float
    faces: Int

    def sample(self, goal: Goal, count: int, rng: np.random.Generator) -> tuple[Float, Float]:
        """(n, d) points uniform in length and their goals; no rows where there are no edges."""
        if len(self.ends) == 0:
            empty = np.empty((0, goal.prop_points.shape[1]))
            return empty, empty
        if self.ends.shape[1] == 1:
            corners = self.ends[:, 0]
            return goal.prop_points[corners], goal.virtual_points[corners]
        edge = _spread(self.length, count, rng)
        t = rng.random((len(edge), 1))
        a, b = self.ends[edge, 0], self.ends[edge, 1]
        points = (1 - t) * goal.prop_points[a] + t * goal.prop_points[b]
        return points, (1 - t) * goal.virtual_points[a] + t * goal.virtual_points[b]


def sample_surface(goal: Goal, count: int, rng: np.random.Generator) -> SurfaceSamples:
    """`count` points uniform in area, stratified: one in each of `count` equal shares of it."""
    d = goal.prop_points.shape[1]
    area = face_areas(goal.prop_points, goal.faces)
    face = _spread(area, count, rng)
    if d == 3:
        root = np.sqrt(rng.random(count))
        along = rng.random(count)
        weights = np.stack([1 - root, root * (1 - along), root * along], axis=1)
    else:
        along = rng.random(count)
        weights = np.stack([1 - along, along], axis=1)
    normals = face_normals(goal.prop_points, goal.faces)
    return SurfaceSamples(
        _blend(goal.prop_points, goal.faces, face, weights),
        _blend(goal.virtual_points, goal.faces, face, weights),
        face,
        normals[face],
    )


def face_areas(vertices: Float, faces: Int) -> Float:
    """(m,) m²; lengths in m in the plane."""
    lengths: Float = np.linalg.norm(_scaled_normals(vertices, faces), axis=1)
    return lengths


def face_normals(vertices: Float, faces: Int) -> Float:
    """(m, d) unit normals by winding; zero rows for faces without area."""
    normals = _scaled_normals(vertices, faces)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    unit: Float = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)
    return unit


def _scaled_normals(vertices: Float, faces: Int) -> Float:
    if vertices.shape[1] == 2:
        along = vertices[faces[:, 1]] - vertices[faces[:, 0]]
        return np.stack([along[:, 1], -along[:, 0]], axis=1)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normals: Float = 0.5 * np.cross(b - a, c - a)
    return normals


def find_sharp_edges(vertices: Float, faces: Int, turn_deg: float = SHARP_TURN_DEG) -> SharpEdges:
    """The edges that turn by more than `turn_deg`, and those with one face only.

    Corners that coincide are one corner, whatever their indices. Of an edge with more than two
    faces each neighbouring pair counts.
    """
    faces = _weld(vertices, faces)
    d = vertices.shape[1]
    normals = face_normals(vertices, faces)
    kept = np.flatnonzero(normals.any(axis=1))  # faces without area have none
    faces, normals = faces[kept], normals[kept]
    if d == 3:
        sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
        owner = np.tile(np.arange(len(faces)), 3)
        forward = sides[:, 0] < sides[:, 1]
        ends = np.sort(sides, axis=1)
        key = ends[:, 0] * len(vertices) + ends[:, 1]
    else:
        ends = np.concatenate([faces[:, [0]], faces[:, [1]]])
        owner = np.tile(np.arange(len(faces)), 2)
        forward = np.repeat([True, False], len(faces))
        key = ends[:, 0]
    order = np.argsort(key, kind="stable")
    key, ends, owner, forward = key[order], ends[order], owner[order], forward[order]
    same_as_next = np.append(key[1:] == key[:-1], False)
    same_as_last = np.append(False, key[1:] == key[:-1])
    rims = np.flatnonzero(~same_as_next & ~same_as_last)
    pairs = np.flatnonzero(same_as_next)
    # neighbours that run along their common edge the same way have opposite windings
    sign = np.where(forward[pairs] == forward[pairs + 1], -1.0, 1.0)
    cosine = sign * np.einsum("ij,ij->i", normals[owner[pairs]], normals[owner[pairs + 1]])
    turn = np.arccos(np.clip(cosine, -1.0, 1.0))
    sharp = turn > math.radians(turn_deg)
    picked = np.concatenate([pairs[sharp], rims])
    both = np.stack([owner[picked], owner[picked + np.repeat([1, 0], [sharp.sum(), len(rims)])]], 1)
    length = (
        np.linalg.norm(vertices[ends[picked, 0]] - vertices[ends[picked, 1]], axis=1)
        if d == 3
        else np.ones(len(picked))
    )
    return SharpEdges(
        ends=ends[picked],
        rim=np.repeat([False, True], [sharp.sum(), len(rims)]),
        length=length,
        turn=np.concatenate([turn[sharp], np.full(len(rims), math.pi)]),
        faces=kept[both],
    )


def _weld(vertices: Float, faces: Int) -> Int:
    """The faces with one index for all vertices at one place."""
    first, same = distinct_places(vertices)
    welded: Int = first[same][faces]
    return welded


def _spread(weights: Float, count: int, rng: np.random.Generator) -> Int:
    """`count` indices, ascending, each drawn in its share of the summed weights."""
    total = np.cumsum(weights)
    drawn = (np.arange(count) + rng.random(count)) * (total[-1] / count)
    index: Int = np.minimum(np.searchsorted(total, drawn, side="right"), len(weights) - 1)
    return index


def _blend(vertices: Float, faces: Int, face: Int, weights: Float) -> Float:
    """Points on faces by barycentric weights: (n, d)."""
    corners = faces[face]
    points = weights[:, :1] * vertices[corners[:, 0]]
    for k in range(1, faces.shape[1]):
        points += weights[:, k : k + 1] * vertices[corners[:, k]]
    return points
