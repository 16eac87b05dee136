"""Where the real hand must be for a displayed position, for a warp of any kind.

A root of f(x) = y satisfies |x − y| = |u(x)|, so all roots lie in a ball around y. Starts are
spread over that ball; a start is kept where its first Newton step is no longer than the starts are
apart, and damped Newton goes on from there. One more start follows x + s u(x) = y from s = 0 to 1.
Of the roots found the nearest is taken: a fold smaller than the starts' spacing may be missed.
Tables have an exhaustive search instead, see `touchwarp.warp.roots`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from touchwarp.warp.protocol import Inverse, Warp

Float = NDArray[np.float64]

RESIDUAL = 1e-9
"""m: how close to the displayed position f must come for a root to be accepted."""

_STEPS = 30
_CONTINUATION = 8
_ROWS = 1 << 16


def find_inverse(
    warp: Warp, x: ArrayLike, *, reach: float | None = None, starts: int = 200
) -> Inverse:
    """Real positions whose displayed position is x; of several the one nearest to x.

    Args:
        warp: any warp.
        x: (..., d) m, scene frame, displayed positions.
        reach: m, a bound on |u|; `warp.max_displacement` or an estimate when left out.
        starts: how many starts a point gets.

    Returns:
        (..., d) m, NaN where no root was found or the row has a NaN; and whether one was found.

    Raises:
        ValueError: x has a wrong shape.
    """
    shown = np.asarray(x, dtype=np.float64)
    d = warp.dimension
    if shown.ndim == 0 or shown.shape[-1] != d:
        raise ValueError(f"Points have shape {shown.shape}; (..., {d}) is needed.")
    y = shown.reshape(-1, d)
    points = np.full_like(y, np.nan)
    u = warp.displacement(y)
    still = (u == 0.0).all(axis=-1)
    points[still] = y[still]
    todo = np.flatnonzero(~still & np.isfinite(u).all(axis=-1))
    if reach is None:
        reach = getattr(warp, "max_displacement", None)
    ball = _ball(starts, d)
    share = max(1, _ROWS // (starts + 1))
    for first in range(0, len(todo), share):
        part = todo[first : first + share]
        radius = np.full(len(part), reach) if reach is not None else _reach(warp, y[part])
        points[part] = _nearest_roots(warp, y[part], radius, ball)
    return as_inverse(points.reshape(shown.shape))


def as_inverse(points: Float) -> Inverse:
    """(..., d) m, NaN where no root was found, with the flags that tell so."""
    found: NDArray[np.bool_] = np.asarray(np.isfinite(points).all(axis=-1))
    return Inverse(points, found)


def _nearest_roots(warp: Warp, y: Float, radius: Float, ball: Float) -> Float:
    queries, d = y.shape
    starts = len(ball)
    x = y[:, None] + radius[:, None, None] * ball
    target = np.broadcast_to(y[:, None], x.shape)
    step = _newton_step(warp, x.reshape(-1, d), target.reshape(-1, d)).reshape(x.shape)
    apart = 2.0 * radius[:, None] * (1.0 / starts) ** (1.0 / d)
    near = np.linalg.norm(step, axis=-1) <= 2.0 * apart
    owner, which = np.nonzero(near)
    seeds = np.concatenate([_continued(warp, y), x[owner, which] - step[owner, which]])
    owner = np.concatenate([np.arange(queries), owner])
    roots, solved = _newton(warp, seeds, y[owner], radius[owner])
    owner, roots = owner[solved], roots[solved]
    distance = np.linalg.norm(roots - y[owner], axis=-1)
    nearest = np.full_like(y, np.nan)
    order = np.argsort(-distance, kind="stable")
    nearest[owner[order]] = roots[order]
    return nearest


def _newton_step(warp: Warp, x: Float, y: Float, share: float = 1.0) -> Float:
    """−J⁻¹ r of x + share · u(x) = y, regularised where J is all but singular."""
    d = x.shape[1]
    eye = np.eye(d)
    residual = x + share * warp.displacement(x) - y
    slope = eye + share * (warp.jacobian(x) - eye)
    transposed = np.swapaxes(slope, -1, -2)
    normal = transposed @ slope + 1e-10 * eye
    right = (transposed @ residual[..., None])[..., 0]
    return np.asarray(-np.linalg.solve(normal, right[..., None])[..., 0], np.float64)


def _continued(warp: Warp, y: Float) -> Float:
    x = y.copy()
    for share in np.linspace(0.0, 1.0, _CONTINUATION + 1)[1:]:
        for _ in range(2):
            x = x + _newton_step(warp, x, y, float(share))
    return x


def _newton(warp: Warp, x: Float, y: Float, radius: Float) -> tuple[Float, NDArray[np.bool_]]:
    """Damped Newton, every row on its own; which rows came to a root."""
    x = x.copy()
    residual = np.linalg.norm(x + warp.displacement(x) - y, axis=-1)
    active = np.flatnonzero(residual > 1e-3 * RESIDUAL)
    for _ in range(_STEPS):
        if len(active) == 0:
            break
        step = _newton_step(warp, x[active], y[active])
        length = np.linalg.norm(step, axis=-1)
        step *= np.minimum(1.0, 0.5 * radius[active] / np.maximum(length, 1e-300))[:, None]
        waiting = np.arange(len(active))
        for _ in range(6):
            trial = x[active[waiting]] + step[waiting]
            size = np.linalg.norm(trial + warp.displacement(trial) - y[active[waiting]], axis=-1)
            better = size < residual[active[waiting]]
            x[active[waiting[better]]] = trial[better]
            residual[active[waiting[better]]] = size[better]
            waiting = waiting[~better]
            if len(waiting) == 0:
                break
            step[waiting] *= 0.4
        stuck = np.zeros(len(active), bool)
        stuck[waiting] = True
        active = active[~stuck & (residual[active] > 1e-3 * RESIDUAL)]
    return x, residual <= RESIDUAL


def _reach(warp: Warp, y: Float) -> Float:
    """An estimate of the greatest |u| within that distance of y."""
    ball = _ball(64, y.shape[1])
    radius = 2.0 * np.linalg.norm(warp.displacement(y), axis=-1)
    for _ in range(4):
        sample = y[:, None] + radius[:, None, None] * ball
        u = warp.displacement(sample.reshape(-1, y.shape[1])).reshape(sample.shape)
        radius = np.maximum(radius, 1.25 * np.linalg.norm(u, axis=-1).max(axis=1))
    return np.asarray(radius, np.float64)


def _ball(count: int, d: int) -> Float:
    """(count, d) points spread evenly over the unit ball, the same every time."""
    n = np.arange(count)
    golden = (1.0 + np.sqrt(5.0)) / 2.0
    size = ((n + 0.5) / count) ** (1.0 / d)
    turn = 2.0 * np.pi * n / golden
    if d == 2:
        return np.stack([np.cos(turn), np.sin(turn)], axis=-1) * size[:, None]
    # heights by a second irrational step, lest they grow with the radius
    height = 2.0 * ((n * np.sqrt(2.0) + 0.5) % 1.0) - 1.0
    flat = np.sqrt(1.0 - height**2)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), height], axis=-1) * size[:, None]
