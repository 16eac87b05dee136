"""From two layouts on one domain to a goal's triangles: exact ones, then as few as will do."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.goals.maps.closed_mesh import ClosedMesh
from touchwarp.goals.maps.hyperbolic.layout import HyperbolicLayout
from touchwarp.goals.maps.hyperbolic.overlay import overlay as hyperbolic_overlay
from touchwarp.goals.maps.layout import Layout
from touchwarp.goals.maps.overlay import overlay
from touchwarp.goals.maps.simplify import FineMap, simplify

Float = NDArray[np.float64]
Int = NDArray[np.int64]

NORMAL_PART = 0.6
"""Of the tolerance: how far corners may stray along normals; between them faces stray farther."""
DRIFT = 5.0
"""Tolerances by which images may slide along the virtual surface."""
SAME_PLANE = 1.0 - 1e-12


def linear_map(
    prop: Layout, virtual: Layout, tolerance: float, area_factor: float
) -> tuple[Float, Float, Int]:
    """Points of the prop (n, 3) m, their images (n, 3) m on the virtual surface, and faces (m, 3).

    Args:
        prop, virtual: on the same domain; no triangle turned over.
        tolerance: m, the greatest distance of faces' images from the virtual surface.
        area_factor: by which ratios of area may change for the sake of fewer faces, > 1.

    Raises:
        GoalError: a triangle of a layout is too thin.
    """
    if isinstance(prop, HyperbolicLayout) and isinstance(virtual, HyperbolicLayout):
        cut = hyperbolic_overlay(prop, virtual)
    else:
        cut = overlay(prop, virtual)
    fine = FineMap(
        cut.points,
        cut.images,
        cut.faces,
        flat_parts(prop.mesh)[cut.prop_face],
        prop.mesh.face_normals[cut.prop_face],
        virtual.mesh.face_normals[cut.virtual_face],
        _areas(cut.images, cut.faces) / np.maximum(_areas(cut.points, cut.faces), 1e-300),
    )
    return simplify(fine, NORMAL_PART * tolerance, DRIFT * tolerance, area_factor)


def flat_parts(mesh: ClosedMesh) -> Int:
    """(m,): faces with one number lie in one plane, and hang together."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    m = len(mesh.faces)
    one, other = np.repeat(np.arange(m), 3), mesh.neighbours.ravel()
    normals = mesh.face_normals
    flat = np.asarray((normals[one] * normals[other]).sum(axis=1) > SAME_PLANE)
    links = (np.ones(int(flat.sum()), np.bool_), (one[flat], other[flat]))
    parts = connected_components(coo_matrix(links, shape=(m, m)), directed=False)[1]
    return np.asarray(parts, np.int64)


def _areas(points: Float, faces: Int) -> Float:
    a, b, c = (points[faces[:, k]] for k in range(3))
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1))
