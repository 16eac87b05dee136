"""Node values made to agree wherever bricks meet, and to stay so when they are stored as float32.

A *hanging* node lies on the face of a coarser brick and must hold the value that brick gives there:
a mean of up to four of its nodes, which may hang as well. Rounding each value on its own would part
the two sides by a bit or so, 1e-8 m. So values are first rounded to a step coarse enough for every
such mean to be a float32 number: with M = 2^e ≥ max |value| the grain of float32 is 2^(e - 24), and
a tree that needs n binary places below the step is rounded to the step 2^(n + e - 24).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.solve.threads import pool, threads
from touchwarp.warp.bricks import NODES
from touchwarp.warp.hanging import conform
from touchwarp.warp.topology import placement

MOST_BITS = 8
"""Binary places given up at most; trees that halve from one brick to the next need 3 or 4."""

_NODES3 = NODES**3


@dataclass(frozen=True)
class Rounding:
    """What rounding did.

    Attributes:
        step: m (or the unit of the values), what values other than hanging ones are multiples of.
        bits: binary places kept free below the step.
        jump: the greatest difference, in one channel, left between two sides of a face; 0 where
            every mean could be stored exactly.
    """

    step: float
    bits: int
    jump: float


@njit(cache=True, nogil=True)
def _round(values, step):
    # step is a power of two, so this is exact
    per_step = 1.0 / step
    for n in range(len(values)):
        values[n] = np.rint(values[n] * per_step) * step


class Conformer:
    """Makes values agree on one tree of bricks, again and again.

    Args:
        root, child, slot: the index, as in `Bricks`.
        mirrored: the plane z = 0 of the table frame is a sliding plane, not the outer boundary.

    Raises:
        ValueError: the indices form no tree.
    """

    def __init__(
        self,
        root: NDArray[np.int32],
        child: NDArray[np.int32],
        slot: NDArray[np.int32],
        mirrored: bool = False,
    ) -> None:
        where = placement(root, child)
        order = np.argsort(where.level, kind="stable").astype(np.int64)
        rank = np.empty(len(order), np.int32)
        rank[order] = np.arange(len(order), dtype=np.int32)
        starts = np.searchsorted(where.level[order], np.arange(1, where.level.max(initial=0) + 1))
        self._levels = np.split(order, starts)
        open_octants = ((child < 0) << np.arange(8)).sum(axis=1)
        self._tree = (rank, where.level, where.position, root, child, slot, open_octants)
        self._mirrored = mirrored
        self._count = int(slot.max(initial=-1)) + 1
        bits = np.zeros((self._count, _NODES3), np.int8)
        self._run(np.empty((self._count, _NODES3, 0)), bits, False, False)
        self.bits = int(bits.max(initial=0))

    def round(
        self, values: NDArray[np.float64], zero_outside: bool = True
    ) -> tuple[NDArray[np.float32], Rounding]:
        """Values to store: equal wherever bricks share a node, trilinear where nodes hang.

        Args:
            values: (v, 9, 9, 9, C), in C order; working space, changed.
            zero_outside: set u = 0 exactly on the outer border of the root bricks (the identity on
                ∂Ω1), and where `mirrored` the normal channels on the plane.

        Returns:
            (v, 9, 9, 9, C) float32 values and what was done to them.
        """
        channels = values.shape[-1]
        flat = values.reshape(self._count, _NODES3, channels, copy=False)
        if zero_outside and self._mirrored:
            self._zero_normal(values)
        bits = min(self.bits, MOST_BITS)
        most = float(max(values.max(initial=0.0), -values.min(initial=0.0)))
        step = math.ldexp(1.0, math.ceil(math.log2(most)) - 24 + bits) if most > 0.0 else 1.0
        line = flat.reshape(-1, copy=False)
        parts = np.array_split(line, threads())
        list(pool().map(_round, parts, [step] * len(parts)))
        nothing = np.empty((0, _NODES3), np.int8)
        self._run(flat, nothing, zero_outside, True)
        stored = values.astype(np.float32)
        jump = 0.0
        if bits < self.bits:
            jump = self.jump(stored)
        return stored, Rounding(step, bits, jump)

    def jump(self, values: NDArray[np.float32] | NDArray[np.float16]) -> float:
        """The greatest difference, in one channel, between the two sides of any face of a brick.

        On a shared face both sides are bilinear in the finer one's cells, so nodes tell all.
        """
        flat = values.reshape(self._count, _NODES3, values.shape[-1]).astype(np.float64)
        return self._run(flat, np.empty((0, _NODES3), np.int8), False, False)

    def _run(
        self,
        flat: NDArray[np.float64],
        bits: NDArray[np.int8],
        zero_outside: bool,
        change_values: bool,
    ) -> float:
        """`conform` on all levels, one after another; the greatest change."""
        change = 0.0

        def run(part: NDArray[np.int64]) -> float:
            tail = (flat, bits, zero_outside, self._mirrored, change_values)
            return float(conform(part, *self._tree, *tail))

        for bricks in self._levels:
            parts = np.array_split(bricks, min(4 * threads(), 1 + len(bricks) // 32))
            changes = pool().map(run, parts) if len(parts) > 1 else map(run, parts)
            change = max(change, *changes)
        return change

    def _zero_normal(self, values: NDArray[np.float64]) -> None:
        level, position, slot = self._tree[1], self._tree[2], self._tree[5]
        low = slot[(position[:, 2] == 0) & (slot >= 0) & (level >= 0)]
        values[low, :, :, 0, normal_channels(values.shape[-1])] = 0.0


def normal_channels(channels: int) -> slice:
    """Which channels are normal to a sliding plane: u_z, or the second half of the basis lanes."""
    return slice(2, 3) if channels == 3 else slice(channels // 2, None)
