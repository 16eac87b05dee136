"""One level of the grid: its bricks, its nodes, who neighbours whom.

A level is a set of bricks of 8³ cells. Its nodes are the corners of those cells, each once. A node
is *inner* when all eight cells around it are there (a cell under a sliding plane counts as its
mirror image), and on the *rim* otherwise: on the outer box, or on the interface to the coarser
level. Inner red nodes come first, then inner black ones, then the rim, each brick by brick.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from touchwarp.solve.frame import CELLS

LOCAL = CELLS**3


@dataclass(eq=False)
class Level:
    """Topology of one level.

    Attributes:
        depth: level number; 0 is the root grid, negative ones are its coarsenings.
        cells: (3,) cells the whole box would have at this depth.
        bricks: (b, 3) int32, brick coordinates, sorted; the `n_cell_bricks` that have cells, and
            those that only hold nodes on upper faces.
        has_cells: (b,) bool.
        around: (b, 27) int32, the bricks around each, index 9(dx+1) + 3(dy+1) + (dz+1), or -1.
        parent: (b,) int32, the coarser level's brick that holds each, or -1 on the coarsest.
        node: (b, 512) int32, node numbers by brick and 64x + 8y + z, or -1.
        site: (n,) int32, 512 · brick + 64x + 8y + z of each node.
        n_red, n_inner, n: the counts.
        neighbours: (n_inner, 6) int32, nodes at x-, x+, y-, y+, z-, z+.
        mirrored: the floor is a sliding plane.
    """

    depth: int
    cells: NDArray[np.int64]
    bricks: NDArray[np.int32]
    has_cells: NDArray[np.bool_]
    around: NDArray[np.int32]
    parent: NDArray[np.int32]
    node: NDArray[np.int32]
    site: NDArray[np.int32]
    n_red: int
    n_inner: int
    n: int
    neighbours: NDArray[np.int32]
    mirrored: bool

    def coordinates(self, nodes: NDArray[np.integer] | slice = slice(None)) -> NDArray[np.int64]:
        """(k, 3) int64, the coordinates of nodes (all without it) in this level's cells."""
        brick, local = np.divmod(self.site[nodes], LOCAL)
        offset = np.stack([local // 64, local // 8 % 8, local % 8], axis=1)
        return np.asarray(self.bricks[brick].astype(np.int64) * CELLS + offset)

    def index_of(self, bricks: NDArray[np.int64]) -> NDArray[np.int64]:
        """(k,) positions in `bricks` of brick coordinates (k, 3), or -1."""
        return _find(self._keys(), _key(bricks, self._shape()))

    def _shape(self) -> NDArray[np.int64]:
        return -(-self.cells // CELLS) + 1

    def _keys(self) -> NDArray[np.int64]:
        return _key(self.bricks.astype(np.int64), self._shape())


def node_kinds(level: Level, present: NDArray[np.bool_]) -> NDArray[np.int8]:
    """(b, 512): 0 no node, 1 inner red, 2 inner black, 3 rim, if only the bricks present (b,)
    were."""
    kind = np.zeros((len(level.bricks), LOCAL), np.int8)
    counts = np.zeros((len(level.bricks), 3), np.int64)
    _classify(level.bricks, present, level.around, level.cells, level.mirrored, kind, counts)
    return kind


def _key(bricks: NDArray[np.int64], shape: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.asarray((bricks[:, 0] * shape[1] + bricks[:, 1]) * shape[2] + bricks[:, 2])


def _find(keys: NDArray[np.int64], wanted: NDArray[np.int64]) -> NDArray[np.int64]:
    place = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
    return np.where(keys[place] == wanted, place, -1)


OFFSETS = np.stack(np.meshgrid(*[np.arange(-1, 2)] * 3, indexing="ij"), axis=-1).reshape(27, 3)


def make_level(
    depth: int,
    cells: NDArray[np.int64],
    cell_bricks: NDArray[np.int64],
    coarser: Level | None,
    *,
    mirrored: bool,
) -> Level:
    """The level whose cells are those of the bricks with coordinates `cell_bricks` (b, 3)."""
    shape = -(-cells // CELLS) + 1
    corners = OFFSETS[(OFFSETS >= 0).all(axis=1)]
    keys = np.unique(np.concatenate([_key(cell_bricks + corner, shape) for corner in corners]))
    bricks = np.stack(
        [keys // (shape[1] * shape[2]), keys // shape[2] % shape[1], keys % shape[2]], axis=1
    )
    has_cells = np.zeros(len(keys), bool)
    has_cells[np.searchsorted(keys, _key(cell_bricks, shape))] = True
    around = np.empty((len(keys), 27), np.int32)
    for i, offset in enumerate(OFFSETS):
        there = bricks + offset
        inside = ((there >= 0) & (there < shape)).all(axis=1)
        around[:, i] = np.where(inside, _find(keys, _key(there, shape)), -1)
    parent = np.full(len(keys), -1, np.int32)
    if coarser is not None:
        parent[:] = coarser.index_of(bricks // 2)
    node = np.full((len(keys), LOCAL), -1, np.int32)
    kind = np.zeros((len(keys), LOCAL), np.int8)
    counts = np.zeros((len(keys), 3), np.int64)
    bricks = bricks.astype(np.int32)
    _classify(bricks, has_cells, around, cells, mirrored, kind, counts)
    starts = np.cumsum(counts.T.ravel()).reshape(3, -1)
    n_red, n_inner, n = (int(starts[i, -1]) for i in range(3))
    site = np.empty(n, np.int32)
    _number(kind, (starts - counts.T).T.copy(), node, site)
    neighbours = np.empty((n_inner, 6), np.int32)
    _neighbours(node, site, around, bricks, mirrored, neighbours)
    return Level(
        depth,
        cells,
        bricks,
        has_cells,
        around,
        parent,
        node,
        site,
        n_red,
        n_inner,
        n,
        neighbours,
        mirrored,
    )


@njit(cache=True)
def node_at(node, around, floor, brick, x, y, z):
    """The node at coordinates x, y, z relative to a brick, each in -8..15, or -1."""
    if floor and z < 0:
        z = -z
    step = 13
    if x < 0:
        step -= 9
        x += 8
    elif x > 7:
        step += 9
        x -= 8
    if y < 0:
        step -= 3
        y += 8
    elif y > 7:
        step += 3
        y -= 8
    if z < 0:
        step -= 1
        z += 8
    elif z > 7:
        step += 1
        z -= 8
    there = around[brick, step]
    if there < 0:
        return -1
    return node[there, 64 * x + 8 * y + z]


@njit(cache=True, parallel=True)
def _classify(bricks, has_cells, around, cells, mirrored, kind, counts):
    for b in prange(bricks.shape[0]):
        floor = mirrored and bricks[b, 2] == 0
        for x in range(8):
            for y in range(8):
                for z in range(8):
                    present = 0
                    for side in range(8):
                        cx = x - (side >> 2 & 1)
                        cy = y - (side >> 1 & 1)
                        cz = z - (side & 1)
                        if floor and cz < 0:
                            cz = 0
                        step = 13 - (9 if cx < 0 else 0) - (3 if cy < 0 else 0)
                        step -= 1 if cz < 0 else 0
                        there = around[b, step]
                        if there < 0 or not has_cells[there]:
                            continue
                        if (
                            8 * bricks[b, 0] + cx < cells[0]
                            and 8 * bricks[b, 1] + cy < cells[1]
                            and 8 * bricks[b, 2] + cz < cells[2]
                        ):
                            present += 1
                    if present == 8:
                        colour = 1 + ((x + y + z) & 1)
                    elif present > 0:
                        colour = 3
                    else:
                        continue
                    kind[b, 64 * x + 8 * y + z] = colour
                    counts[b, colour - 1] += 1


@njit(cache=True)
def _number(kind, starts, node, site):
    for b in range(kind.shape[0]):
        for i in range(512):
            k = kind[b, i]
            if k > 0:
                m = starts[b, k - 1]
                starts[b, k - 1] += 1
                node[b, i] = m
                site[m] = 512 * b + i


@njit(cache=True, parallel=True)
def _neighbours(node, site, around, bricks, mirrored, neighbours):
    for m in prange(neighbours.shape[0]):
        b = site[m] // 512
        i = site[m] % 512
        x, y, z = i // 64, i // 8 % 8, i % 8
        floor = mirrored and bricks[b, 2] == 0
        neighbours[m, 0] = node_at(node, around, floor, b, x - 1, y, z)
        neighbours[m, 1] = node_at(node, around, floor, b, x + 1, y, z)
        neighbours[m, 2] = node_at(node, around, floor, b, x, y - 1, z)
        neighbours[m, 3] = node_at(node, around, floor, b, x, y + 1, z)
        neighbours[m, 4] = node_at(node, around, floor, b, x, y, z - 1)
        neighbours[m, 5] = node_at(node, around, floor, b, x, y, z + 1)
