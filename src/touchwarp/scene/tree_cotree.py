"""A closed mesh cut open: a tree of its edges, one of its faces, and 2·genus edges in neither.

Tree–cotree (Eppstein 2003; Erickson and Whittlesey 2005): each edge in neither closes a loop on the
tree, and these loops generate the fundamental group.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.scene.topology import opposite_halfedges

Float = NDArray[np.float64]
Int = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class TreeCotree:
    """The trees; half-edge k·m + f runs from corner k of face f to the next.

    Attributes:
        start, end, opposite, face: (3m,) of half-edges.
        parent: (n,) in the tree of edges, which has shortest ways from its root; < 0 there.
        face_parent: (m,) in the tree of faces; < 0 at its root.
        face_order: (m,) faces, none before its parent.
        loops: (2·genus,) a half-edge of each edge in neither tree.
    """

    start: Int
    end: Int
    opposite: Int
    face: Int
    parent: Int
    face_parent: Int
    face_order: Int
    loops: Int

    @property
    def in_tree(self) -> NDArray[np.bool_]:
        """(3m,): which half-edges are in the tree of edges."""
        ahead, back = self.parent[self.start] == self.end, self.parent[self.end] == self.start
        return np.asarray(ahead | back)

    def loop(self, edge: int) -> Int:
        """The vertices, in order, of the loop that a half-edge closes; the last joins the first."""
        there, back = meeting_paths(self.parent, int(self.start[edge]), int(self.end[edge]))
        return np.array(there[::-1] + back[:-1], dtype=np.int64)


def tree_cotree(vertices: Float, faces: Int, root: int = 0) -> TreeCotree:
    """Both trees, the first from a root; loops come out short where the mesh allows.

    Args:
        vertices: (n, 3) m; all are used.
        faces: (m, 3) of one closed manifold, all turned alike.
        root: the vertex that all loops start from.
    """
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import breadth_first_order, dijkstra, minimum_spanning_tree

    n, m = len(vertices), len(faces)
    start, end = faces.T.ravel(), faces[:, [1, 2, 0]].T.ravel()
    opposite = opposite_halfedges(faces, n)
    face = np.tile(np.arange(m), 3)
    length = np.linalg.norm(vertices[start] - vertices[end], axis=1)
    once = np.flatnonzero(start < end)
    graph = csr_matrix((length[once], (start[once], end[once])), shape=(n, n))
    distance, parent = dijkstra(graph, directed=False, indices=root, return_predecessors=True)
    in_tree = (parent[start[once]] == end[once]) | (parent[end[once]] == start[once])
    free = once[~in_tree]
    # The dual tree takes the edges of long loops first, which leaves short ones as generators.
    around = distance[start[free]] + distance[end[free]] + length[free]
    weights = 4 * distance.max() + length.max() - around
    dual = csr_matrix((weights, (face[free], face[opposite[free]])), shape=(m, m))
    cotree = minimum_spanning_tree(dual).tocoo()
    taken = np.unique(cotree.row.astype(np.int64) * m + cotree.col)
    links = csr_matrix((np.ones(len(cotree.row)), (cotree.row, cotree.col)), shape=(m, m))
    order, face_parent = breadth_first_order(links, 0, directed=False)
    loops = free[~np.isin(face[free] * m + face[opposite[free]], taken)]
    return TreeCotree(
        start,
        end,
        opposite,
        face,
        parent.astype(np.int64),
        face_parent.astype(np.int64),
        order.astype(np.int64),
        loops,
    )


def meeting_paths(parent: NDArray[np.int64], one: int, other: int) -> tuple[list[int], list[int]]:
    """The ways from two nodes of a tree up to where they meet, that node in both."""
    ways = []
    for node in (one, other):
        way = [node]
        while parent[way[-1]] >= 0:
            way.append(int(parent[way[-1]]))
        ways.append(way)
    while len(ways[0]) > 1 and len(ways[1]) > 1 and ways[0][-2] == ways[1][-2]:
        ways[0].pop()
        ways[1].pop()
    return ways[0], ways[1]
