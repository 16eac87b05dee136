"""Distances between surfaces, and which points lie inside a closed one."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.scene.scene import Scene
from touchwarp.scene.surface import Surface
from touchwarp.scene.topology import bodies


def closest_props(scene: Scene, limit: float = math.inf) -> tuple[str, str, float] | None:
    """The two props with the least gap, and that gap in m (0 where they touch or intersect).

    A prop wholly inside another, such as a spoon in a mug, is measured like any other.

    Args:
        scene: the scene; goals play no part.
        limit: m; wider gaps are of no interest and skipped, which is faster.

    Returns:
        (name, name, gap), or None with fewer than two props or no gap up to `limit`.
    """
    pairs = [
        (box_gap(a.surface.bounds, b.surface.bounds), a, b)
        for a, b in itertools.combinations(scene.props, 2)
    ]
    nearest: tuple[str, str, float] | None = None
    for lower_bound, a, b in sorted(pairs, key=lambda pair: pair[0]):
        least = limit if nearest is None else nearest[2]
        if lower_bound > least:
            break
        gap = surface_gap(a.surface, b.surface, least)
        if gap < least or (nearest is None and gap <= limit):
            nearest = (a.name, b.name, gap)
    return nearest


def surface_gap(a: Surface, b: Surface, limit: float = math.inf) -> float:
    """The least distance between two surfaces, m; 0 where they touch or intersect.

    Exact (for triangles by the Flexible Collision Library); infinite where it is found to be more
    than `limit`, m. Only faces that could hold the closest points are compared: a sample of vertex
    distances, or `limit`, bounds the gap from above.
    """
    reach = limit if math.isfinite(limit) else _vertex_gap(a, b)
    faces_a = _faces_near(a, a.faces, b, b.faces, reach)
    faces_b = _faces_near(b, b.faces, a, faces_a, reach)
    faces_a = _faces_near(a, faces_a, b, faces_b, reach)
    if len(faces_a) == 0 or len(faces_b) == 0:
        return math.inf
    if a.dimension == 2:
        return _segment_gap(a.vertices[faces_a], b.vertices[faces_b])
    import fcl

    model_a, model_b = _collision_object(a, faces_a), _collision_object(b, faces_b)
    return max(0.0, float(fcl.distance(model_a, model_b, fcl.DistanceRequest())))


def box_gap(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """The distance between two boxes (2, d) m; 0 where they touch or overlap."""
    return float(np.linalg.norm(np.maximum(0.0, np.maximum(a[0] - b[1], b[0] - a[1]))))


def inside(points: NDArray[np.float64], surface: Surface) -> NDArray[np.bool_]:
    """Which of the points (n, d) m lie inside a closed surface, by their winding number: (n,).

    The surface's faces may be turned in or out, as long as they are all turned alike. Meant for a
    few points: each is compared with every face.
    """
    corners = surface.vertices[surface.faces]
    winding = np.array([_winding(corners - point) for point in points])
    return np.asarray(np.abs(winding) > 0.5)


def body_points(surface: Surface) -> NDArray[np.float64]:
    """One vertex of every connected body of the surface: (bodies, d) m."""
    _, first = np.unique(bodies(surface.faces), return_index=True)
    return np.asarray(surface.vertices[surface.faces[first, 0]])


def _vertex_gap(a: Surface, b: Surface) -> float:
    from scipy.spatial import cKDTree

    few, many = sorted((a.vertices[a.faces[:, 0]], b.vertices[b.faces[:, 0]]), key=len)
    sample = few[:: max(1, len(few) // 2000)]
    return float(cKDTree(many[:: max(1, len(many) // 200_000)]).query(sample)[0].min())


def _faces_near(
    surface: Surface,
    faces: NDArray[np.int64],
    other: Surface,
    other_faces: NDArray[np.int64],
    reach: float,
) -> NDArray[np.int64]:
    """Those of `faces` whose box comes within `reach` of the box around the other's faces."""
    if len(faces) == 0 or len(other_faces) == 0:
        return faces[:0]
    low, high = Surface(other.vertices, other_faces).bounds
    corners = surface.vertices[faces]
    margin = reach + 1e-9
    near = (corners.min(axis=1) <= high + margin) & (corners.max(axis=1) >= low - margin)
    return np.asarray(faces[near.all(axis=1)])


def _collision_object(surface: Surface, faces: NDArray[np.int64]) -> Any:
    import fcl

    used, index = np.unique(faces, return_inverse=True)
    model = fcl.BVHModel()
    model.beginModel(len(used), len(faces))
    model.addSubModel(surface.vertices[used], index.reshape(-1, 3))
    model.endModel()
    return fcl.CollisionObject(model)


def _segment_gap(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """The least distance between segments a (n, 2, 2) and b (m, 2, 2)."""
    least = math.inf
    for start, end in a:
        direction = end - start
        to_b = b - start
        side = direction[0] * to_b[..., 1] - direction[1] * to_b[..., 0]
        along = b[:, 1] - b[:, 0]
        to_a = np.stack([start, end]) - b[:, :1]
        other = along[:, None, 0] * to_a[..., 1] - along[:, None, 1] * to_a[..., 0]
        if ((side.prod(axis=1) < 0) & (other.prod(axis=1) < 0)).any():
            return 0.0
        ends = np.concatenate([b[:, 0], b[:, 1]])
        least = min(least, float(_to_segments(ends, start[None], end[None]).min()))
        for point in (start, end):
            least = min(least, float(_to_segments(point[None], b[:, 0], b[:, 1]).min()))
    return least


def _to_segments(
    points: NDArray[np.float64], start: NDArray[np.float64], end: NDArray[np.float64]
) -> NDArray[np.float64]:
    direction = end - start
    length2 = np.maximum((direction**2).sum(axis=1), np.finfo(float).tiny)
    along = np.clip(((points - start) * direction).sum(axis=1) / length2, 0.0, 1.0)
    return np.asarray(np.linalg.norm(start + along[:, None] * direction - points, axis=1))


def _winding(corners: NDArray[np.float64]) -> float:
    """How often faces (m, d, d), seen from the origin, wind around it."""
    if corners.shape[1] == 2:
        a, b = corners[:, 0], corners[:, 1]
        turn = np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1))
        return float(turn.sum() / (2 * np.pi))
    # The solid angle of a triangle: van Oosterom and Strackee 1983.
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    triple = (a * np.cross(b, c)).sum(axis=1)
    ab, bc, ca = (a * b).sum(axis=1), (b * c).sum(axis=1), (c * a).sum(axis=1)
    angle = 2 * np.arctan2(triple, la * lb * lc + ab * lc + bc * la + ca * lb)
    return float(angle.sum() / (4 * np.pi))
