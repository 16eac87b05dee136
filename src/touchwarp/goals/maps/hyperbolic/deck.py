"""The deck group of the hyperbolic plane over a closed surface, as Lorentz matrices.

A point of the plane is (x, y, z) with z² − x² − y² = 1, z > 0; the matrices keep that form. Those
of the canonical loops pair the sides of a regular 4g-gon about (0, 0, 1), each side with the one
that the canonical word asks for. The plane's curvature is −1 and the surface's area 4π (g − 1).

Elements are numbered as they occur; −e is the inverse of e, and 0 the identity. Kernels take
`deck.tables`.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.maps.hyperbolic.words import Word, canonical_word

Float = NDArray[np.float64]
METRIC = np.diag([1.0, 1.0, -1.0])
MOST_ELEMENTS = 2000
"""A layout takes 30 to 200."""
SAME = 0.5
"""Two elements whose images of (0, 0, 1) are nearer than this are the same."""


class Deck:
    """The deck group of genus g ≥ 2; it grows as products are asked for.

    Attributes:
        genus: of the surface.
        area: of the surface.
        letters: (4g,) the elements of the letters 1, −1, 2, −2, …
        tables: (matrices (k, 3, 3), homology (k, 2g), products, count), for kernels.
    """

    def __init__(self, genus: int, most: int = MOST_ELEMENTS) -> None:
        self.genus = genus
        self.area = 4 * np.pi * (genus - 1)
        letters = 2 * genus
        matrices = np.zeros((most + 1, 3, 3))
        homology = np.zeros((most + 1, letters), np.int64)
        matrices[0] = np.eye(3)
        matrices[1 : letters + 1] = polygon_generators(canonical_word(genus))
        homology[1 : letters + 1] = np.eye(letters, dtype=np.int64)
        unknown = np.zeros((2 * most + 1, 2 * most + 1), np.int32)
        self.tables = (matrices, homology, unknown, np.array([letters]))
        self.letters = np.array([s * k for k in range(1, letters + 1) for s in (1, -1)])

    def element(self, word: Word) -> int:
        """The element of a word in canonical letters."""
        found = 0
        for letter in word:
            found = int(product(self.tables, found, letter))
        return found

    def pairings(self) -> Float:
        """(4g, 3, 3): the matrices of `letters`."""
        return np.stack([matrix_of(self.tables, int(e)) for e in self.letters])


def polygon_generators(word: Word) -> Float:
    """(2g, 3, 3): for each letter k > 0, what takes the plane along side k of the regular 4g-gon.

    Args:
        word: a relator of one vertex; its sides, counter-clockwise.
    """
    count = len(word)
    after = {letter: -word[k - 1] for k, letter in enumerate(word)}
    angle, letter = {}, word[0]
    for k in range(count):
        angle[letter] = 2 * np.pi * k / count
        letter = after[letter]
    assert len(angle) == count, "all corners of the polygon are one vertex"
    side = 2 * np.arccosh(1 / np.tan(np.pi / count))
    c, s = np.cosh(side), np.sinh(side)
    along = np.array([[c, 0, s], [0, 1, 0], [s, 0, c]])
    return np.stack(
        [_turn(angle[k]) @ along @ _turn(np.pi - angle[-k]) for k in range(1, count // 2 + 1)]
    )


def evaluate(word: Iterable[int], generators: Float) -> Float:
    """(3, 3): the matrix of a word; generators (2g, 3, 3) of the letters 1 … 2g."""
    matrix = np.eye(3)
    for letter in word:
        step = generators[abs(letter) - 1]
        matrix = matrix @ (step if letter > 0 else METRIC @ step.T @ METRIC)
    return matrix


def _turn(angle: float) -> Float:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


@njit(cache=True, error_model="numpy")
def matrix_of(tables, element):
    """(3, 3): an element's matrix; the inverse of M is G Mᵀ G, G = diag(1, 1, −1)."""
    return _matrix(tables[0], element)


@njit(cache=True, error_model="numpy")
def _matrix(matrices, element):
    matrix = matrices[abs(element)].copy()
    if element < 0:
        matrix = matrix.T.copy()
        matrix[0, 2], matrix[1, 2] = -matrix[0, 2], -matrix[1, 2]
        matrix[2, 0], matrix[2, 1] = -matrix[2, 0], -matrix[2, 1]
    return matrix


@njit(cache=True, error_model="numpy")
def homology_of(tables, element):
    """(2g,): how often the letters occur in an element, inverses counted negative."""
    return tables[1][abs(element)] * np.sign(element)


@njit(cache=True, error_model="numpy")
def carry(matrices, element, x, y, z):
    """A point (x, y, z) under an element; matrices (k, 3, 3) of the elements that are ≥ 0."""
    if element == 0:
        return x, y, z
    m = matrices[abs(element)]
    if element > 0:
        return (
            m[0, 0] * x + m[0, 1] * y + m[0, 2] * z,
            m[1, 0] * x + m[1, 1] * y + m[1, 2] * z,
            m[2, 0] * x + m[2, 1] * y + m[2, 2] * z,
        )
    return (
        m[0, 0] * x + m[1, 0] * y - m[2, 0] * z,
        m[0, 1] * x + m[1, 1] * y - m[2, 1] * z,
        -m[0, 2] * x - m[1, 2] * y + m[2, 2] * z,
    )


@njit(cache=True, error_model="numpy")
def product(tables, a, b):
    """The element a·b: first b, then a.

    Raises:
        GoalError: there are more elements than the tables hold.
    """
    if a == 0:
        return b
    if b == 0:
        return a
    if a == -b:
        return 0
    matrices, homology, products, count = tables
    most = len(matrices) - 1
    known = products[a + most, b + most]
    if known != 0:
        return known
    matrix = matrix_of(tables, a) @ matrix_of(tables, b)
    found = 0
    x, y = matrix[0, 2], matrix[1, 2]
    for e in range(1, count[0] + 1):
        m = matrices[e]
        if abs(m[0, 2] - x) + abs(m[1, 2] - y) < SAME:
            found = e
            break
        if abs(m[2, 0] + x) + abs(m[2, 1] + y) < SAME:
            found = -e
            break
    if found == 0:
        if count[0] == most:
            raise GoalError(
                "maps between the prop and the virtual object wind about their handles more often "
                "than the tables of the hyperbolic plane hold; remesh both to even triangles."
            )
        count[0] += 1
        found = count[0]
        matrices[found] = _in_letters(matrix, matrices, homology.shape[1])
        homology[found] = homology_of(tables, a) + homology_of(tables, b)
    products[a + most, b + most] = found
    return found


@njit(cache=True, error_model="numpy")
def _in_letters(matrix, matrices, letters):
    """An element's matrix as a product of letters, without the rounding of the far ones it is of.

    Always the letter that brings the image of the middle nearest to the middle.
    """
    x, y, z = matrix[0, 2], matrix[1, 2], matrix[2, 2]
    exact = np.eye(3)
    while True:
        best, height = 0, z - 1e-6
        for k in range(1, letters + 1):
            for e in (k, -k):
                _, _, after = carry(matrices, e, x, y, z)
                if after < height:
                    best, height = e, after
        if best == 0:
            return exact
        x, y, z = carry(matrices, best, x, y, z)
        exact = exact @ _matrix(matrices, -best)
