"""Where bricks meet: their faces and edges, and the values on either side.

At a point on a face two bricks (of one level or of two) both have a value, on an edge up to four;
f is continuous if they agree. The places within bricks are exact in binary arithmetic, so what
differs is the table.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from touchwarp.warp.bricks import CELLS, Bricks
from touchwarp.warp.topology import placement

Float = NDArray[np.float64]
Int = NDArray[np.int64]

_EVERY_SIDE = tuple(product((0, 1), repeat=3))

_PART = 1 << 17
"""Points handled at a time."""


def cell_sides(bricks: Bricks, points: Float) -> Float:
    """(n, 3) m: the sides of the cells that decide at (n, 3) points, scene frame.

    Outside the table they are those of root bricks.
    """
    T = bricks.T_scene_table
    local = (points - T[:3, 3]) @ T[:3, :3]
    if bricks.mirror_depth is not None:
        local[:, 2] = np.abs(local[:, 2])
    _, level, _ = _locate(bricks, local / (bricks.spacing * CELLS), (1, 1, 1))
    sides: Float = bricks.spacing * 0.5 ** level[:, None]
    return sides


def nodes_beyond(bricks: Bricks, length: float) -> Float:
    """(n, 3) m, scene frame: the nodes whose stored |u| is greater than `length`."""
    squares = np.einsum("...c,...c->...", bricks.values, bricks.values, dtype=np.float64)
    row, *node = np.nonzero(~(squares <= length**2))
    brick_of = np.empty(len(bricks.values), np.int64)
    held = np.flatnonzero(bricks.slot >= 0)
    brick_of[bricks.slot[held]] = held
    level, position = placement(bricks.root, bricks.child)
    brick = brick_of[row]
    place = (position[brick] + np.stack(node, axis=1) / CELLS) * 0.5 ** level[brick, None]
    return _in_scene(bricks, place)


def jumps(
    bricks: Bricks, per_face: int, most: int, rng: np.random.Generator
) -> tuple[Float, Float, int]:
    """How far the values on either side of bricks' faces lie apart.

    Args:
        bricks: with three channels.
        per_face: points on each face, as many on lines between its nodes, as many on its edges.
        most: points at most; above it a seeded choice of bricks is tried.
        rng: where the points come from.

    Returns:
        Jumps (n,) m, the points (n, 3) m, scene frame, and the number of bricks tried.
    """
    level, position = placement(bricks.root, bricks.child)
    leaf = np.flatnonzero(bricks.slot >= 0)
    count = max(1, most // (18 * per_face))
    if len(leaf) > count:
        leaf = np.sort(rng.choice(leaf, count, replace=False))
    places, found = [], []
    for axis, upper in product(range(3), (0, 1)):
        for kind in ("face", "line", "edge"):
            t = rng.random((len(leaf), per_face, 3))
            ties = [axis]
            other = (axis + 1) % 3
            if kind == "line":
                t[..., other] = np.floor(t[..., other] * (CELLS + 1)) / CELLS
            elif kind == "edge":
                t[..., other] = np.floor(2.0 * t[..., other])
                ties.append(other)
            t[..., axis] = upper
            place = (position[leaf, None, :] + t) * 0.5 ** level[leaf, None, None]
            # a line's ends lie on edges, so that there every brick is asked
            places.append(place.reshape(-1, 3))
            found.append(_spread(bricks, places[-1], ties if kind != "line" else [axis, other]))
    place = np.concatenate(places)
    return np.concatenate(found), _in_scene(bricks, place), len(leaf)


def _spread(bricks: Bricks, place: Float, ties: list[int]) -> Float:
    """(n,) m: greatest difference among the bricks that touch each place, along the axes `ties`."""
    parts = [np.zeros(0)]
    for start in range(0, len(place), _PART):
        part = place[start : start + _PART]
        low, high = np.full(part.shape, np.inf), np.full(part.shape, -np.inf)
        for sides in _EVERY_SIDE:
            if all(sides[axis] or axis in ties for axis in range(3)):
                u = _one_sided(bricks, part, sides)
                # unlike fmin and fmax these let a NaN through
                low, high = np.minimum(low, u), np.maximum(high, u)
        parts.append(np.linalg.norm(high - low, axis=1))
    spread = np.concatenate(parts)
    return np.where(np.isfinite(spread), spread, np.inf)


def _one_sided(bricks: Bricks, place: Float, sides: tuple[int, ...]) -> Float:
    """u (n, 3) m in table axes at places in root bricks, ties towards `sides` (0 low, 1 high)."""
    turn = np.ones(place.shape)
    if bricks.mirror_depth is not None:
        under = (place[:, 2] < 0.0) | ((place[:, 2] == 0.0) & (sides[2] == 0))
        turn[under, 2] = -1.0
        place = np.concatenate([place[:, :2], np.abs(place[:, 2:])], axis=1)
        # from just under the mirror one looks at what is just above it
        above, _, inside = _locate(bricks, place, (sides[0], sides[1], 1))
        below, _, inside_below = _locate(bricks, place, sides)
        at_mirror = place[:, 2] == 0.0
        brick = np.where(at_mirror, above, below)
        inside = np.where(at_mirror[:, None], inside, inside_below)
    else:
        brick, _, inside = _locate(bricks, place, sides)
    found = brick >= 0
    u = np.zeros(place.shape)
    row, spot = bricks.slot[brick[found]], inside[found] * CELLS
    cell = np.minimum(spot.astype(np.int64), CELLS - 1)
    spot -= cell
    total = np.zeros((len(row), 3))
    for corner in _EVERY_SIDE:
        weight = np.prod(np.where(corner, spot, 1.0 - spot), axis=1)
        i, j, k = (cell + corner).T
        total += weight[:, None] * bricks.values[row, i, j, k].astype(np.float64)
    u[found] = total
    return u * turn


def _locate(bricks: Bricks, place: Float, sides: tuple[int, ...]) -> tuple[Int, Int, Float]:
    """The deepest brick at each place (-1 for none), its level, and the place in it, 0 to 1."""
    tie = np.asarray(sides) == 0
    index = np.floor(place).astype(np.int64)
    index -= (index == place) & tie
    within = ((index >= 0) & (index < bricks.root.shape)).all(axis=1)
    brick = np.full(len(place), -1, np.int64)
    brick[within] = bricks.root[tuple(index[within].T)]
    inside = place - index
    level = np.zeros(len(place), np.int64)
    going = np.flatnonzero(brick >= 0)
    while len(going):
        half = (inside[going] > 0.5) | ((inside[going] == 0.5) & ~tie)
        octant = half @ np.array([4, 2, 1])
        deeper = bricks.child[brick[going], octant]
        there = deeper >= 0
        going, half = going[there], half[there]
        brick[going] = deeper[there]
        inside[going] = 2.0 * inside[going] - half
        level[going] += 1
    return brick, level, inside


def _in_scene(bricks: Bricks, place: Float) -> Float:
    """Places in root bricks as points (n, 3) m, scene frame."""
    T = bricks.T_scene_table
    points: Float = (place * (bricks.spacing * CELLS)) @ T[:3, :3].T + T[:3, 3]
    return points
