"""Which loops of a surface in space are the canonical ones, so that two surfaces get the same.

A surface bounds an inside and an outside. The Seifert form V, linking numbers of loops pushed
outward with loops pushed inward, tells what each loop runs round and through, in homology. The
canonical loops are those in which it is [[0, 1], [0, 0]] for each handle, as on a torus; of these,
those whose springs are laxest.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.maps.closed_mesh import ClosedMesh
from touchwarp.goals.maps.homology import CROSSES_ITSELF, UNSURE, find_generators, pushed_linking
from touchwarp.goals.maps.hyperbolic.coarsened import Coarsened
from touchwarp.goals.maps.hyperbolic.deck import Deck, homology_of, product
from touchwarp.goals.maps.hyperbolic.layout import HyperbolicLayout
from touchwarp.goals.maps.hyperbolic.mapping_classes import near_moves, twists
from touchwarp.goals.maps.hyperbolic.springs import Springs
from touchwarp.goals.maps.hyperbolic.words import Images, Word, homology_matrix, to_canonical

Int = NDArray[np.int64]

COARSE = 120
"""Vertices that a mesh is taken down to; `COARSE_PER_HANDLE` for each handle where that is more."""
COARSE_PER_HANDLE = 50
ROOTS = 12
"""Vertices from which loops are cut; the laxest springs of all are taken."""
MOST_FORMS = 100_000


@dataclass(frozen=True, eq=False)
class Marking:
    """A mesh with canonical loops.

    Attributes:
        coarsened: the mesh, taken apart.
        springs: of its coarse mesh.
        images: of the letters of the springs' loops, in canonical letters.
    """

    coarsened: Coarsened
    springs: Springs
    images: dict[int, Word]

    def lay_coarse(self, images: Images, deck: Deck) -> HyperbolicLayout:
        """The coarse mesh in a class, every vertex in the polygon about the middle."""
        return self.springs.lay_out(images, deck)


def find_marking(mesh: ClosedMesh) -> Marking:
    """The canonical loops of a mesh of genus 2 or more.

    Raises:
        GoalError: a vertex has too many neighbours, or the surface crosses itself.
    """
    genus = mesh.genus
    coarsened = Coarsened(mesh, max(COARSE, COARSE_PER_HANDLE * genus))
    moves = twists(genus)
    best: tuple[float, Springs, dict[int, Word]] | None = None
    roots = np.linspace(0, len(coarsened.coarse.vertices) - 1, ROOTS).astype(int)
    for root in np.unique(roots).tolist():
        springs = Springs(coarsened.coarse, root)
        energy, images = springs.descend(to_canonical(springs.relator), moves)
        if best is None or energy < best[0]:
            best = (energy, springs, images)
    assert best is not None
    _, springs, images = best
    form = seifert_form(coarsened, springs, images)
    for name in twists_to_standard(form):
        images = springs.moved(images, moves[name])
    _, images = springs.descend(images, near_moves(genus))
    return Marking(coarsened, springs, images)


def seifert_form(coarsened: Coarsened, springs: Springs, images: Images) -> Int:
    """(2g, 2g): linking numbers of the canonical loops, pushed outward (rows) and inward.

    Raises:
        GoalError: the surface crosses itself.
    """
    mesh = coarsened.mesh
    layout = springs.lay_out(images, Deck(mesh.genus))
    grown = coarsened.regrow(layout)
    grown.return_unplaced()
    generators = find_generators(mesh)
    across = _homology_across(grown.elements(), layout.deck.tables).reshape(-1, 2 * mesh.genus)
    start, end = mesh.faces.T.ravel(), mesh.faces[:, [1, 2, 0]].T.ravel()
    keys = start * len(mesh.vertices) + end
    order = np.argsort(keys)
    classes = np.empty((2 * mesh.genus, 2 * mesh.genus))
    for column, generator in enumerate(generators):
        steps = generator.loop * len(mesh.vertices) + np.roll(generator.loop, -1)
        rows = order[np.searchsorted(keys[order], steps)]
        classes[:, column] = across[rows].sum(axis=0)
    measured = pushed_linking(mesh, generators)
    if np.abs(measured - np.rint(measured)).max() > UNSURE:
        raise GoalError(CROSSES_ITSELF)
    in_canonical = np.linalg.inv(classes)
    return np.rint(in_canonical.T @ np.rint(measured) @ in_canonical).astype(np.int64)


def twists_to_standard(form: Int) -> list[str]:
    """Names of twists, the first first, after which a Seifert form is standard; found best first.

    Raises:
        GoalError: none were found: the form is not that of a surface that bounds an inside.
    """
    genus = len(form) // 2
    wanted = np.kron(np.eye(genus, dtype=np.int64), np.array([[0, 1], [0, 0]]))
    changes = {
        name: np.rint(np.linalg.inv(homology_matrix(move))).astype(np.int64)
        for name, move in twists(genus).items()
        if name[0] in "ABC"
    }
    queue: list[tuple[float, int, Int, list[str]]] = [(0.0, 0, form, [])]
    seen = {form.tobytes()}
    while queue and len(seen) < MOST_FORMS:
        _, _, form, names = heapq.heappop(queue)
        if (form == wanted).all():
            return names
        for name, change in changes.items():
            after = change.T @ form @ change
            if after.tobytes() not in seen:
                seen.add(after.tobytes())
                cost = float(np.abs(after - wanted).sum()) + 0.5 * (len(names) + 1)
                heapq.heappush(queue, (cost, len(seen), after, [*names, name]))
    raise GoalError(CROSSES_ITSELF)


@njit(cache=True, error_model="numpy")
def _homology_across(elements, tables):
    """(3, m, 2g): of the element that takes corner k + 1 to the side of corner k."""
    across = np.zeros((3, len(elements), tables[1].shape[1]), np.int64)
    for f in range(len(elements)):
        for k in range(3):
            element = product(tables, -elements[f, k], elements[f, (k + 1) % 3])
            across[k, f] = homology_of(tables, element)
    return across
