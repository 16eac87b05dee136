"""How much more, or less, curved a fingertip sees the surface than it feels it."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from touchwarp.goals.fingertip_curvature import (
    FINGERTIP_RADIUS,
    Curvature,
    fingertip_curvature,
    vertex_areas,
)
from touchwarp.goals.goal import Goal
from touchwarp.goals.refinement import refine
from touchwarp.goals.surface_tree import SurfaceTree
from touchwarp.scene.surface import Surface

Float = NDArray[np.float64]

EDGES_PER_RADIUS = 3.0
"""Edges longer than the fingertip's radius over this are divided before curvature is measured."""


class CurvatureMismatch(NamedTuple):
    """Curvature of the prop, and of the virtual surface at the images of the same points.

    Attributes:
        points: (n, 3) m, of the prop.
        weight: (n,) their shares of the prop's area; they sum to 1.
        felt: (n,) 1/m: the prop's mean curvature over a fingertip, positive where convex.
        seen: (n,) 1/m: the virtual surface's.
        felt_gaussian, seen_gaussian: (n,) 1/m²: the Gaussian curvatures.
    """

    points: Float
    weight: Float
    felt: Float
    seen: Float
    felt_gaussian: Float
    seen_gaussian: Float

    @property
    def change(self) -> Float:
        """(n,) 1/m: seen less felt; positive where the surface looks more convex than it feels."""
        return self.seen - self.felt

    def outward(self, felt: float, seen: float) -> CurvatureMismatch:
        """What was measured by the winding, each surface's sign changed where its factor is −1."""
        return self._replace(felt=felt * self.felt, seen=seen * self.seen)


def curvature_mismatch(
    goal: Goal, virtual: Surface, radius: float = FINGERTIP_RADIUS
) -> CurvatureMismatch:
    """Compare curvature at points of the prop, close together, with that at their images.

    Args:
        goal: the map.
        virtual: the virtual object's surface; both are taken as wound outward.
        radius: m, of the fingertip.
    """
    with ThreadPoolExecutor() as pool:
        (prop, felt), (other, curvature) = pool.map(
            lambda surface: _refined(surface, radius),
            (Surface(goal.prop_points, goal.faces), virtual),
        )
    on_prop = SurfaceTree(goal.prop_points, goal.faces)
    at = on_prop.nearest(prop.vertices)
    corners = goal.faces[at.elements]
    images = np.einsum("nk,nkj->nj", on_prop.weights(at), goal.virtual_points[corners])
    tree = SurfaceTree(other.vertices, other.faces)
    below = tree.nearest(images)
    weights, corners = tree.weights(below), other.faces[below.elements]
    areas = vertex_areas(prop.vertices, prop.faces)
    return CurvatureMismatch(
        prop.vertices,
        areas / areas.sum(),
        felt.mean,
        np.einsum("nk,nk->n", weights, curvature.mean[corners]),
        felt.gaussian,
        np.einsum("nk,nk->n", weights, curvature.gaussian[corners]),
    )


def _refined(surface: Surface, radius: float) -> tuple[Surface, Curvature]:
    """The surface with edges short beside a fingertip, and the curvature at its vertices."""
    fine = refine(surface, radius / EDGES_PER_RADIUS)
    return fine, fingertip_curvature(fine.vertices, fine.faces, radius)
