"""Which brick owns a node that several share, and what a node holds that it does not own."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from touchwarp.warp.bricks import CELLS, NODES


@njit(cache=True, nogil=True)
def _neighbours(brick, level, position, root, child, slot, found):
    """The brick in each of 26 directions, as deep as `brick` itself, or the coarser leaf there.

    found: (27,) written: a brick, or -1 outside. Rows are 9·(x + 1) + 3·(y + 1) + z + 1.
    """
    depth = level[brick]
    nx, ny, nz = root.shape
    for x in range(-1, 2):
        for y in range(-1, 2):
            for z in range(-1, 2):
                bx, by, bz = position[brick, 0] + x, position[brick, 1] + y, position[brick, 2] + z
                row = 9 * (x + 1) + 3 * (y + 1) + z + 1
                found[row] = -1
                if bx < 0 or by < 0 or bz < 0:
                    continue
                rx, ry, rz = bx >> depth, by >> depth, bz >> depth
                if rx >= nx or ry >= ny or rz >= nz:
                    continue
                here = root[rx, ry, rz]
                shift = depth
                while here >= 0 and shift > 0:
                    shift -= 1
                    octant = 4 * (bx >> shift & 1) + 2 * (by >> shift & 1) + (bz >> shift & 1)
                    deeper = child[here, octant]
                    if deeper < 0:
                        break
                    here = deeper
                found[row] = here


@njit(cache=True, nogil=True)
def _claims(brick, level, position, rank, slot, mirrored, found, owner, outside, equal):
    """For each kind of node (inner, on a face, an edge, a corner: 27) who may own it.

    owner: written, the coarser brick first in rank, or -1. outside: written, whether nothing lies
    beyond. equal: written, whether a brick of the same level and a lower rank lies beyond.
    """
    for kind in range(27):
        owner[kind], outside[kind], equal[kind] = -1, False, False
        cx, cy, cz = kind // 9 - 1, kind // 3 % 3 - 1, kind % 3 - 1
        for x in range(min(cx, 0), max(cx, 0) + 1):
            for y in range(min(cy, 0), max(cy, 0) + 1):
                for z in range(min(cz, 0), max(cz, 0) + 1):
                    if x == 0 and y == 0 and z == 0:
                        continue
                    other = found[9 * (x + 1) + 3 * (y + 1) + z + 1]
                    if other < 0:
                        under = mirrored and z < 0 and position[brick, 2] == 0
                        outside[kind] = outside[kind] or not under
                    elif level[other] < level[brick]:
                        if owner[kind] < 0 or rank[other] < rank[owner[kind]]:
                            owner[kind] = other
                    elif rank[other] < rank[brick] and slot[other] >= 0:
                        equal[kind] = True


@njit(cache=True, nogil=True)
def _touched(i, j, k):
    """The octants of a brick that touch its node (i, j, k), as bits."""
    half = CELLS // 2
    low = (i <= half) * 0x0F | (i >= half) * 0xF0
    middle = (j <= half) * 0x33 | (j >= half) * 0xCC
    high = (k <= half) * 0x55 | (k >= half) * 0xAA
    return low & middle & high


@njit(cache=True, nogil=True)
def conform(
    part,
    rank,
    level,
    position,
    root,
    child,
    slot,
    open_octants,
    values,
    bits,
    zero_outside,
    mirrored,
    change_values,
):
    """Set every shared node to the value of the brick that owns it; coarse bricks first.

    The owner of a node is the coarsest brick that decides beside it, and of equals the first in
    rank. Where `values` has no channels only `bits` is written: the binary places that each
    node needs below the step. Returns the greatest change.

    Args:
        part: bricks of one level; those of all coarser levels are done. Parts of a level may be
            done at once: a brick writes only nodes that it does not own, and reads only owned ones.
        rank: (b,) a brick's place in order, coarse before fine.
        open_octants: (b,) the octants without a child, as bits.
        values: (v, 729, C) float64, changed in place. bits: (v, 729) int8, changed in place.
        zero_outside: set nodes on the border of the root bricks to 0, but for those of the
            plane z = 0 where `mirrored`.
        change_values: False to measure only.
    """
    found, owners = np.empty(27, np.int32), np.empty(27, np.int32)
    outside, equal = np.empty(27, np.bool_), np.empty(27, np.bool_)
    channels = values.shape[2]
    counting = channels == 0
    change = 0.0
    for brick in part:
        row = slot[brick]
        if row < 0:
            continue
        _neighbours(brick, level, position, root, child, slot, found)
        _claims(brick, level, position, rank, slot, mirrored, found, owners, outside, equal)
        for i in range(NODES):
            x = int(i == CELLS) - int(i == 0)
            for j in range(NODES):
                y = int(j == CELLS) - int(j == 0)
                stride = CELLS if x == 0 and y == 0 else 1
                for k in range(0, NODES, stride):
                    z = int(k == CELLS) - int(k == 0)
                    kind = 9 * (x + 1) + 3 * (y + 1) + z + 1
                    zero = outside[kind] and zero_outside
                    owner = owners[kind]
                    if owner < 0 and not equal[kind] and not zero:
                        continue
                    if open_octants[brick] & _touched(i, j, k) == 0:
                        continue
                    node = i * NODES * NODES + j * NODES + k
                    if zero:
                        for m in range(channels):
                            change = max(change, abs(values[row, node, m]))
                            if change_values:
                                values[row, node, m] = 0.0
                        continue
                    if owner < 0:
                        owner = _equal_owner(
                            brick, i, j, k, x, y, z, level, rank, slot, open_octants, found
                        )
                    if owner == brick:
                        continue
                    base, a, b, c = _place_in(owner, brick, i, j, k, level, position)
                    if counting:
                        bits[row, node] = _places(bits, slot[owner], base, a, b, c)
                        continue
                    moved = _interpolate(
                        values, row, node, slot[owner], base, a, b, c, change_values
                    )
                    change = max(change, moved)
    return change


@njit(cache=True, nogil=True)
def _equal_owner(brick, i, j, k, x, y, z, level, rank, slot, open_octants, found):
    """Of the bricks of one level that decide beside a node, the first in rank."""
    owner = brick
    for dx in range(min(x, 0), max(x, 0) + 1):
        for dy in range(min(y, 0), max(y, 0) + 1):
            for dz in range(min(z, 0), max(z, 0) + 1):
                other = found[9 * (dx + 1) + 3 * (dy + 1) + dz + 1]
                if other < 0 or rank[other] >= rank[owner] or slot[other] < 0:
                    continue
                touched = _touched(i - CELLS * dx, j - CELLS * dy, k - CELLS * dz)
                if open_octants[other] & touched:
                    owner = other
    return owner


@njit(cache=True, nogil=True)
def _place_in(owner, brick, i, j, k, level, position):
    """Where a brick's node lies in a brick of its own level or a coarser one.

    Returns:
        the least node of the owner's cell, and the place in that cell, 0 to 1 along each axis.
    """
    shift = level[brick] - level[owner]
    scale = 1 << shift
    gx = position[brick, 0] * CELLS + i - (position[owner, 0] * CELLS << shift)
    gy = position[brick, 1] * CELLS + j - (position[owner, 1] * CELLS << shift)
    gz = position[brick, 2] * CELLS + k - (position[owner, 2] * CELLS << shift)
    ci, cj = min(gx >> shift, CELLS - 1), min(gy >> shift, CELLS - 1)
    ck = min(gz >> shift, CELLS - 1)
    a, b, c = (gx - ci * scale) / scale, (gy - cj * scale) / scale, (gz - ck * scale) / scale
    return ci * NODES * NODES + cj * NODES + ck, a, b, c


@njit(cache=True, nogil=True)
def _interpolate(values, row, node, source, base, a, b, c, change_values):
    """Set a node to the trilinear value at a place that `_place_in` tells; the greatest change."""
    change = 0.0
    for m in range(values.shape[2]):
        total = 0.0
        for corner in range(8):
            di, dj, dk = corner >> 2, corner >> 1 & 1, corner & 1
            w = (a if di else 1.0 - a) * (b if dj else 1.0 - b) * (c if dk else 1.0 - c)
            if w != 0.0:
                total += w * values[source, base + di * NODES * NODES + dj * NODES + dk, m]
        change = max(change, abs(total - values[row, node, m]))
        if change_values:
            values[row, node, m] = total
    return change


@njit(cache=True, nogil=True)
def _places(bits, source, base, a, b, c):
    """The binary places below the step that a trilinear value needs."""
    need = 0
    for corner in range(8):
        di, dj, dk = corner >> 2, corner >> 1 & 1, corner & 1
        w = (a if di else 1.0 - a) * (b if dj else 1.0 - b) * (c if dk else 1.0 - c)
        if w == 0.0:
            continue
        places = int(bits[source, base + di * NODES * NODES + dj * NODES + dk])
        while w != math.floor(w):
            w *= 2.0
            places += 1
        need = max(need, places)
    return min(need, 100)
