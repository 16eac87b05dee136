"""Sparse symmetric systems with one 2 × 2 block for each vertex and edge of a mesh.

The unknowns are moves of the vertices along two tangents of the domain each.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.goals.maps.block_cholesky import BlockCholesky


class BlockSystem:
    """A Gauss–Newton system H d = −g on a mesh's vertices, assembled term by term.

    Attributes:
        blocks: (k, 2, 2) the matrix H; block `place[f, i, j]` couples corners i and j of face f.
        slope: (n, 2) the gradient g.
    """

    def __init__(self, faces: NDArray[np.int64], vertices: int) -> None:
        self.faces = faces
        rows = np.repeat(faces, 3, axis=1).ravel()
        columns = np.tile(faces, (1, 3)).ravel()
        keys, place = np.unique(rows * vertices + columns, return_inverse=True)
        self.place = np.ascontiguousarray(place.reshape(-1, 3, 3))
        start = np.searchsorted(keys, np.arange(vertices + 1) * vertices)
        self._cholesky = BlockCholesky(start, keys % vertices)
        self.diagonal = np.searchsorted(keys, np.arange(vertices) * (vertices + 1))
        self.blocks = np.zeros((len(keys), 2, 2))
        self.slope = np.zeros((vertices, 2))

    def clear(self) -> None:
        """Start a new assembly."""
        self.blocks[:] = 0.0
        self.slope[:] = 0.0

    def add_areas(
        self,
        gradient: NDArray[np.float64],
        first: NDArray[np.float64],
        second: NDArray[np.float64],
    ) -> None:
        """A function of each triangle's area; gradient (m, 3, 2), its two derivatives (m,)."""
        _add_areas(self.faces, self.place, gradient, first, second, self.blocks, self.slope)

    def add_differences(
        self,
        weights: NDArray[np.float64],
        jacobian: NDArray[np.float64],
        values: NDArray[np.float64] | None = None,
    ) -> None:
        """½ Σ w |y_i − y_j|² over edges opposite corners: w (m, 3), ∂y (n, c, 2), y (n, c)."""
        if values is None:
            values = np.zeros(jacobian.shape[:2])
        _add_differences(self.faces, self.place, weights, jacobian, values, self.blocks, self.slope)

    def add_residuals(
        self,
        weights: NDArray[np.float64],
        jacobian: NDArray[np.float64],
        residuals: NDArray[np.float64],
    ) -> None:
        """½ Σ w r² at each vertex: w (n,), ∂r (n, c, 2), r (n, c)."""
        self.blocks[self.diagonal] += np.einsum("n,nci,ncj->nij", weights, jacobian, jacobian)
        self.slope += np.einsum("n,nci,nc->ni", weights, jacobian, residuals)

    def add_in_face(
        self,
        face: int,
        weight: float,
        jacobian: NDArray[np.float64],
        residual: NDArray[np.float64],
    ) -> None:
        """½ w |r|² of one residual (c,) that depends on a face's corners by ∂r (3, c, 2)."""
        for i in range(3):
            self.slope[self.faces[face, i]] += weight * residual @ jacobian[i]
            for j in range(3):
                self.blocks[self.place[face, i, j]] += weight * jacobian[i].T @ jacobian[j]

    def solve(self, damping: float) -> NDArray[np.float64]:
        """(n, 2): d of (H + damping · mean diagonal) d = −g."""
        mean = float(np.trace(self.blocks[self.diagonal], axis1=1, axis2=2).mean()) / 2
        return self._cholesky.solve(self.blocks, damping * mean, -self.slope)


@njit(cache=True, error_model="numpy")
def _add_areas(faces, place, gradient, first, second, blocks, slope):
    for f in range(len(faces)):
        for i in range(3):
            for a in range(2):
                slope[faces[f, i], a] += first[f] * gradient[f, i, a]
                scaled = second[f] * gradient[f, i, a]
                for j in range(3):
                    for b in range(2):
                        blocks[place[f, i, j], a, b] += scaled * gradient[f, j, b]


@njit(cache=True, error_model="numpy")
def _add_differences(faces, place, weights, jacobian, values, blocks, slope):
    channels = values.shape[1]
    for f in range(len(faces)):
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            v, w = faces[f, i], faces[f, j]
            weight = weights[f, k]
            for c in range(channels):
                gap = weight * (values[v, c] - values[w, c])
                for a in range(2):
                    slope[v, a] += gap * jacobian[v, c, a]
                    slope[w, a] -= gap * jacobian[w, c, a]
                    at_v, at_w = weight * jacobian[v, c, a], weight * jacobian[w, c, a]
                    for b in range(2):
                        blocks[place[f, i, i], a, b] += at_v * jacobian[v, c, b]
                        blocks[place[f, j, j], a, b] += at_w * jacobian[w, c, b]
                        blocks[place[f, i, j], a, b] -= at_v * jacobian[w, c, b]
                        blocks[place[f, j, i], a, b] -= at_w * jacobian[v, c, b]
