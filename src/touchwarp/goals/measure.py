"""How good a map from a prop to its virtual object is, whatever made it."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.goals.coverage import Coverage, cover
from touchwarp.goals.curvature_mismatch import CurvatureMismatch, curvature_mismatch
from touchwarp.goals.edge_mismatch import EdgeMismatch, edge_mismatch
from touchwarp.goals.goal import Goal
from touchwarp.goals.surface_samples import (
    SurfaceSamples,
    face_areas,
    face_normals,
    sample_surface,
)
from touchwarp.goals.surface_tree import SurfaceTree
from touchwarp.goals.tangent_map import displacement_gradients, stretches, tangent_maps
from touchwarp.scene.surface import Surface

Float = NDArray[np.float64]

SAMPLES = 50_000


@dataclass(frozen=True, eq=False)
class MapMeasures:
    """What was measured of one goal, point by point; `summary` has the numbers.

    Attributes:
        goal: the map.
        virtual: the virtual object's surface that it should map to.
        area, image_area: (m,) m², of the prop's faces and of their images.
        stretch: (m, 2) greatest and least singular value of ∂g; NaN on faces without area.
        gradient, gradient_inverse: (m,) |∇(g − x)|² on faces, |∇(g⁻¹ − y)|² on their images.
        coverage: flips, and what of the virtual surface the image reaches.
        samples: points of the prop, uniform in area, with their images.
        distance: (n,) m: from the samples' images to the virtual surface.
        vertex_distance: (k,) m: the same from the images of the vertices that faces use.
        turn: (n,) rad: between the prop's normal and the virtual surface's at the samples.
        curvature: of both surfaces over a fingertip.
        edges: of both surfaces that are sharp.
        landmark_error: (k,) m: from the images of landmarks to where they should be.
    """

    goal: Goal
    virtual: Surface
    area: Float
    image_area: Float
    stretch: Float
    gradient: Float
    gradient_inverse: Float
    coverage: Coverage
    samples: SurfaceSamples
    distance: Float
    vertex_distance: Float
    turn: Float
    curvature: CurvatureMismatch
    edges: EdgeMismatch
    landmark_error: Float

    @property
    def area_ratio(self) -> Float:
        """(m,) image's over prop's area, both as shares of the whole: 1 if all shrink alike."""
        with np.errstate(invalid="ignore", divide="ignore"):
            share = self.image_area / self.image_area.sum()
            return np.asarray(share / (self.area / self.area.sum()), np.float64)

    @property
    def diagonal(self) -> float:
        """m, of the virtual surface's box."""
        return float(np.linalg.norm(np.ptp(self.virtual.bounds, axis=0)))

    def summary(self) -> dict[str, float]:
        """Every number, in metres, radians and shares; means are over the prop's area."""
        weight = self.area / self.area.sum()
        solid = np.isfinite(self.stretch).all(axis=1) & (weight > 0)
        weight = weight[solid] / weight[solid].sum()
        ratio = self.area_ratio[solid]
        greatest, least = self.stretch[solid].T
        size = np.linalg.norm(self.samples.targets - self.samples.points, axis=1)
        image_weight = self.image_area[solid] / self.image_area[solid].sum()
        change, gaussian = self.curvature.change, self.curvature
        flipped = self.coverage.flipped
        return {
            "flips": float(flipped.sum()),
            "opposing": float(self.image_area[flipped].sum() / self.image_area.sum()),
            "coverage": float(self.coverage.covered.mean()),
            "layers": float(
                self.image_area.sum() / face_areas(self.virtual.vertices, self.virtual.faces).sum()
            ),
            "distance_vertices": float(self.vertex_distance.max()),
            "distance_mean": float(self.distance.mean()),
            "distance_p99": float(np.quantile(self.distance, 0.99)),
            "distance_max": float(self.distance.max()),
            "area_scale": float(self.image_area.sum() / self.area.sum()),
            "area_std": math.sqrt(float(weight @ (ratio - 1.0) ** 2)),
            "area_least": weighted_quantile(ratio, weight, 0.01),
            "area_greatest": weighted_quantile(ratio, weight, 0.99),
            "stretch_least": weighted_quantile(least, weight, 0.01),
            "stretch_greatest": weighted_quantile(greatest, weight, 0.99),
            "displacement_mean": float(size.mean()),
            "displacement_max": float(
                np.linalg.norm(self.goal.displacement[_used(self.goal)], axis=1).max()
            ),
            "normal_mean": float(self.turn.mean()),
            "normal_p95": float(np.quantile(self.turn, 0.95)),
            "curvature_mean": float(self.curvature.weight @ np.abs(change)),
            "curvature_p95": weighted_quantile(np.abs(change), self.curvature.weight, 0.95),
            "gaussian_mean": float(
                self.curvature.weight @ np.abs(gaussian.seen_gaussian - gaussian.felt_gaussian)
            ),
            "edges_lost": self.edges.lost,
            "edges_new": self.edges.new,
            "edges_offset": self.edges.offset,
            "landmark_max": float(self.landmark_error.max(initial=0.0)) / self.diagonal,
            "smoothness": float(weight @ self.gradient[solid]),
            "smoothness_inverse": float(image_weight @ self.gradient_inverse[solid]),
        }


def measure_map(
    goal: Goal, virtual: Surface | None = None, *, samples: int = SAMPLES, seed: int = 0
) -> MapMeasures:
    """Measure a goal against the surface that it should map to.

    Args:
        goal: of a scene in space.
        virtual: the virtual object's surface, m, scene frame; the goal's own where None is given,
            and the image itself where the goal has none.
        samples: of the prop's surface and of the virtual surface, each.
        seed: of their choice.

    Raises:
        ValueError: the goal is of a plane scene.
    """
    if goal.prop_points.shape[1] != 3:
        raise ValueError("The goal is of a plane scene; maps of surfaces in space are measured.")
    if virtual is None:
        virtual = goal.virtual_surface
    if virtual is None:
        virtual = Surface(goal.virtual_points, goal.faces)
    tree = SurfaceTree(virtual.vertices, virtual.faces)
    with ThreadPoolExecutor() as pool:
        curved = pool.submit(curvature_mismatch, goal, virtual)
        covered = pool.submit(cover, goal, virtual, tree, samples, seed)
        edges = pool.submit(edge_mismatch, goal, virtual, seed)
        maps = tangent_maps(goal)
        gradient, gradient_inverse = displacement_gradients(goal, maps)
        stretch = stretches(maps)
        taken = sample_surface(goal, samples, np.random.default_rng(seed))
        below = tree.nearest(taken.targets)
        vertex_distance = tree.nearest(goal.virtual_points[_used(goal)]).distance
    coverage = covered.result()
    felt_outward = outward(goal.prop_points, goal.faces)
    seen_outward = outward(virtual.vertices, virtual.faces)
    if seen_outward == 0.0:
        seen_outward = (felt_outward or 1.0) * coverage.handedness
    felt_outward = felt_outward or seen_outward * coverage.handedness
    cosine = (felt_outward * seen_outward) * np.einsum(
        "ij,ij->i", taken.normals, face_normals(virtual.vertices, virtual.faces)[below.elements]
    )
    return MapMeasures(
        goal=goal,
        virtual=virtual,
        area=face_areas(goal.prop_points, goal.faces),
        image_area=face_areas(goal.virtual_points, goal.faces),
        stretch=stretch,
        gradient=gradient,
        gradient_inverse=gradient_inverse,
        coverage=coverage,
        samples=taken,
        distance=below.distance,
        vertex_distance=vertex_distance,
        turn=np.arccos(np.clip(cosine, -1.0, 1.0)),
        curvature=curved.result().outward(felt_outward, seen_outward),
        edges=edges.result(),
        landmark_error=_landmark_error(goal),
    )


def outward(vertices: Float, faces: NDArray[np.int64]) -> float:
    """1 where a surface's normals look outward, −1 where inward, 0 where it has no inside.

    By the sign of the volume that it encloses, which small holes do not change.
    """
    corners = vertices[faces] - vertices[faces].mean(axis=(0, 1))
    volume = float(
        np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()
    )
    size = float(face_areas(vertices, faces).sum()) ** 1.5
    # an open sheet encloses next to nothing as seen from its own middle
    return 0.0 if abs(volume) < 1e-3 * size else math.copysign(1.0, volume)


def weighted_quantile(values: Float, weight: Float, q: float) -> float:
    """The least of the values such that a share `q` of the weight is not above it."""
    order = np.argsort(values)
    total = np.cumsum(weight[order])
    return float(values[order][min(np.searchsorted(total, q * total[-1]), len(values) - 1)])


def _used(goal: Goal) -> NDArray[np.bool_]:
    """(n,): which points faces use."""
    used = np.zeros(len(goal.prop_points), np.bool_)
    used[goal.faces] = True
    return used


def _landmark_error(goal: Goal) -> Float:
    if goal.landmarks is None or len(goal.landmarks) == 0:
        return np.zeros(0)
    tree = SurfaceTree(goal.prop_points, goal.faces)
    at = tree.nearest(goal.landmarks[:, 0])
    corners = goal.virtual_points[goal.faces[at.elements]]
    images = np.einsum("nk,nkj->nj", tree.weights(at), corners)
    error: Float = np.linalg.norm(images - goal.landmarks[:, 1], axis=1)
    return error
