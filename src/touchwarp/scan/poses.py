"""Rotations to try before any registration, and what an alignment is measured by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.scan.deviation import face_areas, sample
from touchwarp.scene.surface import Surface

Float = NDArray[np.float64]

_GOLDEN = 1.533751168755204288118041  # positive root of x⁴ = x + 4
_ROOT_TWO = 2.0**0.5


@dataclass(frozen=True, eq=False)
class Cloud:
    """Samples of a surface, uniform in area, about its area's centroid.

    Attributes:
        centroid: (3,) m.
        points: (n, 3) m, relative to it.
        axes: (3, 3) columns: principal axes, a right-handed frame, longest spread first.
        radius: m, root mean square distance from the centroid.
    """

    centroid: Float
    points: Float
    axes: Float
    radius: float

    @staticmethod
    def of(surface: Surface, count: int, seed: int) -> Cloud:
        """Samples of `surface`."""
        centres = surface.vertices[surface.faces].mean(axis=1)
        area = face_areas(surface)
        centroid = np.asarray(area @ centres / area.sum())
        points = sample(surface, count, np.random.default_rng(seed))[0] - centroid
        corners = surface.vertices[surface.faces] - centroid
        # ∫ x xᵀ over a triangle with corners vᵢ: area/12 · (Σ vᵢ vᵢᵀ + (Σ vᵢ)(Σ vᵢ)ᵀ)
        spread = np.einsum("f,fci,fcj->ij", area, corners, corners)
        total = corners.sum(axis=1)
        spread += np.einsum("f,fi,fj->ij", area, total, total)
        axes = np.linalg.eigh(spread)[1][:, ::-1]
        axes[:, 2] *= np.linalg.det(axes)
        return Cloud(centroid, points, axes, float(np.sqrt((points**2).sum(axis=1).mean())))


def even_rotations(count: int) -> Float:
    """(count, 3, 3): rotations spread evenly over all there are (Alexa 2022, super-Fibonacci)."""
    i = np.arange(count) + 0.5
    inner, outer = np.sqrt(i / count), np.sqrt(1 - i / count)
    alpha, beta = 2 * np.pi * i / _ROOT_TWO, 2 * np.pi * i / _GOLDEN
    return _matrices(
        np.stack(
            [
                inner * np.sin(alpha),
                inner * np.cos(alpha),
                outer * np.sin(beta),
                outer * np.cos(beta),
            ],
            axis=1,
        )
    )


def turns(axis: Float, count: int) -> Float:
    """(count, 3, 3): even rotations about one axis (3,), the identity first."""
    from scipy.spatial.transform import Rotation

    angles = 2 * np.pi * np.arange(count) / count
    return np.asarray(Rotation.from_rotvec(angles[:, None] * axis).as_matrix())


def frame_matches(to: Float, of: Float) -> Float:
    """(24, 3, 3): the rotations that bring the axes `of` onto the axes `to`, in any order."""
    return np.asarray(np.einsum("ij,njk,lk->nil", to, _cube_rotations(), of))


def _cube_rotations() -> Float:
    import itertools

    every = [
        np.diag(signs)[list(order)]
        for order in itertools.permutations(range(3))
        for signs in itertools.product((1.0, -1.0), repeat=3)
    ]
    return np.array([m for m in every if np.linalg.det(m) > 0])


def _matrices(quaternions: Float) -> Float:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_quat(quaternions).as_matrix())
