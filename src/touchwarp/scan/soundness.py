"""What keeps a surface from being one closed, oriented manifold, and its genus where it is one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.scene.surface import Surface
from touchwarp.scene.topology import bodies, duplicate_count, edge_counts, loop_count


@dataclass(frozen=True)
class Soundness:
    """Counts of what is wrong with a triangle surface; all 0 and one body if nothing is.

    Attributes:
        bodies: pieces that share no vertex.
        open_edges: edges with one face; `holes` chains of them.
        holes: their rims.
        crowded_edges: edges with more than two faces.
        pinched_vertices: vertices where the faces around form more than one fan.
        turned_edges: edges whose two faces are turned against each other.
        duplicate_faces: faces with the corners of an earlier one.
        euler: vertices − edges + faces, of used vertices.
        inside_out: closed and oriented, but the normals point inward.
    """

    bodies: int
    open_edges: int
    holes: int
    crowded_edges: int
    pinched_vertices: int
    turned_edges: int
    duplicate_faces: int
    euler: int
    inside_out: bool

    @property
    def manifold(self) -> bool:
        """Every edge has one or two faces, every vertex one fan."""
        return not (self.crowded_edges or self.pinched_vertices)

    @property
    def closed(self) -> bool:
        """A closed manifold, all its faces turned alike."""
        return self.manifold and self.open_edges == 0 and self.turned_edges == 0

    @property
    def sound(self) -> bool:
        """One closed manifold with its normals outward: what a surface map needs."""
        return self.closed and self.bodies == 1 and not self.inside_out

    @property
    def genus(self) -> int | None:
        """The number of handles of one closed body; of one open manifold, were its holes capped.

        From χ = 2 − 2·genus − holes. None where more bodies or non-manifold places leave it open.
        """
        if not self.manifold or self.turned_edges or self.bodies != 1:
            return None
        return (2 - self.euler - self.holes) // 2

    def faults(self) -> str:
        """What is wrong, in words: "442 holes, 16 bodies"; "nothing" if nothing is."""
        bodies = self.bodies if self.bodies > 1 else 0
        named = [
            (self.holes, "hole", "holes"),
            (bodies, "body", "bodies"),
            (self.crowded_edges, "edge of over two faces", "edges of over two faces"),
            (self.pinched_vertices, "pinched vertex", "pinched vertices"),
            (self.turned_edges, "edge between opposed faces", "edges between opposed faces"),
            (self.duplicate_faces, "duplicate face", "duplicate faces"),
        ]
        words = [f"{n:,} {one if n == 1 else many}" for n, one, many in named if n]
        if self.inside_out:
            words.append("normals that point inward")
        return ", ".join(words) or "nothing"


def inspect(surface: Surface) -> Soundness:
    """Look for faults of a triangle surface; equal vertices must be welded already."""
    import igl

    faces = surface.faces
    edges, counts = edge_counts(faces)
    used = np.unique(faces)
    compact = np.searchsorted(used, faces)
    fans = np.asarray(igl.is_vertex_manifold(np.ascontiguousarray(compact)))
    turned = turned_edge_count(faces)
    crowded = int((counts > 2).sum())
    open_edges = int((counts == 1).sum())
    closed = not (crowded or open_edges or turned)
    return Soundness(
        bodies=int(bodies(faces).max()) + 1,
        open_edges=open_edges,
        holes=loop_count(edges[counts == 1]),
        crowded_edges=crowded,
        pinched_vertices=int((~fans).sum()),
        turned_edges=turned,
        duplicate_faces=duplicate_count(faces),
        euler=len(used) - len(edges) + len(faces),
        inside_out=closed and volume(surface) < 0,
    )


def turned_edge_count(faces: NDArray[np.int64]) -> int:
    """Edges of two faces that both run along them the same way."""
    start, end = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    base = int(faces.max()) + 1
    _, shared = np.unique(
        np.minimum(start, end) * base + np.maximum(start, end), return_inverse=True
    )
    way = np.bincount(shared, weights=np.where(start < end, 1.0, -1.0))
    two = np.bincount(shared) == 2
    return int((two & (way != 0)).sum())


def volume(surface: Surface) -> float:
    """m³: what a closed surface holds; negative if its normals point inward."""
    a, b, c = (surface.vertices - surface.bounds.mean(axis=0))[surface.faces].transpose(1, 0, 2)
    return float((a * np.cross(b, c)).sum() / 6)
