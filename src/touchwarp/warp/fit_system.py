"""The contact fit's normal equations: a sparse matrix and conjugate gradients on four lanes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from touchwarp.errors import SolveError
from touchwarp.solve.stencil import LANES

REDUCTION = 1e-6
"""Of the preconditioned residual. Misfits before the fit are below 1 mm: what is left is
nanometres, so that fits of sums are sums of fits."""

MOST_STEPS = 3000

Real = NDArray[np.float64]


PARTS = 4
"""Parts of the matrix that are assembled side by side."""


@dataclass(eq=False)
class FitSystem:
    """(Σ w N Nᵀ + κ) x = rhs, the hanging unknowns eliminated.

    Attributes:
        count: unknowns, hanging ones included; their rows are empty.
        start: (count + 1,) first entry of each row; length: (count,) entries in use.
        column, value: the entries.
        inverse_diagonal: (count,), 0 for hanging unknowns.
        behind: (count,) bool, behind a surface; floor: (count,) bool, on the sliding plane.
        hanging: (k,); master: (k, 4), -1 where unused; share: (k,) 1, ½ or ¼.
    """

    count: int
    start: NDArray[np.int64]
    length: NDArray[np.int32]
    column: NDArray[np.int32]
    value: NDArray[np.float32]
    inverse_diagonal: Real
    behind: NDArray[np.bool_]
    floor: NDArray[np.bool_]
    hanging: NDArray[np.int32]
    master: NDArray[np.int32]
    share: Real

    def solve(self, rhs: Real, normal_lanes: NDArray[np.bool_]) -> Real:
        """x (count, 4) for a right-hand side that is still to be folded on to masters.

        First the nodes behind surfaces alone, then all nodes for what is left.

        Raises:
            SolveError: no convergence.
        """
        _fold(self.hanging, self.master, self.share, rhs)
        inverse = np.repeat(self.inverse_diagonal[:, None], LANES, axis=1)
        inverse[np.ix_(self.floor, normal_lanes)] = 0.0
        behind = np.where(self.behind[:, None], inverse, 0.0)
        x = self._conjugate_gradients(rhs, behind)
        x += self._conjugate_gradients(rhs, inverse)
        _spread(self.hanging, self.master, self.share, x)
        return x

    def _conjugate_gradients(self, r: Real, inverse: Real) -> Real:
        """x where `inverse` is not 0; `r` becomes what is left of the right-hand side."""
        x = np.zeros_like(r)
        z = inverse * r
        p, q = z.copy(), np.empty_like(r)
        rz = np.einsum("ij,ij->j", r, z)
        goal = REDUCTION**2 * rz
        for _ in range(MOST_STEPS):
            if (rz <= goal).all():
                return x
            pq = _multiply(self.start, self.length, self.column, self.value, p, q)
            alpha = np.divide(rz, pq, out=np.zeros(LANES), where=pq > 0.0)
            new = _advance(alpha, p, q, inverse, x, r, z)
            beta = np.divide(new, rz, out=np.zeros(LANES), where=rz > 0.0)
            _turn(beta, z, p)
            rz = new
        left = float(np.sqrt((rz / np.maximum(goal, 1e-300)).max())) * REDUCTION
        raise SolveError(
            f"The contact fit did not converge in {MOST_STEPS} steps: {left:.1e} of the residual "
            f"is left, {REDUCTION} was needed. Look for degenerate faces with `touchwarp info`."
        )


def make_system(
    count: int,
    cells: NDArray[np.int32],
    gram: Real,
    tie: Real,
    behind: NDArray[np.bool_],
    floor: NDArray[np.bool_],
    hanging: NDArray[np.int32],
    master: NDArray[np.int32],
    share: Real,
) -> FitSystem:
    """Assemble the matrix from cells (c, 8) of unknowns and their Gram matrices (c, 8, 8)."""
    link = np.full(count, -1, np.int32)
    link[hanging] = np.arange(len(hanging))
    room = np.zeros(count + 1, np.int64)
    _room(cells, link, master, room)
    room[1:] += 1
    start = np.cumsum(room)
    length = np.zeros(count, np.int32)
    column = np.empty(start[-1], np.int32)
    value = np.empty(start[-1], np.float32)
    tie = tie.copy()
    tie[hanging] = 0.0
    _assemble(cells, gram, tie, link, master, share, start, length, column, value)
    diagonal = np.zeros(count)
    _diagonal(start, length, column, value, diagonal)
    inverse = np.divide(1.0, diagonal, out=np.zeros(count), where=diagonal > 0.0)
    inverse[hanging] = 0.0
    return FitSystem(
        count, start, length, column, value, inverse, behind, floor, hanging, master, share
    )


@njit(cache=True)
def _expand(unknown, link, master, share, out, weight):
    """The masters of an unknown with their weights; itself, unless it hangs."""
    if unknown < 0:
        return 0
    h = link[unknown]
    if h < 0:
        out[0] = unknown
        weight[0] = 1.0
        return 1
    n = 0
    for k in range(4):
        if master[h, k] >= 0:
            out[n] = master[h, k]
            weight[n] = share[h]
            n += 1
    return n


@njit(cache=True)
def _room(cells, link, master, room):
    out = np.empty(32, np.int32)
    weight = np.empty(4)
    share = np.ones(len(master))
    for c in range(len(cells)):
        n = 0
        for i in range(8):
            n += _expand(cells[c, i], link, master, share, out[n : n + 4], weight)
        for i in range(n):
            room[out[i] + 1] += n


@njit(cache=True)
def _add(row, to, amount, start, length, column, value):
    first = start[row]
    for e in range(first, first + length[row]):
        if column[e] == to:
            value[e] += amount
            return
    e = first + length[row]
    column[e] = to
    value[e] = amount
    length[row] += 1


@njit(cache=True, parallel=True)
def _assemble(cells, gram, tie, link, master, share, start, length, column, value):
    # Each part of the rows goes through all cells, so that no two threads write to one row.
    for part in prange(PARTS):
        first, end = len(tie) * part // PARTS, len(tie) * (part + 1) // PARTS
        rows, columns = np.empty(4, np.int32), np.empty(4, np.int32)
        row_weight, column_weight = np.empty(4), np.empty(4)
        for m in range(first, end):
            if tie[m] > 0.0:
                _add(m, m, tie[m], start, length, column, value)
        for c in range(len(cells)):
            for i in range(8):
                n = _expand(cells[c, i], link, master, share, rows, row_weight)
                for a in range(n):
                    if not first <= rows[a] < end:
                        continue
                    for j in range(8):
                        k = _expand(cells[c, j], link, master, share, columns, column_weight)
                        for b in range(k):
                            _add(
                                rows[a],
                                columns[b],
                                row_weight[a] * column_weight[b] * gram[c, i, j],
                                start,
                                length,
                                column,
                                value,
                            )


@njit(cache=True)
def _diagonal(start, length, column, value, diagonal):
    for m in range(len(diagonal)):
        for e in range(start[m], start[m] + length[m]):
            if column[e] == m:
                diagonal[m] = value[e]


@njit(cache=True, parallel=True, fastmath=True)
def _multiply(start, length, column, value, x, y):
    """y = A x; returns x · y for each lane."""
    xy0 = xy1 = xy2 = xy3 = 0.0
    for m in prange(len(length)):
        s0 = s1 = s2 = s3 = 0.0
        for e in range(start[m], start[m] + length[m]):
            c, v = column[e], value[e]
            s0 += v * x[c, 0]
            s1 += v * x[c, 1]
            s2 += v * x[c, 2]
            s3 += v * x[c, 3]
        y[m, 0], y[m, 1], y[m, 2], y[m, 3] = s0, s1, s2, s3
        xy0 += s0 * x[m, 0]
        xy1 += s1 * x[m, 1]
        xy2 += s2 * x[m, 2]
        xy3 += s3 * x[m, 3]
    return np.array([xy0, xy1, xy2, xy3])


@njit(cache=True, parallel=True, fastmath=True)
def _advance(alpha, p, q, inverse, x, r, z):
    """One step along p; returns r · z for each lane."""
    rz0 = rz1 = rz2 = rz3 = 0.0
    for m in prange(len(x)):
        for k in range(LANES):
            x[m, k] += alpha[k] * p[m, k]
            r[m, k] -= alpha[k] * q[m, k]
            z[m, k] = inverse[m, k] * r[m, k]
        rz0 += r[m, 0] * z[m, 0]
        rz1 += r[m, 1] * z[m, 1]
        rz2 += r[m, 2] * z[m, 2]
        rz3 += r[m, 3] * z[m, 3]
    return np.array([rz0, rz1, rz2, rz3])


@njit(cache=True, parallel=True, fastmath=True)
def _turn(beta, z, p):
    for m in prange(len(p)):
        for k in range(LANES):
            p[m, k] = z[m, k] + beta[k] * p[m, k]


@njit(cache=True)
def _spread(hanging, master, share, x):
    for i in range(len(hanging)):
        for q in range(LANES):
            total = 0.0
            for k in range(4):
                if master[i, k] >= 0:
                    total += x[master[i, k], q]
            x[hanging[i], q] = share[i] * total


@njit(cache=True)
def _fold(hanging, master, share, y):
    for i in range(len(hanging)):
        for q in range(LANES):
            for k in range(4):
                if master[i, k] >= 0:
                    y[master[i, k], q] += share[i] * y[hanging[i], q]
            y[hanging[i], q] = 0.0
