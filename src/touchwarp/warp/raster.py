"""A table of bricks resampled on a regular grid: the paper's lookup table."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.solve.threads import pool, threads
from touchwarp.warp.bricks import CELLS, NODES
from touchwarp.warp.lookup import Lookup, locate

Float = NDArray[np.float64]

_LINE = NODES
_SHEET = NODES * NODES
_BRICK = NODES * NODES * NODES


@dataclass(frozen=True, eq=False)
class RegularTable:
    """Displacement on a regular grid, first and last nodes on the faces of the box.

    Attributes:
        origin: (3,) m, the node [0, 0, 0].
        spacing: (3,) m between nodes.
        displacement: (nx, ny, nz, 3) float64 m at origin + [i, j, k] · spacing.
    """

    origin: Float
    spacing: Float
    displacement: Float


@njit(cache=True, nogil=True, error_model="numpy")
def rasterise(xs, ys, zs, width, root, child, slot, values, out):
    """u at the points of a grid along the table's axes, one column in z after another.

    Within a brick the column's four weights stay, so a point costs two of eight nodes.

    Args:
        xs, ys, zs: m, table frame, zs ascending.
        values: (v · 729 · 3,) float32. out: (nx, ny, nz, 3), written.
    """
    line, sheet = _LINE * 3, _SHEET * 3
    low, high = np.empty(3), np.empty(3)
    for i in range(len(xs)):
        for j in range(len(ys)):
            k = 0
            while k < len(zs):
                brick, level, a, b, c = locate(xs[i], ys[j], zs[k], width, root, child)
                if brick < 0:
                    out[i, j, k, 0] = out[i, j, k, 1] = out[i, j, k, 2] = 0.0
                    k += 1
                    continue
                a, b = a * CELLS, b * CELLS
                ci, cj = min(int(a), CELLS - 1), min(int(b), CELLS - 1)
                a, b = a - ci, b - cj
                w00, w01, w10, w11 = (1.0 - a) * (1.0 - b), (1.0 - a) * b, a * (1.0 - b), a * b
                base = (np.int64(slot[brick]) * _BRICK + ci * _SHEET + cj * _LINE) * 3
                per_metre = 2.0**level / width[2]
                start, c0 = zs[k], c
                # a deeper brick may begin in the other half
                end = 0.5 if c < 0.5 else 1.0
                last = -1
                while True:
                    c *= CELLS
                    ck = min(int(c), CELLS - 1)
                    w = c - ck
                    if ck != last:
                        for d in range(3):
                            at = base + 3 * ck + d
                            low[d] = w00 * np.float64(values[at])
                            low[d] += w01 * np.float64(values[at + line])
                            low[d] += w10 * np.float64(values[at + sheet])
                            low[d] += w11 * np.float64(values[at + sheet + line])
                            high[d] = w00 * np.float64(values[at + 3])
                            high[d] += w01 * np.float64(values[at + 3 + line])
                            high[d] += w10 * np.float64(values[at + 3 + sheet])
                            high[d] += w11 * np.float64(values[at + 3 + sheet + line])
                        last = ck
                    for d in range(3):
                        out[i, j, k, d] = (1.0 - w) * low[d] + w * high[d]
                    k += 1
                    if k == len(zs):
                        break
                    c = c0 + (zs[k] - start) * per_metre
                    if c >= end:
                        break


def rasterised(lookup: Lookup, xs: Float, ys: Float, zs: Float) -> Float:
    """(nx, ny, nz, 3) m, table axes: u on a grid along the table's axes.

    Args:
        xs, ys, zs: m, table frame, zs ascending.
    """
    out = np.empty((len(xs), len(ys), len(zs), 3))
    width, depth = lookup.frame[12:15].copy(), lookup.frame[15]
    under = int(np.searchsorted(zs, 0.0)) if depth > 0.0 else 0
    table = (width, lookup.root, lookup.child, lookup.slot, lookup.values)

    def fill(a: int, b: int) -> None:
        part = out[a:b]
        rasterise(xs[a:b], ys, zs[under:], *table, part[:, :, under:])
        if under:
            down = np.ascontiguousarray(-zs[:under][::-1])
            mirrored = np.empty((b - a, len(ys), under, 3))
            rasterise(xs[a:b], ys, down, *table, mirrored)
            fade = np.maximum(1.0 - down / depth, 0.0)[:, None] * [1.0, 1.0, -1.0]
            part[:, :, :under] = (mirrored * fade)[:, :, ::-1]

    bounds = np.linspace(0, len(xs), min(len(xs), 4 * threads()) + 1).astype(int)
    tasks = [pool().submit(fill, a, b) for a, b in pairwise(bounds)]
    for task in tasks:
        task.result()
    return out
