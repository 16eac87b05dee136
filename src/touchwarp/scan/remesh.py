"""Isotropic remeshing: all edges about as long, all triangles about equilateral."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import SceneError
from touchwarp.scan.deviation import face_areas, face_normals
from touchwarp.scan.edge_operations import (
    collapse_short,
    flip_for_valence,
    place,
    relaxed,
    split_long,
)
from touchwarp.scan.soundness import inspect
from touchwarp.scene.surface import Surface

Float = NDArray[np.float64]
Int = NDArray[np.int64]
Progress = Callable[[str, float], None]

LONGEST, SHORTEST = 4 / 3, 4 / 5
"""Of the edge length: where edges are split and collapsed."""

MOST_FACES = 4_000_000


def edge_length_for(surface: Surface, faces: int) -> float:
    """m: the edge length at which that many equilateral triangles have the surface's area."""
    return math.sqrt(4 / math.sqrt(3) * float(face_areas(surface).sum()) / faces)


def remesh(
    surface: Surface,
    edge_length: float,
    *,
    iterations: int = 8,
    sharp_deg: float = 40.0,
    progress: Progress | None = None,
) -> Surface:
    """The same closed surface in triangles with edges of about one length.

    After Botsch and Kobbelt (2004): split long edges, collapse short ones, flip towards six
    neighbours, relax along the surface, go back to the nearest point of the input; repeated. Every
    vertex lies on the input surface, and the topology is the input's. Edges of more than
    `sharp_deg` between their faces' normals stay edges, their vertices on them.

    Args:
        surface: one or more closed manifolds, m.
        edge_length: m.
        iterations: how often.
        sharp_deg: 180 keeps no edge.
        progress: called as progress(step, part done).

    Raises:
        SceneError: the surface is not a closed manifold; the edge length is not positive, or so
            small that more than 4 million faces would come out.
    """
    _check(surface, edge_length)
    mesh = _Mesh(surface, edge_length, math.radians(sharp_deg))
    for i in range(iterations):
        if progress is not None:
            progress("remeshing", i / iterations)
        mesh.split(LONGEST * edge_length)
        mesh.collapse(SHORTEST * edge_length, LONGEST * edge_length)
        mesh.flip()
        mesh.relax()
    return mesh.surface()


class _Mesh:
    """Half-edges with room to grow, and the input surface to go back to."""

    def __init__(self, surface: Surface, edge_length: float, sharp_turn: float) -> None:
        import igl

        self.source = surface
        self.tree = igl.AABB()
        self.tree.init(surface.vertices, surface.faces)
        m = len(surface.faces)
        twins = _twins(surface.faces)
        normals = face_normals(surface)
        cosine = (normals[np.arange(3 * m) // 3] * normals[twins // 3]).sum(axis=1)
        crease = cosine < math.cos(sharp_turn)
        ends = np.stack([surface.faces.ravel(), surface.faces[:, [1, 2, 0]].ravel()], axis=1)
        self.crease_ends = np.ascontiguousarray(ends[crease & (twins > np.arange(3 * m))])
        used = len(surface.vertices)
        self.counts = np.array([used, m], dtype=np.int64)
        self.vertices = np.array(surface.vertices)
        self.faces = np.array(surface.faces)
        self.twin, self.sharp = twins, crease
        self.leaving = np.full(used, -1, dtype=np.int64)
        self.leaving[surface.faces.ravel()] = np.arange(3 * m)
        # a split adds a vertex and two faces; about as many as the finished mesh has, and some
        self.grow(int(3 * face_areas(surface).sum() / edge_length**2) + 1000)

    def grow(self, splits: int) -> None:
        """Make room for so many more vertices, and twice as many faces."""
        self.vertices = np.concatenate([self.vertices, np.zeros((splits, 3))])
        self.leaving = np.concatenate([self.leaving, np.full(splits, -1)])
        self.faces = np.concatenate([self.faces, np.full((2 * splits, 3), -1)])
        self.twin = np.concatenate([self.twin, np.full(6 * splits, -1)])
        self.sharp = np.concatenate([self.sharp, np.zeros(6 * splits, dtype=np.bool_)])

    def split(self, limit: float) -> None:
        """Halve edges longer than `limit`, the longest first."""
        live = self.faces[self.faces[:, 0] >= 0]
        corners = self.vertices[live]
        longest = float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max())
        bar = max(limit, longest)
        while bar > limit:
            bar = max(limit, bar / 1.5)
            while not split_long(
                self.vertices, self.faces, self.twin, self.leaving, self.sharp, self.counts, bar
            ):
                self.grow(len(self.vertices))

    def collapse(self, limit: float, longest: float) -> None:
        """Collapse edges shorter than `limit`; drop what is gone."""
        collapse_short(
            self.vertices, self.faces, self.twin, self.leaving, self.sharp, limit, longest
        )

    def flip(self) -> None:
        """Flip towards six neighbours."""
        flip_for_valence(self.vertices, self.faces, self.twin, self.leaving, self.sharp)

    def relax(self) -> None:
        """Even out along the surface, then back onto it; crease vertices back onto creases."""
        import igl

        target, creases = relaxed(self.vertices, self.faces, self.twin, self.leaving, self.sharp)
        smooth = creases == 0
        _, _, foot = self.tree.squared_distance(
            self.source.vertices, self.source.faces, target[smooth]
        )
        target[smooth] = foot
        on_crease = creases > 0
        if on_crease.any():
            _, _, foot = igl.point_mesh_squared_distance(
                target[on_crease], self.source.vertices, self.crease_ends
            )
            target[on_crease] = foot
        place(self.vertices, self.faces, self.twin, self.leaving, target)

    def surface(self) -> Surface:
        """What there is now, without what was removed."""
        live = self.faces[self.faces[:, 0] >= 0]
        used, index = np.unique(live, return_inverse=True)
        return Surface(self.vertices[used], index.reshape(-1, 3))


def _twins(faces: Int) -> Int:
    """(3·m,): of each half-edge of a closed oriented manifold the one the other way."""
    start, end = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    base = int(faces.max()) + 1
    forward, backward = start * base + end, end * base + start
    order = np.argsort(forward)
    return np.asarray(order[np.searchsorted(forward, backward, sorter=order)])


def _check(surface: Surface, edge_length: float) -> None:
    found = inspect(surface)
    if not found.closed:
        raise SceneError(
            f"a mesh with {found.faults()} cannot be remeshed; a closed manifold is needed: "
            "`touchwarp repair` makes one."
        )
    if not 0 < edge_length < math.inf:
        raise SceneError(f"the edge length is {edge_length} m; a finite length > 0 is needed.")
    faces = 4 / math.sqrt(3) * float(face_areas(surface).sum()) / edge_length**2
    if faces > MOST_FACES:
        raise SceneError(
            f"edges of {edge_length * 1e3:.3g} mm make about {faces:,.0f} faces; at most "
            f"{MOST_FACES:,} are allowed: ask for longer edges."
        )
