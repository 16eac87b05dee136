"""Narrow tunnels of a closed mesh, found by their shortest loops and closed where they are.

A scan has tunnels that the thing has not. The shortest loop that does not part the surface
(Erickson and Whittlesey 2005) runs around one or through it. The ring of faces along it is taken
out and both rims are capped: one handle less, and nothing else moves (after Guskov and Wood 2001).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.scan.cleaning import rims
from touchwarp.scan.deviation import diagonal
from touchwarp.scan.soundness import inspect
from touchwarp.scene.surface import Surface
from touchwarp.scene.tree_cotree import tree_cotree

Float = NDArray[np.float64]
Int = NDArray[np.int64]

NARROW = 0.1
"""Of the diagonal: a longer loop is taken for a handle's. 17 mm on a mug whose handle has 32."""
ROOTS = 48
"""Vertices that the shortest loop is looked for through; each takes 25 ms on 16,000 faces."""
RINGS = 3
"""How many rings of faces are taken out at most, until both rims can be capped."""
MOST_CORNERS = 60
"""Of a rim that is capped: one with more is no narrow tunnel's."""


def close_tunnels(surface: Surface, genus: int) -> tuple[Surface, tuple[float, ...]]:
    """The surface with its narrowest tunnels closed until it has so many handles, if that can be.

    Args:
        surface: one closed manifold; m.
        genus: the number of handles to end with, or as near above it as narrow tunnels allow.

    Returns:
        The surface, and the length in m of the loop around each tunnel that was closed.
    """
    narrow = NARROW * diagonal(surface)
    surface = _compact(surface)
    closed: list[float] = []
    while (handles := inspect(surface).genus) is not None and handles > genus:
        loop, length = shortest_loop(surface)
        cut = _without(surface, loop, genus) if length < narrow else None
        if cut is None:
            break
        surface = cut
        closed.append(length)
    return surface, tuple(closed)


def shortest_loop(surface: Surface) -> tuple[Int, float]:
    """A short loop that does not part a closed surface with handles: its vertices, and m around.

    The loops through one vertex cut the surface open, so the shortest of all meets them. The
    shortest through each of some of their vertices are taken, and then those through each vertex
    of the best, as long as that gets shorter.
    """
    loops = _loops(surface, 0)
    met = np.unique(np.concatenate(loops))
    roots = met[:: -(-len(met) // ROOTS)]
    tried, shortest, least = roots, loops[0], np.inf
    while len(roots):
        for root in roots:
            for loop in _loops(surface, int(root)):
                length = _length(surface, loop)
                if length < least - 1e-12:
                    shortest, least = loop, length
        roots = np.setdiff1d(shortest, tried)
        tried = np.union1d(tried, roots)
    return shortest, least


def _loops(surface: Surface, root: int) -> list[Int]:
    trees = tree_cotree(surface.vertices, surface.faces, root)
    return [trees.loop(int(edge)) for edge in trees.loops]


def _length(surface: Surface, loop: Int) -> float:
    points = surface.vertices[loop]
    return float(np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1).sum())


def _without(surface: Surface, loop: Int, genus: int) -> Surface | None:
    """One handle less: the faces along the loop out, both rims capped; None where no caps fit."""
    handles = inspect(surface).genus
    assert handles is not None, "one closed manifold"
    near = np.isin(np.arange(len(surface.vertices)), loop)
    for ring in range(RINGS):
        if ring:
            near[surface.faces[near[surface.faces].any(axis=1)]] = True
        kept = Surface(surface.vertices, surface.faces[~near[surface.faces].any(axis=1)])
        found = inspect(kept)
        if not found.manifold or found.bodies > 1:
            continue
        around = rims(kept.faces)
        if max(len(rim) for rim in around) > MOST_CORNERS:
            return None
        cut = _fanned(kept, around)
        left = inspect(cut)
        if left.sound and left.genus is not None and genus <= left.genus < handles:
            return _compact(cut)
    return None


def _fanned(surface: Surface, around: list[Int]) -> Surface:
    """Each rim closed by a fan about its middle: a chord could be an edge that is there already."""
    middles = np.array([surface.vertices[rim].mean(axis=0) for rim in around])
    fans = [
        np.stack([rim, np.roll(rim, -1), np.full(len(rim), len(surface.vertices) + k)], axis=1)
        for k, rim in enumerate(around)
    ]
    return Surface(
        np.concatenate([surface.vertices, middles]), np.concatenate([surface.faces, *fans])
    )


def _compact(surface: Surface) -> Surface:
    """Without vertices of no face."""
    used, faces = np.unique(surface.faces, return_inverse=True)
    return Surface(surface.vertices[used], faces.reshape(-1, 3).astype(np.int64))
