"""How far one surface lies from another, over samples uniform in area."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.scene.surface import Surface

Float = NDArray[np.float64]

SAMPLES = 20_000


@dataclass(frozen=True)
class Deviation:
    """Distances, mm, from the points of one surface to another.

    Attributes:
        mean_mm, p95_mm, p99_mm, max_mm: over all samples; vertices count for the greatest only.
    """

    mean_mm: float
    p95_mm: float
    p99_mm: float
    max_mm: float

    def __str__(self) -> str:
        mean, p95, p99, greatest = (
            f"{v:.3g}" if v >= 1e-4 else "<0.0001"
            for v in (self.mean_mm, self.p95_mm, self.p99_mm, self.max_mm)
        )
        return f"mean {mean}, p95 {p95}, p99 {p99}, max {greatest} mm"


def deviation(of: Surface, to: Surface, samples: int = SAMPLES, seed: int = 0) -> Deviation:
    """The distances from surface `of` to surface `to`; one way only."""
    at = sample(of, samples, np.random.default_rng(seed))[0]
    over_area = distances(at, to)
    greatest = max(over_area.max(), distances(of.used_vertices, to).max())
    p95, p99 = np.quantile(over_area, [0.95, 0.99])
    mean = float(over_area.mean())
    return Deviation(mean * 1e3, float(p95) * 1e3, float(p99) * 1e3, float(greatest) * 1e3)


def distances(points: Float, surface: Surface) -> Float:
    """(n,) m: distance of each point (n, 3) m to the surface."""
    import igl

    squared, _, _ = igl.point_mesh_squared_distance(points, surface.vertices, surface.faces)
    return np.asarray(np.sqrt(squared))


def sample(
    surface: Surface, count: int, random: np.random.Generator
) -> tuple[Float, NDArray[np.int64]]:
    """Points (count, 3) m uniform in area, and the face (count,) each lies on."""
    area = face_areas(surface)
    cumulated = np.cumsum(area)
    # one draw in each of `count` equal strips of area: less noise than independent draws
    strips = (np.arange(count) + random.random(count)) / count
    face = np.searchsorted(cumulated, strips * cumulated[-1], side="right")
    face = np.minimum(face, len(area) - 1)
    first, second = random.random((2, count))
    beyond = first + second > 1
    first[beyond], second[beyond] = 1 - first[beyond], 1 - second[beyond]
    a, b, c = surface.vertices[surface.faces[face]].transpose(1, 0, 2)
    return a + first[:, None] * (b - a) + second[:, None] * (c - a), face


def face_areas(surface: Surface) -> Float:
    """(m,) m²."""
    return np.asarray(np.linalg.norm(area_vectors(surface), axis=1))


def area_vectors(surface: Surface) -> Float:
    """(m, 3) m²: each face's normal, as long as its area."""
    a, b, c = surface.vertices[surface.faces].transpose(1, 0, 2)
    return np.asarray(0.5 * np.cross(b - a, c - a))


def face_normals(surface: Surface) -> Float:
    """(m, 3) unit normals by winding; 0 for a face with no area."""
    vectors = area_vectors(surface)
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.maximum(length, 1e-300))


def diagonal(surface: Surface) -> float:
    """m: of the bounding box."""
    low, high = surface.bounds
    return float(np.linalg.norm(high - low))
