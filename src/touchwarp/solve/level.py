"""One level of the grid: its bricks, its nodes, who neighbours whom.

A level is a set of bricks of 8³ cells. Its nodes are the corners of those cells, each once. A node
is *inner* when all eight cells around it are there (a cell under a sliding plane counts as its
mirror image), and on the *rim* otherwise: on the outer box, or on the interface to the coarser
level. Inner red nodes come first, then inner black ones, then the rim, each brick by brick.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.solve.frame import CELLS
from touchwarp.solve.threads import share

LOCAL = CELLS**3


FLOOR = 27
"""Column of `Level.around` that tells whether a brick stands on a sliding plane."""


class Places(NamedTuple):
    """What compiled loops need of a level; see `Level`.

    Loops take its arrays out once, before they start: to take one costs as much as a lookup.
    """

    bricks: NDArray[np.int32]
    around: NDArray[np.int32]
    parent: NDArray[np.int32]
    node: NDArray[np.int32]
    site: NDArray[np.int32]
    n_inner: int


@dataclass(eq=False)
class Level:
    """Topology of one level.

    Attributes:
        depth: level number; 0 is the root grid, negative ones are its coarsenings.
        cells: (3,) cells the whole box would have at this depth.
        bricks: (b, 3) int32, brick coordinates, sorted; those that have cells, and those that only
            hold nodes on upper faces.
        has_cells: (b,) bool.
        around: (b, 28) int32, the bricks around each, index 9(dx+1) + 3(dy+1) + (dz+1), or -1; and
            1 where a brick stands on a sliding plane.
        parent: (b,) int32, the coarser level's brick that holds each, or -1 on the coarsest.
        node_of_site: (512 (b + 1),) int32, the node at each site 512 · brick + 64x + 8y + z, or -1;
            the last 512 are those of the bricks that are not there.
        site: (n,) int32 of each node.
        n_red, n_inner, n: the counts.
        mirrored: the floor is a sliding plane.
    """

    depth: int
    cells: NDArray[np.int64]
    bricks: NDArray[np.int32]
    has_cells: NDArray[np.bool_]
    around: NDArray[np.int32]
    parent: NDArray[np.int32]
    node_of_site: NDArray[np.int32]
    site: NDArray[np.int32]
    n_red: int
    n_inner: int
    n: int
    mirrored: bool

    @property
    def places(self) -> Places:
        """The level for compiled loops."""
        return Places(
            self.bricks, self.around, self.parent, self.node_of_site, self.site, self.n_inner
        )

    @property
    def node(self) -> NDArray[np.int32]:
        """(b, 512) nodes by brick."""
        return self.node_of_site[:-LOCAL].reshape(-1, LOCAL)

    def coordinates(self, nodes: NDArray[np.integer] | slice = slice(None)) -> NDArray[np.int64]:
        """(k, 3) int64, the coordinates of nodes (all without it) in this level's cells."""
        site = self.site[nodes]
        result: NDArray[np.int64] = self.bricks[site >> 9].astype(np.int64) * CELLS
        for axis, shift in enumerate((6, 3, 0)):
            result[:, axis] += (site >> shift) & 7
        return result

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
    return _kinds(level.bricks, present, level.around, level.cells)[0]


def _kinds(
    bricks: NDArray[np.int32],
    present: NDArray[np.bool_],
    around: NDArray[np.int32],
    cells: NDArray[np.int64],
) -> tuple[NDArray[np.int8], NDArray[np.int64]]:
    """(b, 512) as `node_kinds`, and how many of each kind a brick has, (b, 3)."""
    kind = np.zeros((len(bricks), LOCAL), np.int8)
    counts = np.zeros((len(bricks), 3), np.int64)
    share(_classify, len(bricks), bricks, present, around, cells, kind, counts, work=LOCAL)
    return kind, counts


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
    around = np.empty((len(keys), 28), np.int32)
    for i, offset in enumerate(OFFSETS):
        there = bricks + offset
        inside = ((there >= 0) & (there < shape)).all(axis=1)
        around[:, i] = np.where(inside, _find(keys, _key(there, shape)), -1)
    around[:, FLOOR] = mirrored & (bricks[:, 2] == 0)
    parent = np.full(len(keys), -1, np.int32)
    if coarser is not None:
        parent[:] = coarser.index_of(bricks // 2)
    bricks = bricks.astype(np.int32)
    kind, counts = _kinds(bricks, has_cells, around, cells)
    ends = np.cumsum(counts.T.ravel()).reshape(3, -1)
    n_red, n_inner, n = (int(end) for end in ends[:, -1])
    node = np.full(LOCAL * (len(keys) + 1), -1, np.int32)
    site = np.empty(n, np.int32)
    share(_number, len(keys), kind, (ends - counts.T).T.copy(), node, site, work=LOCAL)
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
        mirrored,
    )


@njit(cache=True, nogil=True)
def node_at(node, around, brick, x, y, z):
    """The node at coordinates x, y, z relative to a brick, each in -8..15, or -1.

    Under a sliding plane that is the mirror image. There are no branches, which would keep the
    compiler from putting this into the loops that call it.
    """
    z -= 2 * z * (around[brick, FLOOR] & (z < 0))
    there = np.int64(around[brick, 13 + 9 * (x >> 3) + 3 * (y >> 3) + (z >> 3)])
    # a brick that is not there, -1, is the array's last
    return node[512 * there + 64 * (x & 7) + 8 * (y & 7) + (z & 7)]


@njit(cache=True, nogil=True)
def beside(node, around, site, d):
    """The neighbour of the node at a site in direction d: 0..5 for x-, x+, y-, y+, z-, z+."""
    x = ((site >> 6) & 7) + (d == 1) - (d == 0)
    y = ((site >> 3) & 7) + (d == 3) - (d == 2)
    z = (site & 7) + (d == 5) - (d == 4)
    z -= 2 * z * (around[site >> 9, FLOOR] & (z < 0))
    there = np.int64(around[site >> 9, 13 + 9 * (x >> 3) + 3 * (y >> 3) + (z >> 3)])
    return node[512 * there + 64 * (x & 7) + 8 * (y & 7) + (z & 7)]


@njit(cache=True, nogil=True)
def octant_start(bricks, brick):
    """Where, in the sites of the brick that holds it, a brick starts."""
    return 256 * (bricks[brick, 0] & 1) + 32 * (bricks[brick, 1] & 1) + 4 * (bricks[brick, 2] & 1)


@njit(cache=True, nogil=True)
def _classify(first, last, bricks, has_cells, around, cells, kind, counts):
    inside = np.empty((8, 3), np.int64)
    for b in range(first, last):
        floor = around[b, FLOOR] == 1
        for axis in range(3):
            for at in range(8):
                # a cell beyond the box's upper faces is none
                inside[at, axis] = 8 * bricks[b, axis] + at < cells[axis]
        for local in range(512):
            x, y, z = local >> 6, (local >> 3) & 7, local & 7
            present = 0
            for side in range(8):
                cx, cy, cz = x - (side >> 2), y - (side >> 1 & 1), z - (side & 1)
                if cz < 0 and floor:
                    cz = 0
                there = around[b, 13 + 9 * (cx >> 3) + 3 * (cy >> 3) + (cz >> 3)]
                if there >= 0 and has_cells[there]:
                    own = (cx < 0 or inside[cx, 0]) and (cy < 0 or inside[cy, 1])
                    present += own and (cz < 0 or inside[cz, 2])
            if present > 0:
                colour = 1 + ((x + y + z) & 1) if present == 8 else 3
                kind[b, local] = colour
                counts[b, colour - 1] += 1


@njit(cache=True, nogil=True)
def _number(first, last, kind, starts, node, site):
    for b in range(first, last):
        for i in range(512):
            k = kind[b, i]
            if k > 0:
                m = starts[b, k - 1]
                starts[b, k - 1] += 1
                node[512 * b + i] = m
                site[m] = 512 * b + i
