"""Loops that do not shrink on a closed surface, and the integer coordinates that they give it.

Tree and cotree give 2·genus loops and, for each, a closed 1-form of integers on half-edges. On a
torus in space, linking numbers with the loops pushed outward tell the loop through the hole from
the one around the tube, so that two tori get the same basis, up to a turn by 180°.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.maps.closed_mesh import ClosedMesh
from touchwarp.scene.tree_cotree import meeting_paths, tree_cotree

UNSURE = 0.05
"""Linking numbers farther than this from whole ones are those of a surface that crosses itself."""
CROSSES_ITSELF = (
    "the surface crosses itself: its loop through the hole cannot be told from the one around the "
    "tube; `touchwarp repair` makes a clean surface of it."
)


@dataclass(frozen=True, eq=False)
class Generator:
    """One of the 2·genus independent loops, and the 1-form that counts crossings of its dual.

    Attributes:
        loop: vertices in order; the last is joined to the first.
        form: (3m,) int64 on half-edges k·m + f; sums to zero around each face.
    """

    loop: NDArray[np.int64]
    form: NDArray[np.int64]


def find_generators(mesh: ClosedMesh) -> list[Generator]:
    """2·genus loops, short where the mesh allows, with their closed 1-forms."""
    trees = tree_cotree(mesh.vertices, mesh.faces)
    opposite, face = trees.opposite, trees.face
    m = len(mesh.faces)
    between = {
        pair: k for k, pair in enumerate(zip(face.tolist(), face[opposite].tolist(), strict=True))
    }
    generators = []
    for edge in trees.loops:
        left, right = int(face[edge]), int(face[opposite[edge]])
        form = np.zeros(3 * m, dtype=np.int64)
        form[edge] += 1
        form[opposite[edge]] -= 1
        ascent, descent = meeting_paths(trees.face_parent, right, left)
        chain = ascent + descent[-2::-1]
        for one, other in itertools.pairwise(chain):
            crossed = between[one, other]
            form[crossed] += 1
            form[opposite[crossed]] -= 1
        generators.append(Generator(trees.loop(edge), form))
    return generators


def torus_forms(mesh: ClosedMesh) -> NDArray[np.int64]:
    """(3m, 2) closed 1-forms of integers: turns through the hole, and turns around the tube.

    Raises:
        GoalError: the mesh crosses itself so that its loops cannot be told apart.
    """
    generators = find_generators(mesh)
    assert len(generators) == 2, "two generators are those of genus 1"
    measured = pushed_linking(mesh, generators)
    linking = np.rint(measured).astype(np.int64)
    # As (outside, inside) pushes, the matrix is the outer product of two coprime vectors.
    row, column = (int(v) for v in np.argwhere(linking != 0)[0]) if linking.any() else (0, 0)
    divisor = int(np.gcd.reduce(linking[:, column])) or 1
    through = linking[:, column] // divisor
    around = linking[row] // (through[row] or 1)
    turns = through[0] * around[1] - through[1] * around[0]
    if (
        np.abs(measured - linking).max() > UNSURE
        or not np.array_equal(np.outer(through, around), linking)
        or abs(int(turns)) != 1
    ):
        raise GoalError(CROSSES_ITSELF)
    first, second = (g.form for g in generators)
    forms = np.stack(
        [around[0] * first + around[1] * second, through[0] * first + through[1] * second], axis=1
    )
    # Seen from outside, the two must turn counter-clockwise: their integral is ±1.
    m = len(mesh.faces)
    one, other = forms[:m], forms[m : 2 * m]
    if (one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]).sum() < 0:
        forms[:, 0] *= -1
    return forms


def pushed_linking(mesh: ClosedMesh, generators: list[Generator]) -> NDArray[np.float64]:
    """(k, k): linking numbers of loops pushed outward (rows) with loops pushed inward."""
    edges = mesh.vertices[mesh.faces[:, 0]] - mesh.vertices[mesh.faces[:, 1]]
    push = 2e-3 * float(np.linalg.norm(edges, axis=1).mean())
    outer, inner = (
        [mesh.vertices[g.loop] + sign * push * mesh.vertex_normals[g.loop] for g in generators]
        for sign in (1, -1)
    )
    return np.array([[linking_number(a, b) for b in inner] for a in outer])


def linking_number(first: NDArray[np.float64], second: NDArray[np.float64]) -> float:
    """How often two closed polygons (n, 3), (k, 3) wind around each other, by Gauss's integral.

    The solid angle of each pair of segments, as two triangles (van Oosterom and Strackee 1983).
    """
    first_end, second_end = np.roll(first, -1, axis=0), np.roll(second, -1, axis=0)

    def between(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(b[None] - a[:, None])

    a, b = between(first, second), between(first_end, second)
    c, d = between(first_end, second_end), between(first, second_end)
    return float((_solid_angle(a, b, c) + _solid_angle(a, c, d)).sum() / (4 * np.pi))


def handle_places(mesh: ClosedMesh) -> NDArray[np.float64]:
    """(genus, 3) m, scene frame: about where the handles or holes are: centres of short loops."""
    loops = [mesh.vertices[g.loop] for g in find_generators(mesh)]
    lengths = [float(np.linalg.norm(p - np.roll(p, 1, axis=0), axis=1).sum()) for p in loops]
    short = np.argsort(lengths)[: mesh.genus]
    return np.array([loops[k].mean(axis=0) for k in short]).reshape(-1, 3)


def _solid_angle(
    a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]
) -> NDArray[np.float64]:
    la, lb, lc = (np.linalg.norm(v, axis=-1) for v in (a, b, c))
    triple = (a * np.cross(b, c)).sum(axis=-1)
    ab, bc, ca = (a * b).sum(axis=-1), (b * c).sum(axis=-1), (c * a).sum(axis=-1)
    return np.asarray(2 * np.arctan2(triple, la * lb * lc + ab * lc + bc * la + ca * lb))
