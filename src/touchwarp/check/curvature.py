"""Curvature as a fingertip feels it, on the prop and on its image, and the angles of edges.

On a mesh curvature sits on the edges: an edge that turns by θ over a length ℓ carries a mean
curvature of θℓ/2 (Cohen-Steiner & Morvan 2003). Summed over a patch of a fingertip's size and
divided by its area this stays finite at sharp edges and averages the noise of scans.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from touchwarp.check.case import PropCase
from touchwarp.goals.surface_samples import face_areas, face_normals, find_sharp_edges

Float = NDArray[np.float64]

PATCH_RADIUS = 8e-3
"""m: a fingertip's."""

PATCHES = 1200
AREA_SAMPLES = 60_000
EDGE_PIECES = 200_000
MOST_IN_PATCH = 2000
"""Samples and pieces of edges in a patch, about; on props smaller than a finger they are fewer."""

FLAT = 0.04
"""Mean curvature × patch radius below which a patch counts as flat and has no relative change."""


def patch_curvatures(prop: PropCase, rng: np.random.Generator) -> tuple[Float, Float, Float, float]:
    """Mean curvatures of patches that are not flat on the prop.

    Returns:
        Patch centres (n, 3) m, mean curvature of the prop (n,) m⁻¹ and of the virtual object (n,)
        m⁻¹, convex positive, and the share of patches that are flat.
    """
    goal = prop.goal
    edges = find_sharp_edges(goal.prop_points, goal.faces, turn_deg=0.0)
    inner = np.flatnonzero(~edges.rim)
    if len(inner) == 0:
        return np.empty((0, 3)), np.zeros(0), np.zeros(0), 1.0
    ends, faces = edges.ends[inner], edges.faces[inner]
    felt_turn = _signed_turn(prop, goal.prop_points, faces, prop.body.outward)
    seen_turn = _signed_turn(prop, goal.virtual_points, faces, prop.virtual.outward)
    felt_length = edges.length[inner]
    seen_length = np.linalg.norm(
        goal.virtual_points[ends[:, 0]] - goal.virtual_points[ends[:, 1]], axis=1
    )
    normal = face_normals(goal.prop_points, goal.faces)
    patches_on_prop = prop.area / (np.pi * PATCH_RADIUS**2)
    most = int(max(1.0, patches_on_prop) * MOST_IN_PATCH)
    edge, middle, share = _pieces(goal.prop_points, ends, felt_length, min(EDGE_PIECES, most), rng)
    step = max(1, len(prop.samples.points) // min(AREA_SAMPLES, most))
    points, face = prop.samples.points[::step], prop.samples.face[::step]
    areas = face_areas(goal.prop_points, goal.faces)
    stretch = face_areas(goal.virtual_points, goal.faces) / np.maximum(areas, 1e-300)
    centre = rng.choice(len(points), min(PATCHES, len(points)), replace=False)
    around_points = cKDTree(points).query_ball_point(points[centre], PATCH_RADIUS)
    around_pieces = cKDTree(middle).query_ball_point(points[centre], PATCH_RADIUS)
    each = prop.area / len(points)
    felt, seen = np.zeros(len(centre)), np.zeros(len(centre))
    for n, c in enumerate(centre):
        own = normal[face[c]]
        # the other side of a thin wall is within reach of the ball, but not of the finger
        p = np.asarray(around_points[n], dtype=np.int64)
        p = p[normal[face[p]] @ own > -0.2]
        q = np.asarray(around_pieces[n], dtype=np.int64)
        q = q[normal[faces[edge[q], 0]] @ own > -0.2]
        e = edge[q]
        felt[n] = 0.5 * (felt_turn[e] * felt_length[e]) @ share[q] / (each * len(p))
        seen[n] = 0.5 * (seen_turn[e] * seen_length[e]) @ share[q] / (each * stretch[face[p]].sum())
    curved = np.abs(felt) * PATCH_RADIUS >= FLAT
    return points[centre][curved], felt[curved], seen[curved], float(1.0 - curved.mean())


def edge_angles(prop: PropCase) -> tuple[Float, Float, Float]:
    """Angles of the prop's sharp edges, felt and seen (e,) rad, and their middles (e, d) m.

    The angle is that of the solid wedge for a convex edge, of the open wedge for a concave one.
    """
    inner = np.flatnonzero(~prop.edges.rim)
    goal, edges = prop.goal, prop.edges
    faces = edges.faces[inner]
    felt = np.pi - np.abs(_signed_turn(prop, goal.prop_points, faces, 1.0))
    seen = np.pi - np.abs(_signed_turn(prop, goal.virtual_points, faces, 1.0))
    kept = felt > np.radians(5.0)
    middle = goal.prop_points[edges.ends[inner]].mean(axis=1)
    return felt[kept], seen[kept], middle[kept]


def _signed_turn(
    prop: PropCase, vertices: Float, faces: NDArray[np.int64], outward: float
) -> Float:
    """(e,) rad between the normals of pairs of faces, positive where convex."""
    normal = outward * face_normals(vertices, prop.goal.faces)
    one, two = normal[faces[:, 0]], normal[faces[:, 1]]
    turn = np.arccos(np.clip(np.einsum("ij,ij->i", one, two), -1.0, 1.0))
    middle = vertices[prop.goal.faces].mean(axis=1)
    apart = middle[faces[:, 1]] - middle[faces[:, 0]]
    convex = np.einsum("ij,ij->i", two - one, apart) >= 0
    signed: Float = np.where(convex, turn, -turn)
    return signed


def _pieces(
    vertices: Float,
    ends: NDArray[np.int64],
    length: Float,
    most: int,
    rng: np.random.Generator,
) -> tuple[NDArray[np.int64], Float, Float]:
    """Short pieces of edges: their edge, middle (p, 3) m, and share of its curvature."""
    count = np.maximum(1, np.ceil(length / (0.25 * PATCH_RADIUS)).astype(np.int64))
    edge = np.repeat(np.arange(len(ends)), count)
    first = np.repeat(np.cumsum(count) - count, count)
    t = (np.arange(len(edge)) - first + 0.5) / count[edge]
    share = 1.0 / count[edge]
    if len(edge) > most:
        kept = np.sort(rng.choice(len(edge), most, replace=False))
        share = share[kept] * (len(edge) / most)
        edge, t = edge[kept], t[kept]
    a, b = vertices[ends[edge, 0]], vertices[ends[edge, 1]]
    return edge, a + t[:, None] * (b - a), share
