"""The warp of a segment: the one-dimensional problem of eq. 9.

On a < x < b the displacement obeys u'' = λ u with u(a) and u(b) given. The closed form is exact;
the finite-difference solve has cut ends, as the plane and space solvers have cut edges, and is the
smallest place in which to see them at work.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import solve_banded

from touchwarp.errors import SolveError


@dataclass(frozen=True)
class Segment:
    """A segment with Dirichlet data at both ends.

    Attributes:
        start, stop: the ends a < b, m.
        displacement_start, displacement_stop: u(a) and u(b), m.
        screening: λ ≥ 0 of u'' = λ u, m⁻².
    """

    start: float
    stop: float
    displacement_start: float
    displacement_stop: float = 0.0
    screening: float = 0.0

    def __post_init__(self) -> None:
        values = (self.start, self.stop, self.displacement_start, self.displacement_stop)
        if not np.isfinite(values).all():
            raise SolveError(
                f"A segment's ends and their displacements are {values}; finite numbers are needed."
            )
        if not self.start < self.stop:
            raise SolveError(
                f"A segment runs from {self.start} to {self.stop}; "
                "its start must lie below its stop: exchange the ends."
            )
        if not (np.isfinite(self.screening) and self.screening >= 0):
            raise SolveError(f"λ is {self.screening} m⁻²; a finite number ≥ 0 is needed.")

    def displacement(self, x: ArrayLike) -> NDArray[np.float64]:
        """u at x (...) m, in closed form (eq. 9); NaN outside the segment."""
        x = np.asarray(x, dtype=np.float64)
        inside = (x >= self.start) & (x <= self.stop)
        from_start = self._decay(np.where(inside, x - self.start, 0.0))
        from_stop = self._decay(np.where(inside, self.stop - x, 0.0))
        u = self.displacement_start * from_start + self.displacement_stop * from_stop
        return np.asarray(np.where(inside, u, np.nan))

    def _decay(self, distance: NDArray[np.float64]) -> NDArray[np.float64]:
        """sinh(s(L − d)) / sinh(sL), s = √λ, written so that it does not overflow for large sL."""
        length = self.stop - self.start
        s = np.sqrt(self.screening)
        if s * length < 1e-6:  # the quotient below is 0 / 0 at λ = 0
            return np.asarray(1.0 - distance / length)
        return np.asarray(
            np.exp(-s * distance)
            * np.expm1(-2 * s * (length - distance))
            / np.expm1(-2 * s * length)
        )


def solve_segment(
    segment: Segment, spacing: float, origin: float = 0.0
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """u'' = λ u by Shortley–Weller differences on the nodes origin + i·spacing inside a segment.

    The ends need not be nodes: the first and last intervals are cut where the segment ends.

    Args:
        segment: the problem.
        spacing: m, between nodes.
        origin: m, any point of the lattice of nodes.
    Returns:
        nodes (n,) m, strictly inside the segment, and u there (n,) m.
    Raises:
        SolveError: the spacing is no positive number, or no node lies in the segment.
    """
    if not (np.isfinite(spacing) and spacing > 0):
        raise SolveError(f"The spacing is {spacing} m; a finite number > 0 is needed.")
    first = np.floor((segment.start - origin) / spacing) + 1
    last = np.ceil((segment.stop - origin) / spacing) - 1
    nodes = origin + spacing * np.arange(first, last + 1)
    nodes = nodes[(nodes > segment.start) & (nodes < segment.stop)]
    if len(nodes) == 0:
        raise SolveError(
            f"No node of spacing {spacing} m lies between {segment.start} and "
            f"{segment.stop} m; choose a smaller spacing."
        )
    below = np.full(len(nodes), spacing)
    above = np.full(len(nodes), spacing)
    below[0] = nodes[0] - segment.start
    above[-1] = segment.stop - nodes[-1]
    weight_below = 2.0 / (below * (below + above))
    weight_above = 2.0 / (above * (below + above))
    bands = np.zeros((3, len(nodes)))
    bands[0, 1:] = -weight_above[:-1]
    bands[1] = weight_below + weight_above + segment.screening
    bands[2, :-1] = -weight_below[1:]
    known = np.zeros(len(nodes))
    known[0] += weight_below[0] * segment.displacement_start
    known[-1] += weight_above[-1] * segment.displacement_stop
    return nodes, solve_banded((1, 1), bands, known)
