"""What is minimised, and how exactly (eq. 5 with α = β = 2)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from touchwarp.errors import SceneError


@dataclass(frozen=True)
class Objective:
    """Minimise λ/L² ∫Ω |u|² + ∫Ω |∇u|², that is Δu = (λ/L²) u, to a tolerance.

    Attributes:
        mismatch_weight: λ ≥ 0, dimensionless.
        length_scale: L > 0, m. Fixed rather than taken from the props, so that adding a prop does
            not change λ's meaning.
        tolerance_mm: bound on the table's error at every point of Ω farther than `edge_radius_mm`
            from a sharp edge, corner, open rim or wall thinner than two cells, mm.
        edge_radius_mm: radius of the tube around those, where the exact warp is singular, mm.
    """

    mismatch_weight: float = 0.0
    length_scale: float = 0.1
    tolerance_mm: float = 0.1
    edge_radius_mm: float = 2.0

    def __post_init__(self) -> None:
        self._require("mismatch_weight", least=0.0, text="a finite number ≥ 0 (this is λ)")
        self._require("length_scale", above=0.0, text="a finite length in m > 0")
        self._require("tolerance_mm", above=0.0, text="a finite length in mm > 0, such as 0.1,")
        self._require("edge_radius_mm", least=0.0, text="a finite length in mm ≥ 0")

    @property
    def screening(self) -> float:
        """λ/L², 1/m²: the factor in Δu = (λ/L²) u."""
        return self.mismatch_weight / self.length_scale**2

    def _require(
        self, key: str, text: str, least: float = -math.inf, above: float = -math.inf
    ) -> None:
        value = getattr(self, key)
        number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not number or not math.isfinite(value) or value < least or value <= above:
            raise SceneError(f"objective.{key} is {value!r}; {text} is needed.")
