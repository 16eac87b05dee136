"""Concentric spheres: the exact warp for any affine goal and any screening.

On the inner sphere |x − c| = a the displacement is d + B (x − c), on the outer one |x − c| = R it
is 0, between them Δu = λu. The constant part is a harmonic of degree 0, the linear part of degree
1, so u = φ0(r) d + φ1(r) B (x − c) with, s = √λ and t = R − r,

    φ0(r) = (a / r) sinh(s t) / sinh(s (R − a)),
    φ1(r) ∝ [(s² r R − 1) sinh(s t) + s t cosh(s t)] / r³,    φ1(a) = 1,

(the products of spherical Bessel functions i1, k1 that vanish at R) and, as s → 0,

    φ0(r) = (1/r − 1/R) / (1/a − 1/R),    φ1(r) = (1/r³ − 1/R³) / (1/a³ − 1/R³).

Inside the inner sphere the goal itself goes on, outside the outer one u = 0.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from touchwarp.warp.inverse import find_inverse
from touchwarp.warp.posed import PosedWarp
from touchwarp.warp.protocol import Inverse

Float = NDArray[np.float64]


def radial(r: Float, a: float, R: float, screening: float) -> tuple[Float, Float, Float, Float]:
    """φ0, φ0', φ1, φ1' at radii r in [a, R]; see the module."""
    if screening == 0.0:
        zeroth = 1.0 / a - 1.0 / R
        first = a**-3 - R**-3
        return (
            (1.0 / r - 1.0 / R) / zeroth,
            -(r**-2) / zeroth,
            (r**-3 - R**-3) / first,
            -3.0 * r**-4 / first,
        )
    s = np.sqrt(screening)

    def first_form(q: Float) -> tuple[Float, Float]:
        t = R - q
        sinh, cosh = np.sinh(s * t), np.cosh(s * t)
        top = (s * s * q * R - 1.0) * sinh + s * t * cosh
        slope = s * s * R * sinh - (s * s * q * R - 1.0) * s * cosh - s * cosh - s * s * t * sinh
        return top / q**3, slope / q**3 - 3.0 * top / q**4

    sinh_a = np.sinh(s * (R - a))
    sinh, cosh = np.sinh(s * (R - r)), np.cosh(s * (R - r))
    zeroth = a / r * sinh / sinh_a
    zeroth_slope = -a / r * (s * cosh + sinh / r) / sinh_a
    at_a = first_form(np.array(a))[0]
    first_value, first_slope = first_form(r)
    return zeroth, zeroth_slope, first_value / at_a, first_slope / at_a


@dataclass(frozen=True, eq=False)
class SphereWarp:
    """The exact warp around one sphere in a larger one.

    Attributes:
        radius, outer_radius: a and R, m.
        centre: (3,) m.
        shift: (3,) m, d.
        stretch: (3, 3), B; 2x as big is the identity.
        screening: λ, m⁻².
    """

    radius: float = 0.05
    outer_radius: float = 0.2
    centre: Float = field(default_factory=lambda: np.zeros(3))
    shift: Float = field(default_factory=lambda: np.zeros(3))
    stretch: Float = field(default_factory=lambda: np.zeros((3, 3)))
    screening: float = 0.0

    dimension = 3

    @property
    def max_displacement(self) -> float:
        """A bound on |u|, m."""
        return float(np.linalg.norm(self.shift) + np.linalg.norm(self.stretch, ord=2) * self.radius)

    def __call__(self, x: ArrayLike) -> Float:
        return np.asarray(x, float) + self.displacement(x)

    def displacement(self, x: ArrayLike) -> Float:
        offset, r, _ = self._polar(x)
        between = np.clip(r, self.radius, self.outer_radius)
        zeroth, _, first, _ = radial(between, self.radius, self.outer_radius, self.screening)
        linear = offset @ self.stretch.T
        u = zeroth[..., None] * self.shift + first[..., None] * linear
        return np.where((r > self.outer_radius)[..., None], 0.0 * offset, u)

    def jacobian(self, x: ArrayLike) -> Float:
        offset, r, outward = self._polar(x)
        between = np.clip(r, self.radius, self.outer_radius)
        _, zeroth, first, first_slope = radial(
            between, self.radius, self.outer_radius, self.screening
        )
        linear = offset @ self.stretch.T
        along = zeroth[..., None] * self.shift + first_slope[..., None] * linear
        along = np.where((r > self.radius)[..., None], along, 0.0)
        du = along[..., :, None] * outward[..., None, :] + first[..., None, None] * self.stretch
        du = np.where((r > self.outer_radius)[..., None, None], 0.0 * offset[..., None], du)
        return np.eye(3) + du

    def inverse(self, x: ArrayLike) -> Inverse:
        return find_inverse(self, x)

    def at(self, T_room_scene: ArrayLike) -> PosedWarp:
        return PosedWarp(self, T_room_scene)

    def _polar(self, x: ArrayLike) -> tuple[Float, Float, Float]:
        points = np.asarray(x, float)
        if points.ndim == 0 or points.shape[-1] != 3:
            raise ValueError(f"Points have shape {points.shape}; (..., 3) is needed.")
        # a row with one NaN is NaN throughout
        offset = points - self.centre + 0.0 * points.sum(axis=-1, keepdims=True)
        r = np.linalg.norm(offset, axis=-1)
        return offset, r, offset / np.maximum(r, 1e-300)[..., None]
