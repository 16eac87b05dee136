"""How thick a scanned wall is."""

from __future__ import annotations

import numpy as np

from touchwarp.scan.deviation import diagonal, face_normals, sample
from touchwarp.scene.surface import Surface

RAYS = 2_000


def wall_thickness(surface: Surface, share: float = 0.05, seed: int = 0) -> float:
    """m: the thickness that this share of the area falls below; infinite where no ray comes out.

    At points uniform in area a ray goes inward along the normal to where it leaves the surface, by
    a face that is turned away from it.
    """
    import igl

    random = np.random.default_rng(seed)
    points, face = sample(surface, RAYS, random)
    normals = face_normals(surface)
    start = 1e-6 * diagonal(surface)
    tree = igl.AABB()
    tree.init(surface.vertices, surface.faces)
    hit, length, _ = tree.intersect_ray_first(
        surface.vertices, surface.faces, points - start * normals[face], -normals[face]
    )
    hit = np.asarray(hit)
    leaves = (hit >= 0) & ((normals[hit] * normals[face]).sum(axis=1) < -0.5)
    if leaves.sum() < share * RAYS:
        return float("inf")
    return float(np.quantile(np.asarray(length)[leaves], share))
