"""Where a goal contradicts a fixed surface at the contact line, one turns into the other.

A prop that stands on a table may have a goal that lifts its foot, while the table lets nothing
through. Near the table, the part of u that contradicts it at the nearest points of contact is taken
away: wholly at the table, not at all `blend_mm` above it. The rest of the goal stays. This is
linear in g.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from touchwarp.scene import Scene
from touchwarp.solve.boundary import Boundary
from touchwarp.solve.cuts import Cuts
from touchwarp.solve.frame import Frame
from touchwarp.solve.level import Level
from touchwarp.solve.threads import threads

HELD = -1
"""Owner number of held surfaces' triangles."""

CONTACT = 1e-4
"""m: points of a prop nearer than this to a fixed surface touch it."""

NOTHING = 1e-12
"""m: goals that contradict fixed surfaces by less ask for nothing to give way."""

PITCH = 1e-3
"""m, between the samples that stand for the line of contact."""

NEAREST = 12
"""Of these many a mean is taken, in which the farthest has no weight, so that nothing jumps where
another comes in its place."""

BESIDE = 2e-3
"""m: of samples that near to one another, …"""

STEEP = 0.02
"""… those do not touch that stand above others by more than this part of the way to them. A rounded
foot is within `CONTACT` of its table some way up, where its goal may well lift it."""

FLUSH = 1e-6
"""m: samples this near to the surface touch it in any case."""


@dataclass(frozen=True, eq=False)
class Terms:
    """Which boundary values give way, by how much, to what at which point of contact.

    Attributes:
        index: (k,) rows of the values.
        triangle: (k,), barycentric: (k, 3): the point of contact.
        strength: (k,) 0..1.
        normal_only: (k,) bool: only the lanes that vanish on the sliding plane.
    """

    index: NDArray[np.int64]
    triangle: NDArray[np.int32]
    barycentric: NDArray[np.float64]
    strength: NDArray[np.float64]
    normal_only: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class _Contact:
    """One fixed surface and the points where props touch it."""

    width: float
    slide: bool
    point: NDArray[np.float64]
    normal: NDArray[np.float64] | None
    tree: cKDTree | None
    feet: cKDTree
    triangle: NDArray[np.int32]
    barycentric: NDArray[np.float64]

    def distance(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        if self.normal is not None:
            return np.abs((points - self.point) @ self.normal)
        assert self.tree is not None
        return np.asarray(self.tree.query(points)[0])

    def nearest(self, points: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """The samples of contact nearest to points (n, 3) m, (n, k), and the weight of each."""
        count = min(NEAREST, len(self.triangle))
        away, feet = self.feet.query(points, np.arange(1, count + 1), workers=threads())
        weight = (1.0 - away / np.maximum(away[:, -1:], 1e-12) + 1e-9) ** 2
        return feet, weight / weight.sum(axis=1, keepdims=True)


@dataclass(frozen=True, eq=False)
class Blend:
    """The contacts of a scene's props with its fixed surfaces; empty where there are none."""

    frame: Frame
    boundary: Boundary
    contacts: tuple[_Contact, ...]
    _asked: list[tuple[NDArray[np.float64], NDArray[np.bool_], float]] = field(default_factory=list)

    @classmethod
    def of(cls, scene: Scene, frame: Frame, boundary: Boundary) -> Blend:
        """Find where props touch fixed surfaces."""
        contacts = []
        for fixed in scene.fixed:
            point, normal, tree = np.zeros(3), None, None
            if fixed.plane is not None:
                point, normal = (np.asarray(v, dtype=np.float64) for v in fixed.plane)
            else:
                assert fixed.surface is not None
                v, f = fixed.surface.vertices, fixed.surface.faces
                tree = cKDTree(_spread(v, f, PITCH)[0])
            near = _near(frame, boundary, point, normal, tree)
            if near is not None:
                contacts.append(
                    _Contact(
                        max(fixed.blend_mm, 1e-3) * 1e-3,
                        fixed.contact == "slide",
                        point,
                        normal,
                        tree,
                        *near,
                    )
                )
        return cls(frame, boundary, tuple(contacts))

    def terms(self, grid_points: NDArray[np.float64], owner: NDArray[np.int16]) -> list[Terms]:
        """What gives way at boundary points (n, 3), root-grid coordinates, of the given owners."""
        result: list[Terms] = []
        if not self.contacts:
            return result
        candidates = np.flatnonzero((owner >= 0) & self.may_give_way(grid_points))
        for contact in self.contacts:
            index = candidates
            points = self.frame.to_scene(grid_points[index])
            distance = contact.distance(points)
            near = distance < contact.width
            index, points, distance = index[near], points[near], distance[near]
            if len(index) == 0:
                continue
            s = distance / contact.width
            feet, share = contact.nearest(points)
            share *= (1.0 - s * s * (3.0 - 2.0 * s))[:, None]
            result += [
                Terms(
                    index,
                    contact.triangle[foot],
                    contact.barycentric[foot],
                    strength,
                    np.full(len(index), contact.slide),
                )
                for foot, strength in zip(feet.T, share.T, strict=True)
            ]
        return result

    def may_give_way(
        self, grid_points: NDArray[np.float64], margin: float = 0.0
    ) -> NDArray[np.bool_]:
        """Which points, root-grid coordinates, can be in a blend's reach, give or take a margin.

        For planes by one product a point; near a fixed mesh, any.
        """
        frame = self.frame
        result = np.zeros(len(grid_points), bool)
        for contact in self.contacts:
            if contact.normal is None:
                return np.ones(len(grid_points), bool)
            normal = frame.axes_from_scene(contact.normal) * frame.spacing
            offset = float((contact.point - frame.T_scene_table[:3, 3]) @ contact.normal)
            reach = contact.width + margin * frame.spacing.max()
            result |= np.abs(grid_points @ normal - offset) < reach
        return result

    def apply(
        self,
        values: NDArray[np.floating],
        terms: list[Terms],
        data: NDArray[np.float64],
        normal_lanes: NDArray[np.bool_],
    ) -> None:
        """Take the contradicted part away from boundary values (n, C), in place."""
        for term in terms:
            corners = data[self.boundary.faces[term.triangle]]
            at_foot = np.einsum("kc,kcq->kq", term.barycentric, corners)[:, : values.shape[1]]
            at_foot *= term.strength[:, None]
            at_foot[np.ix_(term.normal_only, ~normal_lanes[: values.shape[1]])] = 0.0
            values[term.index] -= at_foot

    def contradiction(self, data: NDArray[np.float64], normal_lanes: NDArray[np.bool_]) -> float:
        """m: the greatest displacement asked for at a contact that the fixed surface forbids.

        The answer for one array of data (v, C), which nobody changes, is kept.
        """
        for known, lanes, answer in self._asked:
            if known is data and np.array_equal(lanes, normal_lanes):
                return answer
        worst = 0.0
        for contact in self.contacts:
            corners = data[self.boundary.faces[contact.triangle]]
            at_foot = np.einsum("kc,kcq->kq", contact.barycentric, corners)
            if contact.slide:
                at_foot = at_foot[:, normal_lanes]
            worst = max(worst, float(np.linalg.norm(at_foot, axis=1).max(initial=0.0)))
        self._asked[:] = [(data, normal_lanes, worst)]
        return worst


@dataclass(eq=False)
class Yielding:
    """What gives way among some boundary values; found out when a goal first asks for it.

    Attributes:
        blend: of the scene.
        find: finds the terms.
    """

    blend: Blend
    find: Callable[[], list[Terms]]
    _terms: list[Terms] | None = None

    def apply(
        self,
        values: NDArray[np.floating],
        data: NDArray[np.float64],
        normal_lanes: NDArray[np.bool_],
    ) -> None:
        """Take what the fixed surfaces forbid away from boundary values (n, C), in place.

        `data`, (v, C) at the corners, is what the values are made of.
        """
        if self.blend.contradiction(data, normal_lanes) < NOTHING:
            return
        if self._terms is None:
            self._terms = self.find()
        self.blend.apply(values, self._terms, data, normal_lanes)


def _near(
    frame: Frame,
    boundary: Boundary,
    point: NDArray[np.float64],
    normal: NDArray[np.float64] | None,
    tree: cKDTree | None,
) -> tuple[cKDTree, NDArray[np.int32], NDArray[np.float64]] | None:
    """Samples of the props within `CONTACT` of a fixed surface."""
    corners = frame.to_scene(boundary.corners)
    if normal is not None:
        height = np.abs((corners - point) @ normal)
        signed = (corners - point) @ normal
    else:
        assert tree is not None
        height = np.asarray(tree.query(corners)[0])
        signed = height
    of_faces = height[boundary.faces]
    crossing = (signed[boundary.faces].min(axis=1) < 0) & (signed[boundary.faces].max(axis=1) > 0)
    reach = CONTACT + (PITCH if tree is not None else 0.0)
    candidates = np.flatnonzero((boundary.owner >= 0) & ((of_faces.min(axis=1) < reach) | crossing))
    if len(candidates) == 0:
        return None
    samples, face, barycentric = _spread(corners, boundary.faces[candidates], PITCH)
    if normal is not None:
        distance = np.abs((samples - point) @ normal)
    else:
        assert tree is not None
        distance = np.asarray(tree.query(samples)[0])
    touching = np.flatnonzero(distance < reach)
    if len(touching) == 0:
        return None
    # Slender triangles have many samples side by side.
    corner = np.floor(samples[touching] / (PITCH / 2)).astype(np.int64)
    corner -= corner.min(axis=0)
    shape = corner.max(axis=0) + 1
    key = (corner[:, 0] * shape[1] + corner[:, 1]) * shape[2] + corner[:, 2]
    touching = touching[np.unique(key, return_index=True)[1]]
    touching = touching[~_raised(samples[touching], distance[touching])]
    return (
        cKDTree(samples[touching]),
        candidates[face[touching]].astype(np.int32),
        barycentric[touching],
    )


def _raised(samples: NDArray[np.float64], distance: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(n,): which samples (n, 3) near a fixed surface stand clear of it beside others that touch.

    Args:
        samples: m, scene frame.
        distance: (n,) m, from the surface.
    """
    raised = np.zeros(len(samples), bool)
    lifted = np.flatnonzero(distance > FLUSH)
    if len(lifted) == 0:
        return raised
    beside = cKDTree(samples).query_ball_point(samples[lifted], BESIDE, workers=threads())
    count = np.array([len(rows) for rows in beside])
    one, other = np.repeat(lifted, count), np.concatenate(beside).astype(np.int64)
    way = np.linalg.norm(samples[one] - samples[other], axis=1)
    raised[one[distance[one] - distance[other] > STEEP * way + FLUSH]] = True
    return raised


def _spread(
    vertices: NDArray[np.float64], faces: NDArray[np.integer], pitch: float
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float64]]:
    """Points on triangles, about `pitch` apart, with their faces and barycentric weights."""
    p = vertices[faces]
    longest = np.linalg.norm(p - p[:, [1, 2, 0]], axis=2).max(axis=1)
    steps = np.clip(np.ceil(longest / pitch), 1, 200).astype(np.int64)
    points, owners, weights = [], [], []
    for n in np.unique(steps):
        i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij")
        keep = i + j <= n
        w = np.stack([i[keep], j[keep], n - i[keep] - j[keep]], axis=1) / n
        which = np.flatnonzero(steps == n)
        points.append(np.einsum("wc,fcd->fwd", w, p[which]).reshape(-1, vertices.shape[1]))
        owners.append(np.repeat(which, len(w)))
        weights.append(np.tile(w, (len(which), 1)))
    return np.concatenate(points), np.concatenate(owners), np.concatenate(weights)


def terms_of_cuts(blend: Blend, level: Level, cuts: Cuts) -> list[Terms]:
    """What gives way at a level's cuts."""
    if not blend.contacts or len(cuts.node) == 0:
        return []
    nodes = level.coordinates(cuts.node).astype(np.float64)
    close = blend.may_give_way(nodes / 2.0**level.depth, margin=1.0 / 2.0**level.depth)
    rows = np.flatnonzero(close)
    counts = np.diff(cuts.start)[rows]
    index = np.repeat(cuts.start[rows] - (np.cumsum(counts) - counts), counts)
    index += np.arange(int(counts.sum()))
    points = np.repeat(nodes[rows], counts, axis=0)
    direction = cuts.direction[index]
    step = np.where(direction % 2 == 1, 1.0, -1.0) * cuts.distance[index]
    points[np.arange(len(points)), direction // 2] += step
    owner = blend.boundary.owner[cuts.triangle[index]]
    found = blend.terms(points / 2.0**level.depth, owner)
    return [replace(term, index=index[term.index]) for term in found]
