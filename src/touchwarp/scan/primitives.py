"""A box, cylinder, sphere or ellipsoid fitted to a few measured points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import SceneError
from touchwarp.scan.fitting import End, Fit, Fitting, Kind
from touchwarp.scene.nearest import suggest

Float = NDArray[np.float64]

ELSEWHERE = 0.05
"""Of the points' extent: how far an end is moved to see whether the points tell it."""
TOLD = 7.0
"""Standard deviations of a touch by which the distances (root of their sum of squares) then grow at
least. An end that was touched in three places has 26 or more; one that was not has up to 6, where
points at its edge happen to suit it."""
SURE = 2.0
"""Standard deviations by which what is told as known is known."""
LEAST_NOISE, MOST_NOISE = 1e-3, 1e-2
"""Of the points' extent: no touch is believed to be more exact, 0.1 mm on a can; and what lies
farther off shows that the thing is of another shape, not that it was touched badly."""
SPARE = 3
"""Points beyond a shape's own numbers, so that their distances tell something."""
DOWN = np.cos(np.radians(20))
"""A flat end that looks down by so much is what the thing stands on."""


@dataclass(frozen=True, eq=False)
class Primitive:
    """A fitted shape.

    Attributes:
        kind: "box", "cylinder", "sphere" or "ellipsoid".
        shape: the keys of a scene file's `shape`: `size`, or `radius` and `height`.
        T_points_shape: (4, 4) rigid: the shape's own frame (a cylinder stands on z = 0, the others
            are centred) to that of the points.
        rms_mm, max_mm: the distances of the points from the surface.
        known_mm: to how much the points tell the least certain of its ends (two standard
            deviations).
        standing: nothing tells its lower end, as of a thing that stands on a table, and its lowest
            point was taken.
    """

    kind: str
    shape: dict[str, object]
    T_points_shape: Float
    rms_mm: float
    max_mm: float
    known_mm: float
    standing: bool


def fit_primitive(kind: str, points: Float) -> Primitive:
    """Least squares of the distances from points (n, 3) m, z up, to the surface.

    Started from principal axes in every order and from even rotations, and the best is taken. Then
    each end is moved and all else fitted again: where the distances hardly grow, the points do not
    tell where the shape ends, and it is refused. The lower end of a box or a cylinder that stands
    is taken where its lowest point is.

    Raises:
        SceneError: an unknown kind, too few points, points that are not finite, lie in a plane or
            leave an end open.
    """
    if kind not in _KINDS:
        raise SceneError(f"unknown shape '{kind}'. {suggest(kind, _KINDS)}")
    points = np.asarray(points, dtype=np.float64)
    least = _KINDS[kind].freedoms + SPARE
    if points.ndim != 2 or points.shape[1] != 3 or len(points) < least:
        raise SceneError(
            f"points of shape {points.shape} came; at least {least} points (n, 3) are "
            f"needed for a {kind}: measure more, on all its sides."
        )
    if not np.isfinite(points).all():
        raise SceneError("some of the points are NaN or infinite; measure them again.")
    spread = np.linalg.eigvalsh(np.cov(points.T))
    if spread[0] < 1e-6 * spread[2]:
        raise SceneError(
            f"the {len(points)} points lie in a plane; a {kind} needs points on all its sides."
        )
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    extent = float(np.ptp(points, axis=0).max())
    fitting = Fitting(_KINDS[kind], (points - middle) / extent)
    fit = fitting.best()
    growths = _growths(fitting, fit)
    floor = _floor(fitting, _loose(fitting, fit, growths))
    held = [] if floor is None else [floor]
    if held:
        fit = fitting.solve(fit, held)
        growths = _growths(fitting, fit, held)
    loose = _loose(fitting, fit, growths)
    if loose:
        raise SceneError(_refusal(kind, len(points), loose, ELSEWHERE * extent))
    # the sum of squares grows as the square of the way: how far it is to SURE² variances of it
    least_growth = min(growth for _, growth in growths)
    known = ELSEWHERE * SURE * max(_noise(fitting, fit), LEAST_NOISE) / float(np.sqrt(least_growth))
    return _primitive(kind, fitting, fit, middle, extent, known, bool(held))


def _noise(fitting: Fitting, fit: Fit) -> float:
    """The standard deviation of a touch."""
    spare = len(fitting.points) - fitting.kind.freedoms
    return float(np.sqrt(fit.cost / spare))


def _growths(fitting: Fitting, best: Fit, held: Sequence[End] = ()) -> list[tuple[End, float]]:
    """By how much the sum of squares grows if an end lies elsewhere, for each that is not held.

    An end is put out and in by ELSEWHERE, and all else fitted again.
    """
    growths = []
    for end in fitting.ends(best):
        if any(end.axis == other.axis and end.direction @ other.direction > 0 for other in held):
            continue
        costs = []
        for by in (ELSEWHERE, -ELSEWHERE):
            there = End(end.direction, end.axis, end.place + by)
            costs.append(fitting.solve(fitting.moved(best, end, by), [*held, there]).cost)
        growths.append((end, min(costs) - best.cost))
    return growths


def _loose(fitting: Fitting, fit: Fit, growths: list[tuple[End, float]]) -> list[End]:
    """The ends that the points do not tell."""
    noise = np.clip(_noise(fitting, fit), LEAST_NOISE, MOST_NOISE)
    return [end for end, growth in growths if growth < (TOLD * noise) ** 2]


def _floor(fitting: Fitting, loose: list[End]) -> End | None:
    """What a thing stands on, where no point tells it: a flat end held at the lowest point."""
    for end in loose:
        if end.axis in fitting.kind.flat and end.direction[2] < -DOWN:
            return End(end.direction, end.axis, float((fitting.points @ end.direction).max()))
    return None


def _refusal(kind: str, count: int, loose: list[End], way: float) -> str:
    directions = ", ".join(
        "(" + ", ".join(f"{v + 0.0:.2f}" for v in np.round(end.direction, 2)) + ")" for end in loose
    )
    return (
        f"the {count} points do not tell where the {kind} ends towards {directions}: moved by "
        f"{way * 1e3:.2g} mm there, it fits them about as well. Touch it on those sides too, at "
        "several places away from its edges, which could belong to either side. Only the lower end "
        "of a box or a cylinder that stands upright, z up, is taken at its lowest point."
    )


def _primitive(
    kind: str,
    fitting: Fitting,
    fit: Fit,
    middle: Float,
    extent: float,
    known: float,
    standing: bool,
) -> Primitive:
    T = np.eye(4)
    T[:3, :3] = np.eye(3) if kind == "sphere" else fit.frame
    T[:3, 3] = middle + extent * fit.centre
    sizes = [float(v) for v in extent * fit.half]
    keys: dict[str, object] = {"size": [2 * v for v in sizes]}
    if kind == "sphere":
        keys = {"radius": sizes[0]}
    elif kind == "cylinder":
        keys = {"radius": sizes[0], "height": 2 * sizes[1]}
        if T[2, 2] < 0:  # stand it on its lower end
            T[:3, 1:3] *= -1
        T[:3, 3] -= sizes[1] * T[:3, 2]
    distance = extent * np.abs(fitting.distances(fit))
    return Primitive(
        kind=kind,
        shape=keys,
        T_points_shape=T,
        rms_mm=float(np.sqrt((distance**2).mean())) * 1e3,
        max_mm=float(distance.max()) * 1e3,
        known_mm=known * extent * 1e3,
        standing=standing,
    )


def _to_box(half: Float, points: Float) -> Float:
    excess = np.abs(points) - half
    outside = np.linalg.norm(np.maximum(excess, 0), axis=1)
    return np.asarray(outside + np.minimum(excess.max(axis=1), 0))


def _to_cylinder(sizes: Float, points: Float) -> Float:
    across = np.linalg.norm(points[:, :2], axis=1)
    return _to_box(sizes, np.stack([across, points[:, 2]], axis=1))


def _to_sphere(radius: Float, points: Float) -> Float:
    return np.asarray(np.linalg.norm(points, axis=1) - radius[0])


def _to_ellipsoid(half: Float, points: Float) -> Float:
    # to the first order in the distance: the level k0 over its gradient (Quilez 2008)
    level = np.linalg.norm(points / half, axis=1)
    slope = np.linalg.norm(points / half**2, axis=1)
    return np.asarray(level * (level - 1) / np.maximum(slope, 1e-300))


_KINDS = {
    "box": Kind(_to_box, (0, 1, 2), (0, 1, 2), 9),
    "cylinder": Kind(_to_cylinder, (0, 0, 1), (2,), 7),
    "sphere": Kind(_to_sphere, (0, 0, 0), (), 4),
    "ellipsoid": Kind(_to_ellipsoid, (0, 1, 2), (), 9),
}
