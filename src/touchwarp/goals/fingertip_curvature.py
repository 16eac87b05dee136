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
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csc_matrix, diags
from scipy.sparse.linalg import splu

from touchwarp.goals.refinement import normal_of, squared_length
from touchwarp.goals.surface_samples import face_areas
from touchwarp.scene.weld import distinct_places

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


@dataclass(frozen=True, eq=False)
class CurvatureMeasures:
    """What is spread over a fingertip, of any radius: integrals of curvature around vertices.

    Attributes:
        same: (n,) for each vertex, the row below of its place; −1 where no face is.
        mass: (k,) m²: M, a third of the faces around each place.
        measures: (k, 2) m and rad: the integrals of mean and of Gaussian curvature.
        stiffness: (k, k) the cotangent Laplacian L, positive semidefinite; needles are blunted.
    """

    same: Int
    mass: Float
    measures: Float
    stiffness: csc_matrix

    def over(self, radius: float) -> Curvature:
        """Curvature at the n vertices over a fingertip of a radius, m; 0 where no face is."""
        A = diags(self.mass, format="csc") + radius**2 / 8.0 * self.stiffness
        # symmetric and positive definite: no pivoting is needed, which keeps the factors sparse
        factors = splu(
            A,
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        spread = np.concatenate([factors.solve(self.measures), np.zeros((1, 2))])[self.same]
        return Curvature(spread[:, 0], spread[:, 1])


def fingertip_curvature(vertices: Float, faces: Int, radius: float = FINGERTIP_RADIUS) -> Curvature:
    """Curvature at the vertices of a surface whose edges are shorter than the fingertip.

    Vertices that coincide are one. A surface with longer edges is to be refined first
    (`touchwarp.goals.refinement`), for a long edge's curvature would sit at its ends.

    Args:
        vertices: (n, 3) m.
        faces: (m, 3), wound so that normals look outward.
        radius: m, of the fingertip.
    """
    return curvature_measures(vertices, faces).over(radius)


def curvature_measures(vertices: Float, faces: Int) -> CurvatureMeasures:
    """The integrals of a surface's curvature around its vertices; see `fingertip_curvature`."""
    first, same = distinct_places(vertices)
    places, merged = vertices[first], same[faces]
    merged = merged[(merged != np.roll(merged, 1, axis=1)).all(axis=1)]
    mass, angles, normals, cotangents = _measure_faces(places, merged)
    side = np.concatenate([merged[:, [0, 1]], merged[:, [1, 2]], merged[:, [2, 0]]])
    key = side.min(axis=1) * len(places) + side.max(axis=1)
    order = np.argsort(key, kind="stable")
    starts = np.flatnonzero(np.r_[True, np.diff(key[order]) != 0, True])
    mean, on_rim, weight = _measure_edges(
        places, merged, normals, cotangents.T.reshape(-1), order, starts
    )
    gaussian = np.where(on_rim, 0.0, 2.0 * math.pi - angles)
    used = np.flatnonzero(mass > 0)
    row = np.full(len(places), -1)
    row[used] = np.arange(len(used))
    ends = row[side[order[starts[:-1]]]]
    whole = (ends >= 0).all(axis=1)
    (i, j), weight = ends[whole].T, weight[whole]
    entries = np.concatenate([-weight, -weight, weight, weight])
    at = np.concatenate([i, j, i, j]), np.concatenate([j, i, i, j])
    return CurvatureMeasures(
        row[same],
        mass[used],
        np.stack([mean, gaussian], axis=1)[used],
        coo_matrix((entries, at), shape=(len(used), len(used))).tocsc(),
    )


def vertex_areas(vertices: Float, faces: Int) -> Float:
    """(n,) m²: a third of the faces around each vertex."""
    third = np.repeat(face_areas(vertices, faces) / 3.0, 3)
    return np.asarray(np.bincount(faces.reshape(-1), third, len(vertices)), np.float64)


@njit(cache=True, nogil=True, error_model="numpy")
def _measure_faces(vertices, faces):
    """What faces give to their vertices and edges.

    Returns:
        (n,) m²: a third of the area around each vertex; (n,) rad: the sum of angles there; (m, 3)
        unit normals, 0 where a face has no area; (m, 3) half the cotangent across from side k.
    """
    mass, angles = np.zeros(len(vertices)), np.zeros(len(vertices))
    normals, cotangents = np.zeros((len(faces), 3)), np.empty((len(faces), 3))
    for f in range(len(faces)):
        a, b, c = faces[f]
        nx, ny, nz = normal_of(vertices, a, b, c)
        across = math.sqrt(nx * nx + ny * ny + nz * nz)
        if across > 0:
            normals[f, 0], normals[f, 1], normals[f, 2] = nx / across, ny / across, nz / across
        around = 0.0
        for k in range(3):
            around += squared_length(vertices, faces[f, k], faces[f, (k + 1) % 3])
        # one floor for a face's three cotangents: the sum of its entries stays semidefinite
        blunted = max(across, 1e-3 * around)
        for k in range(3):
            corner, left, right = faces[f, k], faces[f, (k + 1) % 3], faces[f, (k + 2) % 3]
            along = 0.0
            for d in range(3):
                along += (vertices[left, d] - vertices[corner, d]) * (
                    vertices[right, d] - vertices[corner, d]
                )
            mass[corner] += across / 6.0
            angles[corner] += math.atan2(across, along)
            cotangents[f, (k + 1) % 3] = 0.5 * along / blunted
    return mass, angles, normals, cotangents


@njit(cache=True, nogil=True, error_model="numpy")
def _measure_edges(vertices, faces, normals, cotangents, order, starts):
    """What edges give: the sides of faces, k m + f, ordered so that those of one edge follow.

    Returns:
        (n,) m: the integral of mean curvature around each vertex, half of each edge's θℓ/2; (n,)
        which are on open rims; (e,) the sum of half cotangents across from each edge.
    """
    m = len(faces)
    mean, on_rim = np.zeros(len(vertices)), np.zeros(len(vertices), np.bool_)
    weight = np.zeros(len(starts) - 1)
    for e in range(len(starts) - 1):
        last, count, ends = -1, 0, (0, 0)
        for s in order[starts[e] : starts[e + 1]]:
            weight[e] += cotangents[s]
            f, k = s % m, s // m
            ends = faces[f, k], faces[f, (k + 1) % 3]
            if normals[f, 0] == 0 and normals[f, 1] == 0 and normals[f, 2] == 0:
                continue
            if last >= 0:
                turn = _signed_turn(vertices, faces, normals, last, s)
                length = math.sqrt(squared_length(vertices, ends[0], ends[1]))
                mean[ends[0]] += 0.25 * turn * length
                mean[ends[1]] += 0.25 * turn * length
            last = s
            count += 1
        if count == 1:
            on_rim[ends[0]] = on_rim[ends[1]] = True
    return mean, on_rim, weight


@njit(cache=True, error_model="numpy")
def _signed_turn(vertices, faces, normals, one, other):
    """Rad between two faces at their common edge, positive where it is convex.

    Neighbours that run along it the same way have opposite windings.
    """
    m = len(faces)
    f, g = one % m, other % m
    same_way = faces[f, one // m] == faces[g, other // m]
    cosine = opening = 0.0
    for d in range(3):
        cosine += normals[f, d] * normals[g, d]
        between = 0.0
        for k in range(3):
            between += vertices[faces[g, k], d] - vertices[faces[f, k], d]
        opening += (normals[g, d] - normals[f, d]) * between
    turn = math.acos(min(1.0, max(-1.0, -cosine if same_way else cosine)))
    return turn if opening >= 0 else -turn
