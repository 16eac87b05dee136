"""What faces share: edges, bodies, boundary loops. Positions play no part."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def edge_counts(faces: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Undirected edges of triangles (e, 2), or end points of segments (e, 1), and faces on each."""
    if faces.shape[1] == 2:
        ends, counts = np.unique(faces, return_counts=True)
        return ends[:, None], counts
    low = np.minimum(faces, faces[:, [1, 2, 0]]).ravel()
    high = np.maximum(faces, faces[:, [1, 2, 0]]).ravel()
    base = int(faces.max()) + 1
    keys, counts = np.unique(low * base + high, return_counts=True)
    return np.stack([keys // base, keys % base], axis=1), counts


def open_edge_count(faces: NDArray[np.int64]) -> int:
    """How many edges have an odd number of faces; 0 on a closed surface."""
    return int((edge_counts(faces)[1] % 2).sum())


def bodies(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """A body number for each face; faces that share a vertex are of one body."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    n = int(faces.max()) + 1
    rows = faces[:, :-1].ravel()
    columns = faces[:, 1:].ravel()
    graph = coo_matrix((np.ones(len(rows), dtype=np.bool_), (rows, columns)), shape=(n, n))
    of_vertex = connected_components(graph, directed=False)[1]
    return np.unique(of_vertex[faces[:, 0]], return_inverse=True)[1].astype(np.int64)


def loop_count(edges: NDArray[np.int64]) -> int:
    """How many connected chains the edges (e, 2) form."""
    if len(edges) == 0:
        return 0
    return int(bodies(np.unique(edges, return_inverse=True)[1].reshape(-1, 2)).max()) + 1


def duplicate_count(faces: NDArray[np.int64]) -> int:
    """How many faces have the same corners as an earlier one, in any order."""
    corners = np.sort(faces, axis=1)
    order = np.lexsort(corners.T)
    ordered = corners[order]
    return int((ordered[1:] == ordered[:-1]).all(axis=1).sum())


def opposite_halfedges(faces: NDArray[np.int64], vertices: int) -> NDArray[np.int64]:
    """(3m,): for half-edge k·m + f, from corner k to k + 1 of face f, the one that runs back."""
    start = faces.T.ravel()
    end = faces[:, [1, 2, 0]].T.ravel()
    forth, back = start * vertices + end, end * vertices + start
    order = np.argsort(forth)
    return np.asarray(order[np.searchsorted(forth[order], back)])
