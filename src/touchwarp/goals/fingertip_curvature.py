"""Curvature as a fingertip feels it: averaged over a patch of a fingertip's size.

On a mesh mean curvature sits on the edges, θℓ/2 on an edge of length ℓ that turns by θ, and
Gaussian curvature at the vertices, where the angles miss 2π (Cohen-Steiner & Morvan 2003). Both
measures are spread over the surface by one implicit step of diffusion, (M + a L) h = b, whose
kernel has the second moment of a disc of the fingertip's radius r when a = r²/8. The result is
finite at sharp edges, quiet on scans, smooth, and never reaches through a thin wall, since it
spreads along the surface. It is exactly 1/R on a sphere and 1/(2R) on a cylinder.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix, diags
from scipy.sparse.linalg import splu

from touchwarp.goals.surface_samples import SharpEdges, face_areas, face_normals, find_sharp_edges

Float = NDArray[np.float64]
Int = NDArray[np.int64]

FINGERTIP_RADIUS = 8e-3
"""m."""


class Curvature(NamedTuple):
    """Curvature at points of a surface, averaged over a fingertip, positive where convex.

    Attributes:
        mean: (n,) 1/m: half the sum of the principal curvatures.
        gaussian: (n,) 1/m²: their product.
    """

    mean: Float
    gaussian: Float


def fingertip_curvature(vertices: Float, faces: Int, radius: float = FINGERTIP_RADIUS) -> Curvature:
    """Curvature at the vertices of a surface whose edges are shorter than the fingertip.

    Vertices that coincide are one. A surface with longer edges is to be refined first
    (`touchwarp.goals.refinement`), for a long edge's curvature would sit at its ends.

    Args:
        vertices: (n, 3) m.
        faces: (m, 3), wound so that normals look outward.
        radius: m, of the fingertip.
    """
    n = len(vertices)
    _, first, same = np.unique(vertices, axis=0, return_index=True, return_inverse=True)
    one = first[same.reshape(-1)]
    merged = one[faces]
    merged = merged[(merged != np.roll(merged, 1, axis=1)).all(axis=1)]
    mass = vertex_areas(vertices, merged)
    used = np.flatnonzero(mass > 0)
    edges = find_sharp_edges(vertices, merged, turn_deg=0.0)
    measures = np.stack(
        [_mean_measure(vertices, merged, edges), _angle_defects(vertices, merged, edges)], axis=1
    )
    L = _stiffness(vertices, merged)
    step = radius**2 / 8.0
    A = (diags(mass) + step * L).tocsr()[used][:, used]
    # symmetric and positive definite: no pivoting is needed, which keeps the factors sparse
    factors = splu(
        A.tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    spread = np.zeros((n, 2))
    spread[used] = factors.solve(measures[used])
    return Curvature(spread[one, 0], spread[one, 1])


def vertex_areas(vertices: Float, faces: Int) -> Float:
    """(n,) m²: a third of the faces around each vertex."""
    third = np.repeat(face_areas(vertices, faces) / 3.0, 3)
    return np.asarray(np.bincount(faces.reshape(-1), third, len(vertices)), np.float64)


def _mean_measure(vertices: Float, faces: Int, edges: SharpEdges) -> Float:
    """(n,) m: the integral of mean curvature around each vertex, half of each edge's θℓ/2."""
    inner = ~edges.rim
    ends, pair = edges.ends[inner], edges.faces[inner]
    normals = face_normals(vertices, faces)
    middle = vertices[faces].mean(axis=1)
    opening = np.einsum(
        "ij,ij->i",
        normals[pair[:, 1]] - normals[pair[:, 0]],
        middle[pair[:, 1]] - middle[pair[:, 0]],
    )
    measure = 0.25 * np.where(opening >= 0, 1.0, -1.0) * edges.turn[inner] * edges.length[inner]
    twice = np.repeat(measure, 2)
    return np.asarray(np.bincount(ends.reshape(-1), twice, len(vertices)), np.float64)


def _angle_defects(vertices: Float, faces: Int, edges: SharpEdges) -> Float:
    """(n,) rad: the integral of Gaussian curvature around each vertex; 0 on open rims."""
    around = np.zeros(len(vertices))
    for k in range(3):
        corner, left, right = (vertices[faces[:, (k + j) % 3]] for j in range(3))
        one, two = left - corner, right - corner
        across = np.linalg.norm(np.cross(one, two), axis=1)
        angle = np.arctan2(across, np.einsum("ij,ij->i", one, two))
        around += np.bincount(faces[:, k], angle, minlength=len(vertices))
    defect = np.where(around > 0, 2.0 * math.pi - around, 0.0)
    defect[edges.ends[edges.rim].reshape(-1)] = 0.0
    return defect


def _stiffness(vertices: Float, faces: Int) -> csr_matrix:
    """The cotangent Laplacian L (n, n), positive semidefinite; needles are blunted."""
    rows, columns, values = [], [], []
    corners = vertices[faces]
    sides = corners - np.roll(corners, 1, axis=1)
    # one floor for a face's three cotangents: the sum of its entries stays semidefinite
    floor = 1e-3 * np.einsum("mij,mij->m", sides, sides)
    across = np.maximum(2.0 * face_areas(vertices, faces), floor)
    for k in range(3):
        one = corners[:, (k + 1) % 3] - corners[:, k]
        two = corners[:, (k + 2) % 3] - corners[:, k]
        half = 0.5 * np.einsum("ij,ij->i", one, two) / across
        i, j = faces[:, (k + 1) % 3], faces[:, (k + 2) % 3]
        rows += [i, j, i, j]
        columns += [j, i, i, j]
        values += [-half, -half, half, half]
    n = len(vertices)
    ijs = np.concatenate(rows), np.concatenate(columns)
    return coo_matrix((np.concatenate(values), ijs), shape=(n, n)).tocsr()
