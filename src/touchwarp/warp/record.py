"""What a warp remembers of how it was solved."""

from __future__ import annotations

from dataclasses import dataclass

from touchwarp.solve.solution import Solution
from touchwarp.warp.table_error import TableError


@dataclass(frozen=True)
class SolveRecord:
    """How a table was solved.

    Attributes:
        nodes: of all levels, the coarse ones of multigrid included.
        spacing: m, of the finest cells.
        residual_history: m (rows scaled by h²), on the finest level after each final cycle.
        change_history: m, greatest change of u in each final cycle.
        estimated_error_max_mm: estimated greatest error of the table in Ω, farther than the edge
            radius from sharp edges, open rims and thin walls.
        estimated_error_rms_mm: the same, root mean square over the nodes.
        estimated_edge_error_mm: estimated greatest error within the edge radius.
        contact_p99_mm, contact_max_mm: |table − g| on the props, by area.
        capped: cells near edges were kept larger than the field there would ask for.
        contradiction_mm: greatest displacement that goals ask for where a prop meets a fixed
            surface that forbids it; `blend_mm` is where they give way.
    """

    nodes: int
    spacing: float
    residual_history: tuple[float, ...]
    change_history: tuple[float, ...]
    estimated_error_max_mm: float
    estimated_error_rms_mm: float
    estimated_edge_error_mm: float
    contact_p99_mm: float
    contact_max_mm: float
    capped: bool
    contradiction_mm: float

    @classmethod
    def of(cls, solution: Solution, error: TableError) -> SolveRecord:
        """The record of a solution and of the table made from it."""
        return cls(
            solution.nodes,
            solution.spacing,
            solution.residual_history,
            solution.change_history,
            error.outside_tube_max * 1e3,
            error.outside_tube_rms * 1e3,
            error.inside_tube_max * 1e3,
            error.contact_p99 * 1e3,
            error.contact_max * 1e3,
            solution.capped,
            solution.contradiction * 1e3,
        )
