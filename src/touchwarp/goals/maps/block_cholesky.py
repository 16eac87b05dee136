"""Sparse Cholesky factors of symmetric matrices of 2 × 2 blocks that share one pattern.

H = L D Lᵀ, row of blocks by row of blocks (Davis 2006, "Direct Methods for Sparse Linear Systems",
chapter 4). In which order to eliminate, and where L has blocks, depends on the pattern alone and is
found once: refinements factorise the same pattern some twenty times.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Float = NDArray[np.float64]
Int = NDArray[np.int64]


class BlockCholesky:
    """Solves with many matrices of one pattern.

    Args:
        start, column: (n + 1,), (k,) where the matrices have blocks, row by row as of CSR, both
            triangles and the diagonal included.
    """

    def __init__(self, start: Int, column: Int) -> None:
        n = len(start) - 1
        self._rank = _elimination_ranks(start, column)
        row = self._rank[np.repeat(np.arange(n), np.diff(start))]
        column = self._rank[column]
        entry = np.lexsort((column, row))
        start = np.searchsorted(row[entry], np.arange(n + 1))
        self._pattern = (start, column[entry], entry)
        self._parent, self._of_column = _analyse(start, column[entry])

    def solve(self, blocks: Float, lift: float, right: Float) -> Float:
        """(n, 2): x of (H + lift) x = right; where that is not positive, with ten times the lift.

        Args:
            blocks: (k, 2, 2) of H.
            lift: > 0, added to the diagonal.
            right: (n, 2).
        """
        known = (*self._pattern, self._parent, self._of_column)
        positive, factors = _factorise(known, blocks, lift)
        while not positive:
            lift *= 10
            positive, factors = _factorise(known, blocks, lift)
        solution = np.empty_like(right)
        solution[self._rank] = right
        _substitute(self._of_column, factors, solution)
        return solution[self._rank]


def _elimination_ranks(start: Int, column: Int) -> Int:
    """(n,): the place of each row in an order of elimination that leaves L sparse."""
    from scipy.sparse import csc_matrix
    from scipy.sparse.linalg import splu

    n, many = len(start) - 1, np.diff(start)
    row = np.repeat(np.arange(n), many)
    dominant = np.where(row == column, many[row], -1.0)  # only where it has entries matters
    factors = splu(
        csc_matrix((dominant, column, start), shape=(n, n)),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    return np.asarray(factors.perm_c, np.int64)


@njit(cache=True, nogil=True)
def _analyse(start, column):
    """The elimination tree (n,), −1 at roots, and where each column of L begins (n + 1,)."""
    n = len(start) - 1
    parent, seen, of_column = np.full(n, -1), np.full(n, -1), np.zeros(n + 1, np.int64)
    for k in range(n):
        seen[k] = k
        for p in range(start[k], start[k + 1]):
            i = column[p]
            while i < k and seen[i] != k:
                if parent[i] < 0:
                    parent[i] = k
                of_column[i + 1] += 1
                seen[i] = k
                i = parent[i]
    return parent, of_column.cumsum()


@njit(cache=True, error_model="numpy", nogil=True)
def _factorise(known, blocks, lift):
    """Whether H + lift is positive, and its factors: rows (l,) and blocks (l, 4) of L, D⁻¹ (n, 3).

    A row of L solves a triangular system in the rows above. It has blocks only where the
    elimination tree leads to from those of H, and those are gone through from the leaves on.
    """
    start, column, entry, parent, of_column = known
    n = len(parent)
    row, lower = np.empty(of_column[n], np.int32), np.empty((of_column[n], 4))
    inverse = np.empty((n, 3))
    factors = (row, lower, inverse)
    end, seen = of_column[:-1].copy(), np.full(n, -1)
    reached, path = np.empty(n, np.int64), np.empty(n, np.int64)
    own = np.zeros((n, 4))
    for k in range(n):
        first, seen[k] = n, k
        xx, xy, yy = 0.0, 0.0, 0.0
        for p in range(start[k], start[k + 1]):
            i = column[p]
            (xa, xb), (ya, yb) = blocks[entry[p]]
            if i == k:
                xx, xy, yy = xa + lift, xb, yb + lift
            if i >= k:
                continue
            own[i, 0], own[i, 1], own[i, 2], own[i, 3] = xa, xb, ya, yb
            length = 0
            while seen[i] != k:
                path[length], seen[i] = i, k
                length += 1
                i = parent[i]
            while length > 0:
                first, length = first - 1, length - 1
                reached[first] = path[length]
        for t in range(first, n):
            i = reached[t]
            a, b, c, d = own[i, 0], own[i, 1], own[i, 2], own[i, 3]
            own[i, 0], own[i, 1], own[i, 2], own[i, 3] = 0.0, 0.0, 0.0, 0.0
            for p in range(of_column[i], end[i]):
                j = row[p]
                own[j, 0] -= a * lower[p, 0] + b * lower[p, 1]
                own[j, 1] -= a * lower[p, 2] + b * lower[p, 3]
                own[j, 2] -= c * lower[p, 0] + d * lower[p, 1]
                own[j, 3] -= c * lower[p, 2] + d * lower[p, 3]
            u, v, w = inverse[i, 0], inverse[i, 1], inverse[i, 2]
            p = end[i]
            row[p], end[i] = k, p + 1
            lower[p, 0], lower[p, 1] = a * u + b * v, a * v + b * w
            lower[p, 2], lower[p, 3] = c * u + d * v, c * v + d * w
            xx -= lower[p, 0] * a + lower[p, 1] * b
            xy -= lower[p, 0] * c + lower[p, 1] * d
            yy -= lower[p, 2] * c + lower[p, 3] * d
        determinant = xx * yy - xy * xy
        if xx <= 0.0 or determinant <= 0.0:
            return False, factors
        inverse[k, 0], inverse[k, 1], inverse[k, 2] = yy, -xy, xx
        for d in range(3):
            inverse[k, d] /= determinant
    return True, factors


@njit(cache=True, error_model="numpy", nogil=True)
def _substitute(of_column, factors, x):
    """Turn the right side (n, 2) into the solution."""
    row, lower, inverse = factors
    n = len(x)
    for k in range(n):
        a, b = x[k, 0], x[k, 1]
        for p in range(of_column[k], of_column[k + 1]):
            j = row[p]
            x[j, 0] -= lower[p, 0] * a + lower[p, 1] * b
            x[j, 1] -= lower[p, 2] * a + lower[p, 3] * b
    for k in range(n - 1, -1, -1):
        a = inverse[k, 0] * x[k, 0] + inverse[k, 1] * x[k, 1]
        b = inverse[k, 1] * x[k, 0] + inverse[k, 2] * x[k, 1]
        for p in range(of_column[k], of_column[k + 1]):
            j = row[p]
            a -= lower[p, 0] * x[j, 0] + lower[p, 2] * x[j, 1]
            b -= lower[p, 1] * x[j, 0] + lower[p, 3] * x[j, 1]
        x[k, 0], x[k, 1] = a, b
