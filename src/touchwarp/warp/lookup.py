"""Reading a table of bricks at points: compiled, in float64, the same for a joint or a million.

Two cells that share a face agree on u there but not on ∂u/∂x: the Jacobian is one-sided. On a face
it is that of the cell on the greater side, in table axes; on the upper faces of the root grid,
where there is no such cell, that of the last one; under a sliding plane, that of the mirrored cell.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from touchwarp.solve.threads import pool, threads
from touchwarp.warp.bricks import CELLS, NODES, Bricks

Float = NDArray[np.float64]

SHARE = 1 << 14
"""Points from which a second thread is worth its start."""

_LINE = NODES
_SHEET = NODES * NODES
_BRICK = NODES * NODES * NODES


@njit(cache=True, nogil=True, error_model="numpy")
def locate(p, q, r, width, root, child):
    """The brick that decides at (p, q, r) m, table frame, and the place in it.

    Returns:
        brick (-1 where there is none), its level, and the place in it, 0 to 1 along each axis.
    """
    a, b, c = p / width[0], q / width[1], r / width[2]
    nx, ny, nz = root.shape
    if not (0.0 <= a <= nx and 0.0 <= b <= ny and 0.0 <= c <= nz):
        return -1, 0, 0.0, 0.0, 0.0
    i, j, k = min(int(a), nx - 1), min(int(b), ny - 1), min(int(c), nz - 1)
    brick = root[i, j, k]
    if brick < 0:
        return -1, 0, 0.0, 0.0, 0.0
    a -= i
    b -= j
    c -= k
    level = 0
    while True:
        a2, b2, c2 = 2.0 * a, 2.0 * b, 2.0 * c
        i, j, k = int(a2 >= 1.0), int(b2 >= 1.0), int(c2 >= 1.0)
        deeper = child[brick, 4 * i + 2 * j + k]
        if deeper < 0:
            return brick, level, a, b, c
        brick = deeper
        level += 1
        # exact in binary arithmetic: neighbours compute the same place from either side
        a, b, c = a2 - i, b2 - j, c2 - k


@njit(cache=True, nogil=True, error_model="numpy")
def evaluate(x, frame, root, child, slot, values, mix, displayed, out, slopes):
    """u, or f where `displayed`, at points; ∂f/∂x too where `slopes` has rows.

    Args:
        x: (n, 3) m, scene frame.
        frame: (16,) rotation table to scene (9), origin (3), root brick widths (3), mirror depth.
        values: (v · 729 · C,) float32, the bricks' values in one row.
        mix: (C, 3): u in table axes is the channels' row times this.
        out: (n, 3), written; slopes: (n, 3, 3), written, or (0, 3, 3).
    """
    R, width, depth = frame[:9].reshape(3, 3), frame[12:15], frame[15]
    channels = mix.shape[0]
    du = np.empty((3, 3))
    for n in range(x.shape[0]):
        px, py, pz = x[n, 0], x[n, 1], x[n, 2]
        dx, dy, dz = px - frame[9], py - frame[10], pz - frame[11]
        tx = R[0, 0] * dx + R[1, 0] * dy + R[2, 0] * dz
        ty = R[0, 1] * dx + R[1, 1] * dy + R[2, 1] * dz
        tz = R[0, 2] * dx + R[1, 2] * dy + R[2, 2] * dz
        fade = 1.0
        turn = 1.0
        if tz < 0.0 and -tz < depth:
            tz = -tz
            fade = 1.0 - tz / depth
            turn = -1.0
        brick, level, a, b, c = locate(tx, ty, tz, width, root, child)
        u0 = u1 = u2 = 0.0
        if brick >= 0:
            a, b, c = a * CELLS, b * CELLS, c * CELLS
            i, j, k = min(int(a), CELLS - 1), min(int(b), CELLS - 1), min(int(c), CELLS - 1)
            a, b, c = a - i, b - j, c - k
            o = 1.0 - c
            base = (np.int64(slot[brick]) * _BRICK + i * _SHEET + j * _LINE + k) * channels
            w00, w01, w10, w11 = (1.0 - a) * (1.0 - b), (1.0 - a) * b, a * (1.0 - b), a * b
            sheet, line = _SHEET * channels, _LINE * channels
            if len(slopes):
                du[:] = 0.0
            for m in range(channels):
                at = base + m
                v000, v001 = np.float64(values[at]), np.float64(values[at + channels])
                v010 = np.float64(values[at + line])
                v011 = np.float64(values[at + line + channels])
                v100 = np.float64(values[at + sheet])
                v101 = np.float64(values[at + sheet + channels])
                v110 = np.float64(values[at + sheet + line])
                v111 = np.float64(values[at + sheet + line + channels])
                e00, e01 = v000 * o + v001 * c, v010 * o + v011 * c
                e10, e11 = v100 * o + v101 * c, v110 * o + v111 * c
                v = w00 * e00 + w01 * e01 + w10 * e10 + w11 * e11
                u0 += v * mix[m, 0]
                u1 += v * mix[m, 1]
                u2 += v * mix[m, 2]
                if len(slopes):
                    sx = (1.0 - b) * (e10 - e00) + b * (e11 - e01)
                    sy = (1.0 - a) * (e01 - e00) + a * (e11 - e10)
                    sz = w00 * (v001 - v000) + w01 * (v011 - v010)
                    sz += w10 * (v101 - v100) + w11 * (v111 - v110)
                    for d in range(3):
                        du[d, 0] += sx * mix[m, d]
                        du[d, 1] += sy * mix[m, d]
                        du[d, 2] += sz * mix[m, d]
            u2 *= turn
        if len(slopes):
            if brick >= 0:
                per = CELLS * 2.0**level
                for d in range(3):
                    sign = turn if d == 2 else 1.0
                    for e in range(3):
                        du[d, e] *= per / width[e] * sign * fade
                if turn < 0.0:
                    du[0, 2] = u0 / depth - du[0, 2]
                    du[1, 2] = u1 / depth - du[1, 2]
                    du[2, 2] = u2 / depth - du[2, 2]
                for d in range(3):
                    for e in range(3):
                        s = 0.0
                        for g in range(3):
                            for h in range(3):
                                s += R[d, g] * du[g, h] * R[e, h]
                        slopes[n, d, e] = s + (1.0 if d == e else 0.0)
            else:
                for d in range(3):
                    for e in range(3):
                        slopes[n, d, e] = 1.0 if d == e else 0.0
        u0, u1, u2 = u0 * fade, u1 * fade, u2 * fade
        out[n, 0] = R[0, 0] * u0 + R[0, 1] * u1 + R[0, 2] * u2
        out[n, 1] = R[1, 0] * u0 + R[1, 1] * u1 + R[1, 2] * u2
        out[n, 2] = R[2, 0] * u0 + R[2, 1] * u1 + R[2, 2] * u2
        if displayed:
            out[n, 0] += px
            out[n, 1] += py
            out[n, 2] += pz
        if math.isnan(px + py + pz) and (math.isnan(px) or math.isnan(py) or math.isnan(pz)):
            out[n] = np.nan
            if len(slopes):
                slopes[n] = np.nan


def rows(x: ArrayLike) -> Float:
    """x as a float64 array whose last axis is 3.

    Raises:
        ValueError: it has another shape.
    """
    points = np.asarray(x, dtype=np.float64)
    if points.ndim == 0 or points.shape[-1] != 3:
        raise ValueError(
            f"Points have shape {points.shape}; (..., 3) is needed: metres in the scene's frame, "
            "one point a row."
        )
    return points


@dataclass(frozen=True, eq=False)
class Lookup:
    """A table of bricks made ready for `evaluate`; re-posing and mixing share its arrays.

    Attributes:
        frame: (16,), see `evaluate`.
        root, child, slot: as in `Bricks`.
        values: (v · 729 · C,) float32.
        mix: (C, 3) float64.
    """

    frame: Float
    root: NDArray[np.int32]
    child: NDArray[np.int32]
    slot: NDArray[np.int32]
    values: NDArray[np.float32]
    mix: Float

    @classmethod
    def of(cls, bricks: Bricks, mix: Float | None = None) -> Lookup:
        """The lookup of bricks; `mix` may be left out where they have the three channels of u.

        Raises:
            ValueError: the bricks have not three channels and no mix is given.
        """
        channels = bricks.values.shape[-1]
        if mix is None:
            if channels != 3:
                raise ValueError(
                    f"A warp's bricks have {channels} channels; the 3 components of u are needed."
                )
            mix = np.eye(3)
        return cls(
            frame=frame_of(bricks),
            root=np.ascontiguousarray(bricks.root, dtype=np.int32),
            child=np.ascontiguousarray(bricks.child, dtype=np.int32),
            slot=np.ascontiguousarray(bricks.slot, dtype=np.int32),
            values=np.ascontiguousarray(bricks.values, dtype=np.float32).reshape(-1),
            mix=np.ascontiguousarray(mix, dtype=np.float64),
        )

    def displacement(self, x: ArrayLike, displayed: bool = False) -> Float:
        """u, or f where `displayed`: (..., 3) m for x (..., 3) m, scene frame."""
        points = rows(x)
        flat = np.ascontiguousarray(points.reshape(-1, 3))
        out = np.empty_like(flat)
        self._run(flat, displayed, out, _NO_SLOPES)
        return out.reshape(points.shape)

    def jacobian(self, x: ArrayLike) -> Float:
        """∂f/∂x: (..., 3, 3) for x (..., 3) m, scene frame; one-sided on faces of cells."""
        points = rows(x)
        flat = np.ascontiguousarray(points.reshape(-1, 3))
        slopes = np.empty((len(flat), 3, 3))
        self._run(flat, False, np.empty_like(flat), slopes)
        return slopes.reshape(*points.shape, 3)

    def _run(self, x: Float, displayed: bool, out: Float, slopes: Float) -> None:
        table = (self.frame, self.root, self.child, self.slot, self.values, self.mix, displayed)
        if len(x) < SHARE or threads() == 1:
            evaluate(x, *table, out, slopes)
            return
        # several parts a thread: points near the surface take longer than points far away
        bounds = np.linspace(0, len(x), 4 * threads() + 1).astype(int)
        tasks = [
            pool().submit(evaluate, x[a:b], *table, out[a:b], slopes[a:b])
            for a, b in pairwise(bounds)
        ]
        for task in tasks:
            task.result()


_NO_SLOPES = np.empty((0, 3, 3))


def frame_of(bricks: Bricks) -> Float:
    """(16,) the numbers of `Bricks` that place the table; see `evaluate`."""
    frame = np.empty(16)
    frame[:9] = bricks.T_scene_table[:3, :3].ravel()
    frame[9:12] = bricks.T_scene_table[:3, 3]
    frame[12:15] = bricks.spacing * CELLS
    frame[15] = 0.0 if bricks.mirror_depth is None else bricks.mirror_depth
    return frame


def largest(bricks: Bricks) -> float:
    """The greatest |u| that bricks with three channels can give, in m."""
    squares = np.einsum("...c,...c->...", bricks.values, bricks.values, dtype=np.float64)
    return math.sqrt(float(squares.max(initial=0.0)))
