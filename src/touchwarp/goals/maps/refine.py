"""Refining a map between two surfaces, vertex by vertex on the domain, turning no triangle over.

Gauss–Newton on

    w_d Σ A_i |g_i − x_i|² + w_s D(g − x) + w_a Σ A²/a + a − 2A
    + w_f Σ_c w_c Σ A_i (G_c(g_i) − F_c,i)² + w_l mean |g(l) − y_l|² + w_b Σ_b A_i (n·g_i − h)²

where A_i are the prop's shares of area at its vertices, D the Dirichlet energy on the prop, A and a
each triangle's share of area before and after, F_c and G_c fields on the two surfaces that the map
shall make equal, such as normals and curvature, (l, y_l) the landmarks, and b the vertices that
stand on a plane n·y = h. Lengths are in units of the surfaces' size. The barrier A²/a and a line
search that accepts positive areas only keep the map one-to-one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from touchwarp.goals.maps.areas import moved_unturned, target_shares
from touchwarp.goals.maps.block_system import BlockSystem
from touchwarp.goals.maps.layout import Layout
from touchwarp.goals.maps.rings import build_rings
from touchwarp.goals.maps.settle import corner_tables, settle

LEAST_COTANGENT = 1e-2
REACH = 0.25
"""Of the radius of a vertex's own part of the domain: how far its secants go to either side."""


@dataclass(frozen=True)
class Weights:
    """Of the terms of the energy; see the module."""

    displacement: float = 1.0
    smoothness: float = 0.0
    area: float = 0.0
    fields: float = 1.0
    landmarks: float = 0.0
    base: float = 0.0


@dataclass(frozen=True, eq=False)
class Landmarks:
    """Points of the prop's mesh, as barycentric coordinates, and where they shall appear.

    Attributes:
        face: (l,); weights: (l, 3); image: (l, 3) in the units and the frame of the fields.
    """

    face: NDArray[np.int64]
    weights: NDArray[np.float64]
    image: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Standing:
    """Vertices (n,) of the prop's mesh that must show on a plane n·y = height, scaled as fields."""

    vertices: NDArray[np.bool_]
    normal: NDArray[np.float64]
    height: float


@dataclass(eq=False)
class MapProblem:
    """What stays the same while a map is refined.

    Attributes:
        virtual: the virtual surface's layout.
        places: (n, 3) prop and (k, 3) virtual: positions, about the surfaces' centres, in units of
            their size.
        fields: (n, c) prop and (k, c) virtual: more fields to make equal, already scaled by the
            square roots of their weights.
        unit: 1/m, of the positions.
        landmarks: pairs of points.
        standing: what must stay on a plane.
        density: (m,) shares of the domain over shares of the virtual surface's area, about where
            each of the prop's triangles is shown; None: 1, as on layouts that keep areas.
    """

    prop: Layout
    virtual: Layout
    places: tuple[NDArray[np.float64], NDArray[np.float64]]
    fields: tuple[NDArray[np.float64], NDArray[np.float64]]
    unit: float = 1.0
    landmarks: Landmarks | None = None
    standing: Standing | None = None
    density: NDArray[np.float64] | None = None
    _cotangents: NDArray[np.float64] = field(init=False)

    def __post_init__(self) -> None:
        mesh = self.prop.mesh
        self.vertex_shares = mesh.vertex_areas / mesh.area
        self.target = target_shares(mesh.face_areas)
        if self.density is not None:
            self.target *= self.density
        tangent = np.tan(np.clip(mesh.corner_angles, 1e-3, np.pi - 1e-3))
        self._cotangents = np.maximum(0.5 / tangent, LEAST_COTANGENT)
        self.locator = self.virtual.locator()
        self.system = BlockSystem(mesh.faces, len(mesh.vertices))
        self._both = np.concatenate([self.places[1], self.fields[1]], axis=1)
        layout = self.prop
        ring, shift, degree, _ = build_rings(mesh.faces, layout.corner_shift, len(mesh.vertices))
        tables = corner_tables(mesh.faces, ring, degree, self.target, self._cotangents)
        self._star = (ring, shift, degree, *tables)

    def settle(
        self,
        layout: Layout,
        weights: Weights,
        rounds: int,
        chosen: NDArray[np.int64] | None = None,
    ) -> Layout:
        """Move one vertex after another, each to where it is best among its neighbours.

        Args:
            layout: the prop's layout over the virtual one's; no triangle turned over.
            weights: of the terms; landmarks are left to `refine`.
            rounds: how many.
            chosen: (k,) the vertices that may move; None: all.
        """
        n, standing = len(layout.points), self.standing
        points, near = layout.points.copy(), self.locator.find(layout.points).copy()
        plane, on = np.zeros(4), np.zeros(n, np.bool_)
        if standing is not None:
            plane, on = np.append(standing.normal, standing.height), standing.vertices
        below = self.virtual
        settle(
            self._star,
            points,
            near,
            np.concatenate([self.places[0], self.fields[0]], axis=1),
            (below.corners, below.mesh.neighbours, below.jumps, below.mesh.faces, self._both),
            (
                weights.displacement,
                weights.smoothness,
                weights.area,
                weights.fields,
                weights.base,
            ),
            self.vertex_shares,
            plane,
            on,
            np.arange(n) if chosen is None else chosen,
            rounds,
            layout.flat,
        )
        return layout.moved(points)

    def refine(
        self,
        layout: Layout,
        weights: Weights,
        most_steps: int,
        enough: float = 1e-4,
        progress: Callable[[float], None] | None = None,
    ) -> Layout:
        """Descend from `layout` until a step gains less than `enough` of the energy.

        Args:
            layout: the prop's layout over the virtual one's; no triangle turned over.
            weights: of the terms.
            most_steps: Gauss–Newton steps at most.
            enough: relative gain to stop at.
            progress: called with the part of the steps that is done.
        """
        damping = 1e-3
        energy = self._evaluate(layout, weights)
        for count in range(most_steps):
            if progress is not None:
                progress(count / most_steps)
            frames = layout.frames()
            self._assemble(layout, weights, frames)
            shares = layout.shares
            improved = False
            for _ in range(6):
                move = self.system.solve(damping)
                step = 1.0
                for _ in range(9):
                    trial, _ = moved_unturned(layout, shares, frames, step * move)
                    lower = self._evaluate(trial, weights)
                    if lower < energy:
                        improved = True
                        break
                    step *= 0.5
                if improved:
                    break
                damping *= 10
            if not improved:
                break
            gain = energy - lower
            layout, energy = trial, lower
            damping = max(1e-8, damping * (0.3 if step == 1 else 1.0 if step > 0.2 else 3.0))
            if gain < enough * energy and step > 0.4:
                break
        return layout

    def energy(self, layout: Layout, weights: Weights) -> float:
        """The energy of a map, infinite where a triangle is turned over."""
        return self._evaluate(layout, weights)

    def _evaluate(self, layout: Layout, weights: Weights) -> float:
        shares = layout.shares
        if not (shares > 0).all():
            return np.inf
        self.locator.find(layout.points)
        gaps = self._gaps()
        energy = weights.displacement * float(self.vertex_shares @ (gaps[:, :3] ** 2).sum(axis=1))
        squares = (gaps[:, 3:] ** 2).sum(axis=1)
        energy += weights.fields * float(self.vertex_shares @ squares)
        if weights.smoothness:
            faces = self.prop.mesh.faces
            for k in range(3):
                difference = gaps[faces[:, k - 2], :3] - gaps[faces[:, k - 1], :3]
                squares = (difference**2).sum(axis=1)
                energy += weights.smoothness * float(self._cotangents[:, k] @ squares)
        energy += weights.area * float((self.target**2 / shares + shares - 2 * self.target).sum())
        if self.landmarks is not None:
            energy += weights.landmarks * float((self._landmark_gaps(gaps) ** 2).sum(axis=1).mean())
        if self.standing is not None:
            off = self._off_plane(self.standing, gaps)
            energy += weights.base * float(self.vertex_shares @ off**2)
        return energy

    def _assemble(self, layout: Layout, weights: Weights, frames: NDArray[np.float64]) -> None:
        """Half the gradient and half the Hessian of the energy."""
        faces = self.prop.mesh.faces
        shares = layout.shares
        # The last trial may have been another layout: its triangles are near, though.
        self.locator.find(layout.points)
        gaps = self._gaps()
        jacobian = self._secants(layout, frames)
        system = self.system
        system.clear()
        if weights.displacement:
            system.add_residuals(
                weights.displacement * self.vertex_shares, jacobian[:, :3], gaps[:, :3]
            )
        if jacobian.shape[1] > 3:
            system.add_residuals(weights.fields * self.vertex_shares, jacobian[:, 3:], gaps[:, 3:])
        if weights.smoothness:
            system.add_differences(
                weights.smoothness * self._cotangents, jacobian[:, :3], gaps[:, :3]
            )
        if weights.area:
            gradient = layout.area_gradients(frames) / layout.domain_area
            half = 0.5 * weights.area
            system.add_areas(
                gradient,
                half * (1 - (self.target / shares) ** 2),
                half * 2 * self.target**2 / shares**3,
            )
        if self.standing is not None and weights.base:
            on = weights.base * self.vertex_shares * self.standing.vertices
            along = np.einsum("d,ndi->ni", self.standing.normal, jacobian[:, :3])
            off = self._off_plane(self.standing, gaps)
            system.add_residuals(on, along[:, None], off[:, None])
        if self.landmarks is not None and weights.landmarks:
            marks = self.landmarks
            each = weights.landmarks / len(marks.face)
            missing = self._landmark_gaps(gaps)
            for row, face in enumerate(marks.face):
                at_corners = marks.weights[row][:, None, None] * jacobian[faces[face], :3]
                system.add_in_face(int(face), each, at_corners, missing[row])

    def _secants(self, layout: Layout, frames: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, c, 2): change of place and fields along the frames, over part of a vertex's reach.

        Derivatives on the single triangle below a vertex would follow the virtual mesh's noise and
        needles, far finer than a step.
        """
        start = self.locator.face
        reach = REACH * np.sqrt(self.vertex_shares * layout.domain_area / np.pi)
        jacobian = np.empty((len(reach), self._both.shape[1], 2))
        for axis in range(2):
            ends = []
            for sign in (1.0, -1.0):
                move = np.zeros((len(reach), 2))
                move[:, axis] = sign * reach
                self.locator.find(layout.along(frames, move), start)
                ends.append(self.locator.values(self._both))
            jacobian[:, :, axis] = (ends[0] - ends[1]) / (2 * reach[:, None])
        return jacobian

    def _gaps(self) -> NDArray[np.float64]:
        """(n, 3 + c): image minus prop, of positions and then of fields."""
        gaps = self.locator.values(self._both)
        gaps[:, :3] -= self.places[0]
        gaps[:, 3:] -= self.fields[0]
        return gaps

    def _off_plane(self, standing: Standing, gaps: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n,): how far images of the standing vertices are from their plane; 0 for others."""
        off = (gaps[:, :3] + self.places[0]) @ standing.normal - standing.height
        return np.asarray(np.where(standing.vertices, off, 0.0))

    def _landmark_gaps(self, gaps: NDArray[np.float64]) -> NDArray[np.float64]:
        """(l, 3): where each landmark appears minus where it shall."""
        assert self.landmarks is not None
        corners = self.prop.mesh.faces[self.landmarks.face]
        images = gaps[:, :3] + self.places[0]
        shown = np.einsum("lk,lkd->ld", self.landmarks.weights, images[corners])
        return np.asarray(shown - self.landmarks.image)
