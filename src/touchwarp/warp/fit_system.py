"""The contact fit's normal equations: a sparse matrix and conjugate gradients on four lanes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.sparse import csr_array

from touchwarp.errors import SolveError
from touchwarp.solve.stencil import LANES, hold_floor
from touchwarp.solve.threads import share

REDUCTION = 1e-6
"""Of the preconditioned residual. Misfits before the fit are below 1 mm: what is left is
nanometres, so that fits of sums are sums of fits."""

MOST_STEPS = 3000

MASTERS = 4
"""The most nodes of the coarser level that a hanging node is the mean of."""

Real = NDArray[np.float64]


RINGS = 6
"""Nodes behind surfaces are fitted again, with those of Ω, where so many cells lead to one at most.
What the second fit would change farther off falls to less than a third with every cell."""


@dataclass(eq=False)
class Rows:
    """A symmetric matrix by rows.

    Attributes:
        start: (n + 1,) first entry of each row.
        column, value: the entries.
        inverse_diagonal: (n,), 0 for empty rows.
        floor: (k,) int32, rows on the sliding plane.
    """

    start: NDArray[np.int64]
    column: NDArray[np.int32]
    value: NDArray[np.float32]
    inverse_diagonal: Real
    floor: NDArray[np.int32]

    def part(self, chosen: NDArray[np.int64]) -> Rows:
        """The rows and columns that are chosen (k,)."""
        count = len(self.inverse_diagonal)
        whole = csr_array((self.value, self.column, self.start), shape=(count, count))
        own = whole[chosen][:, chosen]
        floor = np.flatnonzero(np.isin(chosen, self.floor)).astype(np.int32)
        start, column = own.indptr.astype(np.int64), own.indices.astype(np.int32)
        return Rows(start, column, own.data, self.inverse_diagonal[chosen], floor)

    def within(self, steps: int, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """(n,) rows that so many entries, one after another, lead to from the chosen ones."""
        count = len(self.inverse_diagonal)
        whole = csr_array((self.value != 0.0, self.column, self.start), shape=(count, count))
        for _ in range(steps):
            chosen = whole @ chosen
        return chosen

    def conjugate_gradients(
        self, x: Real, r: Real, inverse: Real, normal_lanes: NDArray[np.bool_]
    ) -> None:
        """Add to x, where `inverse` is not 0, what the right-hand side r asks for.

        r becomes what is left of it.

        Raises:
            SolveError: no convergence.
        """
        p, q = np.zeros_like(r), np.zeros_like(r)
        alpha = beta = np.zeros(LANES)
        rz = self._shared(_advance, alpha, p, q, inverse, x, r)
        goal = REDUCTION**2 * rz
        for _ in range(MOST_STEPS):
            if (rz <= goal).all():
                return
            share(_turn, len(inverse), beta, inverse, r, p, even=True)
            pq = self._shared(_multiply, self.start, self.column, self.value, p, q)
            hold_floor(q, self.floor, normal_lanes)
            alpha = np.divide(rz, pq, out=np.zeros(LANES), where=pq > 0.0)
            new = self._shared(_advance, alpha, p, q, inverse, x, r)
            beta = np.divide(new, rz, out=np.zeros(LANES), where=rz > 0.0)
            rz = new
        left = float(np.sqrt((rz / np.maximum(goal, 1e-300)).max())) * REDUCTION
        raise SolveError(
            f"The contact fit did not converge in {MOST_STEPS} steps: {left:.1e} of the residual "
            f"is left, {REDUCTION} was needed. Look for degenerate faces with `touchwarp info`."
        )

    def _shared(self, kernel: Callable[..., Any], *arguments: Any) -> Real:
        """The sum of what a loop over all rows returns for its parts."""
        count = len(self.inverse_diagonal)
        return np.asarray(np.sum(share(kernel, count, *arguments, work=4, even=True), axis=0))


@dataclass(eq=False)
class FitSystem:
    """(Σ w N Nᵀ + κ) x = rhs, the hanging unknowns eliminated.

    Attributes:
        rows: of all unknowns; those of hanging ones are empty.
        behind: (n,) bool, behind a surface.
        again: (k,) unknowns in Ω, and those near them that are fitted again; again_rows: theirs.
        hanging: (h,); master: (h, 4), -1 where unused; part: (h,) 1, ½ or ¼.
    """

    rows: Rows
    behind: NDArray[np.bool_]
    again: NDArray[np.int64]
    again_rows: Rows
    hanging: NDArray[np.int32]
    master: NDArray[np.int32]
    part: Real

    @property
    def count(self) -> int:
        """Unknowns, hanging ones included."""
        return len(self.behind)

    def solve(self, rhs: Real, normal_lanes: NDArray[np.bool_]) -> Real:
        """x (count, 4) for a right-hand side that is still to be folded on to masters.

        First the nodes behind surfaces alone, then those of Ω and what is near them, for what is
        left. `rhs` is changed.

        Raises:
            SolveError: no convergence.
        """
        _fold(self.hanging, self.master, self.part, rhs)
        hold_floor(rhs, self.rows.floor, normal_lanes)
        x = np.zeros_like(rhs)
        behind = np.where(self.behind, self.rows.inverse_diagonal, 0.0)
        self.rows.conjugate_gradients(x, rhs, behind, normal_lanes)
        left, change = rhs[self.again], np.zeros((len(self.again), LANES))
        rows = self.again_rows
        rows.conjugate_gradients(change, left, rows.inverse_diagonal, normal_lanes)
        x[self.again] += change
        _spread(self.hanging, self.master, self.part, x)
        return x


def make_system(
    count: int,
    cells: NDArray[np.int32],
    gram: NDArray[np.float32],
    tie: Real,
    behind: NDArray[np.bool_],
    floor: NDArray[np.int32],
    hanging: NDArray[np.int32],
    master: NDArray[np.int32],
    part: Real,
) -> FitSystem:
    """Assemble the matrix from cells (c, 8) of unknowns and their Gram matrices (c, 8, 8)."""
    link = np.full(count, -1, np.int32)
    link[hanging] = np.arange(len(hanging))
    expansion = cells, link, master, part
    at = np.zeros(count + 1, np.int64)
    _find_corners(*expansion, at, np.empty(0, np.int32), np.empty(0, np.float32))
    np.cumsum(at, out=at)
    corner = np.empty(int(at[-1]), np.int32)
    weight = np.empty(int(at[-1]), np.float32)
    _find_corners(*expansion, at[:-1].copy(), corner, weight)
    given = *expansion, at, corner, weight, gram, np.where(link < 0, tie, 0.0)
    start = np.zeros(count + 1, np.int64)
    none = np.empty(0, np.int32), np.empty(0, np.float32)
    diagonal = np.zeros(count)
    share(_assemble, count, *given, start, *none, diagonal, work=64, even=True)
    np.cumsum(start, out=start)
    column = np.empty(int(start[-1]), np.int32)
    value = np.zeros(int(start[-1]), np.float32)
    share(_assemble, count, *given, start, column, value, diagonal, work=64, even=True)
    inverse = np.divide(1.0, diagonal, out=np.zeros(count), where=diagonal > 0.0)
    rows = Rows(start, column, value, inverse, floor)
    again = np.flatnonzero(rows.within(RINGS, ~behind & (inverse > 0.0)) & (inverse > 0.0))
    return FitSystem(rows, behind, again, rows.part(again), hanging, master, part)


@njit(cache=True, nogil=True)
def _expand(unknown, link, master, part, out):
    """The masters of an unknown; itself, unless it hangs. Returns how many, and their weight."""
    if unknown < 0:
        return 0, 0.0
    h = link[unknown]
    if h < 0:
        out[0] = unknown
        return 1, 1.0
    n = 0
    for k in range(MASTERS):
        if master[h, k] >= 0:
            out[n] = master[h, k]
            n += 1
    return n, part[h]


@njit(cache=True, nogil=True)
def _find_corners(cells, link, master, part, at, corner, weight):
    """Which corners, 8 · cell + i, each unknown has a part in, and how much; or count them."""
    counting = len(corner) == 0
    out = np.empty(MASTERS, np.int32)
    for c in range(cells.size):
        n, w = _expand(cells[c >> 3, c & 7], link, master, part, out)
        for k in range(n):
            if counting:
                at[out[k] + 1] += 1
            else:
                e = at[out[k]]
                at[out[k]] += 1
                corner[e], weight[e] = c, w


@njit(cache=True, nogil=True)
def _assemble(
    first,
    last,
    cells,
    link,
    master,
    part,
    at,
    corner,
    weight,
    gram,
    tie,
    start,
    column,
    value,
    diagonal,
):
    """The entries of rows first..last, or their number where there is no room for them."""
    counting = len(column) == 0
    entry = np.full(len(link), -1, np.int64)
    out = np.empty(MASTERS, np.int32)
    end = 0 if counting else start[first]
    for m in range(first, last):
        begun = end
        if tie[m] > 0.0:
            entry[m] = end
            if not counting:
                column[end], value[end] = m, tie[m]
            end += 1
        for a in range(at[m], at[m + 1]):
            c, i = corner[a] >> 3, corner[a] & 7
            for j in range(8):
                n, w = _expand(cells[c, j], link, master, part, out)
                for k in range(n):
                    if entry[out[k]] < begun:
                        entry[out[k]] = end
                        if not counting:
                            column[end] = out[k]
                        end += 1
                    if not counting:
                        value[entry[out[k]]] += weight[a] * w * gram[c, i, j]
        if counting:
            start[m + 1] = end - begun
        elif entry[m] >= begun:
            diagonal[m] = value[entry[m]]


@njit(cache=True, nogil=True, fastmath=True)
def _multiply(first, last, start, column, value, x, y):
    """y = A x; returns x · y for each lane."""
    total = np.zeros(LANES)
    for m in range(first, last):
        s0 = s1 = s2 = s3 = 0.0
        for e in range(start[m], start[m + 1]):
            c, v = column[e], value[e]
            s0 += v * x[c, 0]
            s1 += v * x[c, 1]
            s2 += v * x[c, 2]
            s3 += v * x[c, 3]
        y[m, 0], y[m, 1], y[m, 2], y[m, 3] = s0, s1, s2, s3
        for k in range(LANES):
            total[k] += y[m, k] * x[m, k]
    return total


@njit(cache=True, nogil=True, fastmath=True)
def _advance(first, last, alpha, p, q, inverse, x, r):
    """One step along p; returns r · z for each lane, z the scaled residual."""
    total = np.zeros(LANES)
    for m in range(first, last):
        for k in range(LANES):
            x[m, k] += alpha[k] * p[m, k]
            left = r[m, k] - alpha[k] * q[m, k]
            r[m, k] = left
            total[k] += inverse[m] * left * left
    return total


@njit(cache=True, nogil=True, fastmath=True)
def _turn(first, last, beta, inverse, r, p):
    """The next direction, p = z + beta p."""
    for m in range(first, last):
        for k in range(LANES):
            p[m, k] = inverse[m] * r[m, k] + beta[k] * p[m, k]


@njit(cache=True, nogil=True)
def _spread(hanging, master, part, x):
    for i in range(len(hanging)):
        for q in range(LANES):
            total = 0.0
            for k in range(MASTERS):
                if master[i, k] >= 0:
                    total += x[master[i, k], q]
            x[hanging[i], q] = part[i] * total


@njit(cache=True, nogil=True)
def _fold(hanging, master, part, y):
    for i in range(len(hanging)):
        for q in range(LANES):
            for k in range(MASTERS):
                if master[i, k] >= 0:
                    y[master[i, k], q] += part[i] * y[hanging[i], q]
            y[hanging[i], q] = 0.0
