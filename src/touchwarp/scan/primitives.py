"""A box, cylinder, sphere or ellipsoid fitted to a few measured points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import SceneError
from touchwarp.scene.nearest import suggest

Float = NDArray[np.float64]

# (numbers of a shape, points in its own frame) → signed distances, m
Distance = Callable[[Float, Float], Float]


@dataclass(frozen=True, eq=False)
class Primitive:
    """A fitted shape.

    Attributes:
        kind: "box", "cylinder", "sphere" or "ellipsoid".
        shape: the keys of a scene file's `shape`: `size`, or `radius` and `height`.
        T_points_shape: (4, 4) rigid: the shape's own frame (a cylinder stands on z = 0, the others
            are centred) to that of the points.
        rms_mm, max_mm: the distances of the points from the surface.
    """

    kind: str
    shape: dict[str, object]
    T_points_shape: Float
    rms_mm: float
    max_mm: float


@dataclass(frozen=True)
class _Kind:
    distance: Distance
    sizes: int
    least_points: int


def fit_primitive(kind: str, points: Float) -> Primitive:
    """Least squares of the distances from points (n, 3) m to the surface.

    Started from principal axes in every order, and the best is taken. Points must lie on all sides:
    a box touched on one face only has no depth.

    Raises:
        SceneError: an unknown kind, too few points, points that are not finite or lie in a plane.
    """
    from scipy.optimize import least_squares
    from scipy.spatial.transform import Rotation

    if kind not in _KINDS:
        raise SceneError(f"unknown shape '{kind}'. {suggest(kind, _KINDS)}")
    points = np.asarray(points, dtype=np.float64)
    shape = _KINDS[kind]
    if points.ndim != 2 or points.shape[1] != 3 or len(points) < shape.least_points:
        raise SceneError(
            f"points of shape {points.shape} came; at least {shape.least_points} points (n, 3) are "
            f"needed for a {kind}: measure more, on all its sides."
        )
    if not np.isfinite(points).all():
        raise SceneError("some of the points are NaN or infinite; measure them again.")
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    spread, axes = np.linalg.eigh(np.cov(points.T))
    if spread[0] < 1e-6 * spread[2]:
        raise SceneError(
            f"the {len(points)} points lie in a plane; a {kind} needs points on all its sides."
        )
    scale = float(np.ptp(points, axis=0).max())

    def residuals(x: Float) -> Float:
        R = Rotation.from_rotvec(x[3:6]).as_matrix() @ start
        sizes = scale * np.exp(x[6:])
        own = (points - centre - scale * x[:3]) @ R
        return np.asarray(shape.distance(sizes, own)) / scale

    best, frame = None, np.eye(3)
    frames = [axes[:, np.roll([0, 1, 2], k)] for k in range(3)] + [np.eye(3)]
    for start in frames:
        start = start * np.array([1.0, 1.0, np.sign(np.linalg.det(start))])
        half = 0.5 * np.ptp((points - centre) @ start, axis=0)
        sizes = {1: [half.mean()], 2: [half[:2].mean(), half[2]], 3: half}[shape.sizes]
        x = np.concatenate([np.zeros(6), np.log(np.asarray(sizes) / scale)])
        found = least_squares(residuals, x, x_scale="jac", max_nfev=200)
        if best is None or found.cost < best.cost * (1 - 1e-9):
            best, frame = found, start
    assert best is not None
    start = frame
    distance = scale * np.abs(residuals(best.x))
    return _primitive(kind, best.x, scale, centre, frame, distance)


def _primitive(
    kind: str, x: Float, scale: float, centre: Float, frame: Float, distance: Float
) -> Primitive:
    from scipy.spatial.transform import Rotation

    T = np.eye(4)
    T[:3, :3] = np.eye(3) if kind == "sphere" else Rotation.from_rotvec(x[3:6]).as_matrix() @ frame
    T[:3, 3] = centre + scale * x[:3]
    sizes = [float(v) for v in scale * np.exp(x[6:])]
    keys: dict[str, object] = {"size": [2 * v for v in sizes]}
    if kind == "sphere":
        keys = {"radius": sizes[0]}
    elif kind == "cylinder":
        keys = {"radius": sizes[0], "height": 2 * sizes[1]}
        if T[2, 2] < 0:  # stand it on its lower end
            T[:3, 1:3] *= -1
        T[:3, 3] -= sizes[1] * T[:3, 2]
    rms, greatest = float(np.sqrt((distance**2).mean())), float(distance.max())
    return Primitive(kind, keys, T, rms * 1e3, greatest * 1e3)


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
    "box": _Kind(_to_box, 3, 9),
    "cylinder": _Kind(_to_cylinder, 2, 7),
    "sphere": _Kind(_to_sphere, 1, 4),
    "ellipsoid": _Kind(_to_ellipsoid, 3, 9),
}
