"""A coarse mesh with a word for each corner, and the springs that lay it out in a mapping class.

The words are elements of the fundamental group in letters of the mesh's own loops; images of these
letters in canonical ones make a class of maps to the hyperbolic surface. In each class the layout
with every vertex at the mean of its neighbours is one-to-one (Tutte's theorem holds on surfaces of
curvature ≤ 0 too: Colin de Verdière 1991), and its springs' energy tells how far the class
stretches the mesh.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.goals.maps.closed_mesh import ClosedMesh
from touchwarp.goals.maps.hyperbolic.deck import (
    Deck,
    carry,
    evaluate,
    polygon_generators,
    product,
)
from touchwarp.goals.maps.hyperbolic.layout import HyperbolicLayout, laid_out
from touchwarp.goals.maps.hyperbolic.mapping_classes import Moves
from touchwarp.goals.maps.hyperbolic.words import (
    Images,
    Shortener,
    Word,
    canonical_word,
    free,
    homology_matrix,
    inverse,
    substitute,
)
from touchwarp.goals.maps.rings import build_rings, place_in_ring
from touchwarp.goals.maps.star import onto_domain
from touchwarp.scene.tree_cotree import TreeCotree, tree_cotree

Float = NDArray[np.float64]
Int = NDArray[np.int64]

ROUGH_ROUNDS, ROUGH = 400, 1e-4
"""Sweeps, and the move of a vertex, at which springs are still enough to be compared."""
FINE_ROUNDS, FINE = 5000, 1e-10
FAR = 3e4
"""Elements that take the middle farther than this in space are those of no sensible class."""
TOO_FAR = 1e9
LESS = 1 - 1e-9


class Springs:
    """A coarse mesh whose corners have words.

    Attributes:
        mesh: the mesh.
        relator: of its loops, a word of one vertex.
        loops: the vertices of each letter's loop, from the root and back to it.
    """

    def __init__(self, mesh: ClosedMesh, root: int) -> None:
        """Cut the mesh open along loops from a vertex."""
        self.mesh = mesh
        trees = tree_cotree(mesh.vertices, mesh.faces, root)
        self.loops = [_from_root(trees, int(edge)) for edge in trees.loops]
        _, relator = _spread(mesh, trees, free)
        while relator[0] == -relator[-1]:
            relator = relator[1:-1]
        self.relator = relator
        assert len(relator) == 4 * mesh.genus, "each loop is passed twice"
        shorten = Shortener(relator)
        words, rest = _spread(mesh, trees, shorten)
        assert rest == (), "the relator is the identity"
        m = len(mesh.faces)
        self._words: list[Word] = [()]
        self._number: dict[Word, int] = {(): 0}
        self._corner = np.array(
            [
                [0, self._index(words[f]), self._index(shorten(words[f] + words[m + f]))]
                for f in range(m)
            ]
        )
        nothing = np.zeros((m, 3, 2))
        self._ring, _, self._degree, _ = build_rings(mesh.faces, nothing, len(mesh.vertices))
        self._across = np.zeros(self._ring.shape, np.int64)
        for k in range(3):
            ahead = mesh.faces[:, (k + 1) % 3]
            for f, (v, w) in enumerate(zip(mesh.faces[:, k].tolist(), ahead.tolist(), strict=True)):
                place = int(np.flatnonzero(self._ring[v] == w)[0])
                self._across[v, place] = self._index(words[k * m + f])
        self._canonical = Shortener(canonical_word(mesh.genus))
        self._generators = polygon_generators(canonical_word(mesh.genus))

    def drawn(self, vertices: Int) -> Word:
        """The word of a path through vertices (k,) in turn, by the shortest ways along edges."""
        from scipy.sparse import csr_matrix
        from scipy.sparse.csgraph import dijkstra

        mesh = self.mesh
        start, end = mesh.faces.T.ravel(), mesh.faces[:, [1, 2, 0]].T.ravel()
        length = np.linalg.norm(mesh.vertices[start] - mesh.vertices[end], axis=1)
        graph = csr_matrix((length, (start, end)), shape=(len(mesh.vertices),) * 2)
        before = dijkstra(graph, indices=vertices[1:], return_predecessors=True)[1]
        word: list[int] = []
        for k, v in enumerate(vertices[:-1].tolist()):
            while v != vertices[k + 1]:  # the graph is symmetric: the way back is the way there
                ahead = int(before[k, v])
                place = int(np.flatnonzero(self._ring[v, : self._degree[v]] == ahead)[0])
                number = int(self._across[v, place])
                step = self._words[abs(number)]
                word += step if number >= 0 else inverse(step)
                v = ahead
        return free(word)

    def energy(self, images: Images) -> float:
        """Σ (cosh d − 1) over the edges, when the springs are about still."""
        return self._still(images, ROUGH_ROUNDS, ROUGH)[0]

    def descend(self, images: dict[int, Word], moves: Moves) -> tuple[float, dict[int, Word]]:
        """The least energy by moves, always the best of them, and its images."""
        energy = self.energy(images)
        while True:
            tried = [self.moved(images, move) for move in moves.values()]
            energies = [self.energy(each) for each in tried]
            best = int(np.argmin(energies))
            if energies[best] >= LESS * energy:
                return energy, images
            energy, images = energies[best], tried[best]

    def moved(self, images: Images, move: Images) -> dict[int, Word]:
        """Images after a move of the canonical letters, about the base point of shortest words.

        A detour of the base point is the same class, yet makes its elements far for nothing.
        """
        short = self._canonical
        best = {letter: short(substitute(word, move)) for letter, word in images.items()}
        ways = [(s * k,) for k in move for s in (1, -1)]
        while True:
            tried = [
                {letter: short((*way, *word, *inverse(way))) for letter, word in best.items()}
                for way in ways
            ]
            shortest = min(tried, key=_letters)
            if _letters(shortest) >= _letters(best):
                return best
            best = shortest

    def lay_out(self, images: Images, deck: Deck) -> HyperbolicLayout:
        """The layout of a class, every vertex in the polygon about the middle.

        The springs come to rest twice: far elements round off what is near.
        """
        _, points = self._still(images, ROUGH_ROUNDS, ROUGH)
        numbers = [deck.element(self._canonical(substitute(w, images))) for w in self._words]
        elements = np.sign(self._corner) * np.array(numbers)[np.abs(self._corner)]
        near = laid_out(self.mesh, points, elements, deck).gathered()
        across = _ring_elements(
            self.mesh.faces, near.elements, self._ring, self._degree, deck.tables
        )
        state = (near.points, self._ring, across, self._degree, deck.tables[0])
        _pull(*state, FINE_ROUNDS, FINE)
        return near.moved(near.points).gathered()

    def key(self, images: Images) -> tuple[float, ...]:
        """The same for the same class, whatever the base point of its loops: homology and traces.

        Traces alone do not tell a class of genus 2 from the one that is turned half round on the
        surface besides: that turn reverses every loop.
        """
        matrices = [evaluate(word, self._generators) for word in images.values()]
        pairs = [a @ b for k, a in enumerate(matrices) for b in matrices[k + 1 :]]
        # no element but the identity has a trace of 3 or less; those of far classes are noise
        traces = [max(abs(float(np.trace(matrix))), 3.0) for matrix in matrices + pairs]
        counts = homology_matrix(images).ravel().tolist()
        return (*counts, *np.round(np.log(traces), 4).tolist())

    def _index(self, word: Word) -> int:
        if word in self._number:
            return self._number[word]
        self._words.append(word)
        self._number[word] = len(self._words) - 1
        self._number[inverse(word)] = 1 - len(self._words)
        return self._number[word]

    def _still(self, images: Images, rounds: int, enough: float) -> tuple[float, Float]:
        shorten, generators = self._canonical, self._generators
        matrices = np.stack(
            [evaluate(shorten(substitute(word, images)), generators) for word in self._words]
        )
        points = np.zeros((len(self._degree), 3))
        points[:, 2] = 1.0
        if not np.abs(matrices).max() < FAR:
            return TOO_FAR * float(np.log(matrices[:, 2, 2].clip(1.0, 1e300)).sum()), points
        state = (points, self._ring, self._across, self._degree, matrices)
        _pull(*state, rounds, enough)
        return float(_energy(*state)), points


def _from_root(trees: TreeCotree, edge: int) -> Int:
    """The vertices from the root along a half-edge that closes a loop, and back to the root."""
    ways = []
    for end in (int(trees.start[edge]), int(trees.end[edge])):
        way = [end]
        while trees.parent[way[-1]] >= 0:
            way.append(int(trees.parent[way[-1]]))
        ways.append(way)
    return np.array(ways[0][::-1] + ways[1], dtype=np.int64)


def _letters(images: Images) -> int:
    return sum(len(word) for word in images.values())


def _spread(
    mesh: ClosedMesh, trees: TreeCotree, shorten: Callable[[Word], Word]
) -> tuple[list[Word], Word]:
    """The word of each half-edge (3m,), and what is left around the last face: the relator.

    Edges of the tree have the empty word, loops their letters. All other edges follow, from the
    leaves of the tree of faces to its root, as each face's three multiply to nothing.
    """
    m = len(mesh.faces)
    words: list[Word | None] = [None] * (3 * m)
    for h in np.flatnonzero(trees.in_tree).tolist():
        words[h] = ()
    for letter, h in enumerate(trees.loops.tolist(), 1):
        words[h], words[int(trees.opposite[h])] = (letter,), (-letter,)
    opposite = trees.opposite.tolist()
    rest: Word = ()
    for f in trees.face_order[::-1].tolist():
        around = [words[f], words[m + f], words[2 * m + f]]
        open_sides = [k for k in range(3) if around[k] is None]
        k = open_sides[0] if open_sides else 2
        one, other = around[k - 2], around[k - 1]
        assert one is not None, "all faces beyond this one are done"
        assert other is not None, "all faces beyond this one are done"
        beyond = shorten(one + other)
        if open_sides:
            words[k * m + f], words[opposite[k * m + f]] = inverse(beyond), beyond
        else:
            last = around[2]
            assert last is not None
            rest = shorten(beyond + last)
    return [word for word in words if word is not None], rest


@njit(cache=True, error_model="numpy")
def _ring_elements(faces, elements, ring, degree, tables):
    across = np.zeros(ring.shape, np.int64)
    for f in range(len(faces)):
        for k in range(3):
            v, w = faces[f, k], faces[f, (k + 1) % 3]
            step = product(tables, -elements[f, k], elements[f, (k + 1) % 3])
            across[v, place_in_ring(ring, degree, v, w)] = step
    return across


@njit(cache=True, error_model="numpy")
def _pull(points, ring, across, degree, matrices, rounds, enough):
    """Each vertex to the mean of its neighbours, in turn, until none moves."""
    mean = np.empty(3)
    for _ in range(rounds):
        moved = 0.0
        for v in range(len(points)):
            mean[:] = 0.0
            for j in range(degree[v]):
                x, y, z = points[ring[v, j]]
                x, y, z = carry(matrices, across[v, j], x, y, z)
                mean[0] += x
                mean[1] += y
                mean[2] += z
            onto_domain(mean, -1.0)
            for d in range(3):
                moved = max(moved, abs(mean[d] - points[v, d]))
            points[v] = mean
        if moved < enough:
            break


@njit(cache=True, error_model="numpy")
def _energy(points, ring, across, degree, matrices):
    energy = 0.0
    for v in range(len(points)):
        for j in range(degree[v]):
            x, y, z = points[ring[v, j]]
            x, y, z = carry(matrices, across[v, j], x, y, z)
            energy += points[v, 2] * z - points[v, 0] * x - points[v, 1] * y - 1.0
    return energy / 2
