"""Fields of point sources: harmonic everywhere else, so exact boundary data for any shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Float = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PointSources:
    """u(x) = Σ q_i / |x − p_i|, with mirror images in the plane z = 0 where `mirrored`.

    Mirrored, the tangential components have no normal derivative on the plane and the normal one
    vanishes there: what a sliding table asks for.

    Attributes:
        points: (n, 3) m, p_i: inside the prop.
        strengths: (n, 3) m², q_i.
    """

    points: Float
    strengths: Float
    mirrored: bool = False

    def displacement(self, x: ArrayLike) -> Float:
        """(..., 3) m."""
        u = self._sum(np.asarray(x, float), self.points)
        if self.mirrored:
            image = self._sum(np.asarray(x, float), self.points * [1.0, 1.0, -1.0])
            u = u + image * [1.0, 1.0, -1.0]
        return u

    def gradient(self, x: ArrayLike) -> Float:
        """∂u/∂x: (..., 3, 3)."""
        du = self._slopes(np.asarray(x, float), self.points)
        if self.mirrored:
            image = self._slopes(np.asarray(x, float), self.points * [1.0, 1.0, -1.0])
            du = du + image * np.array([1.0, 1.0, -1.0])[:, None]
        return du

    def _sum(self, x: Float, points: Float) -> Float:
        distance = np.linalg.norm(x[..., None, :] - points, axis=-1)
        return (1.0 / distance) @ self.strengths

    def _slopes(self, x: Float, points: Float) -> Float:
        offset = x[..., None, :] - points
        distance = np.linalg.norm(offset, axis=-1)
        return np.einsum("...ne,nd->...de", -offset / distance[..., None] ** 3, self.strengths)
