"""Shapes made from numbers, all closed and turned outward, in metres, axis z.

Curved faces are inscribed: their vertices lie on the true surface, and no point of a triangle is
farther from it than `facet_mm`, 0.02 mm unless told.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from touchwarp.errors import SceneError
from touchwarp.scene.surface import Surface

FACET_MM = 0.02

# In units of the radius over the square of the frequency; the largest triangle of a subdivided
# icosahedron lies at a face's centre, 1/0.7947 times as big as at its corners.
_GEODESIC_FACET = 0.292


def box(size: Sequence[float]) -> Surface:
    """A box of 12 triangles, centred on the origin; size (3,) m."""
    half = _positive("size", size, 3) / 2
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    faces = [
        (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
        (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
    ]  # fmt: skip
    return Surface(corners * half, np.array(faces))


def sphere(radius: float, facet_mm: float = FACET_MM) -> Surface:
    """A subdivided icosahedron, centred on the origin; radius in m."""
    return ellipsoid([2 * float(_positive("radius", [radius], 1)[0])] * 3, facet_mm)


def ellipsoid(size: Sequence[float], facet_mm: float = FACET_MM) -> Surface:
    """An ellipsoid centred on the origin; size (3,) m: its three diameters."""
    half = _positive("size", size, 3) / 2
    facet = float(_positive("facet_mm", [facet_mm], 1)[0]) * 1e-3
    frequency = max(2, math.ceil(math.sqrt(_GEODESIC_FACET * half.max() / facet)))
    unit = _geodesic(frequency)
    return Surface(unit.vertices * half, unit.faces)


def cylinder(radius: float, height: float, facet_mm: float = FACET_MM) -> Surface:
    """A cylinder standing on z = 0; radius and height in m."""
    radius = float(_positive("radius", [radius], 1)[0])
    height = float(_positive("height", [height], 1)[0])
    n = circle_segments(radius, facet_mm)
    angles = 2 * np.pi * np.arange(n) / n
    outline = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return _prism(outline, 0.0, height, centre=np.zeros(2))


def fillet_box(size: Sequence[float], fillet: float, facet_mm: float = FACET_MM) -> Surface:
    """A box centred on the origin whose vertical edge at +x, +y is rounded.

    Args:
        size: (3,) m.
        fillet: m, the rounding's radius, less than the size in x and y.
    """
    half = _positive("size", size, 3) / 2
    fillet = float(_positive("fillet", [fillet], 1)[0])
    if fillet >= 2 * half[:2].min():
        raise SceneError(
            f"the fillet is {fillet:g} m, but the box is {2 * half[0]:g} × {2 * half[1]:g} m; a "
            "fillet smaller than both is needed."
        )
    steps = circle_segments(fillet, facet_mm) // 4
    angles = np.pi / 2 * np.arange(steps + 1) / steps
    arc = half[:2] - fillet + fillet * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    corners = np.array([(-half[0], half[1]), (-half[0], -half[1]), (half[0], -half[1])])
    return _prism(np.concatenate([arc, corners]), -half[2], half[2], centre=None)


def polygon(corners: ArrayLike) -> Surface:
    """A closed polygon of a plane scene; corners (n, 2) m, in order, the first not repeated."""
    points = np.array(corners, dtype=np.float64)
    if points.ndim != 2 or points.shape[1:] != (2,):
        raise SceneError(f"a polygon has shape {points.shape}; (n, 2) is needed.")
    if len(points) > 1 and np.array_equal(points[0], points[-1]):
        points = points[:-1]
    if len(points) < 3:
        raise SceneError(f"a polygon has {len(points)} corners; at least 3 are needed.")
    index = np.arange(len(points))
    proper = (points != np.roll(points, -1, axis=0)).any(axis=1)
    if not proper.all():
        raise SceneError(
            f"corner {int(np.flatnonzero(~proper)[0]) + 1} of a polygon is repeated by the next; "
            "remove one of them."
        )
    return Surface(points, np.stack([index, np.roll(index, -1)], axis=1))


def circle_segments(radius: float, facet_mm: float) -> int:
    """The least multiple of 4 of segments whose chords lie within facet_mm of the circle."""
    facet = float(_positive("facet_mm", [facet_mm], 1)[0]) * 1e-3
    half_angle = math.acos(max(0.0, 1.0 - facet / radius))
    return max(8, 4 * math.ceil(math.pi / half_angle / 4))


def _mug() -> Surface:
    from touchwarp.scene.vessels import mug

    return mug()


def _tea_cup() -> Surface:
    from touchwarp.scene.vessels import tea_cup

    return tea_cup()


SHAPES: dict[str, Callable[..., Surface]] = {
    "box": box,
    "sphere": sphere,
    "ellipsoid": ellipsoid,
    "cylinder": cylinder,
    "fillet_box": fillet_box,
    "mug": _mug,
    "tea_cup": _tea_cup,
}


def shape_keys(kind: str) -> tuple[str, ...]:
    """The keys of a shape of that kind in the scene file."""
    return tuple(inspect.signature(SHAPES[kind]).parameters)


def make_shape(kind: str, values: Mapping[str, Any]) -> Surface:
    """The shape of that kind; raises SceneError where one of its keys is missing."""
    for key, parameter in inspect.signature(SHAPES[kind]).parameters.items():
        if parameter.default is inspect.Parameter.empty and key not in values:
            raise SceneError(f"'{key}' is missing; a {kind} needs it.")
    return SHAPES[kind](**values)


def _positive(key: str, value: Sequence[float], length: int) -> NDArray[np.float64]:
    numbers = np.array(value, dtype=np.float64)
    if numbers.shape != (length,) or not np.isfinite(numbers).all() or (numbers <= 0).any():
        shown = numbers.tolist() if length > 1 else numbers.tolist()[0]
        needed = "a finite number > 0" if length == 1 else f"{length} finite numbers > 0"
        raise SceneError(f"a shape's {key} is {shown}; {needed} is needed.")
    return numbers


def _prism(
    outline: NDArray[np.float64], low: float, high: float, centre: NDArray[np.float64] | None
) -> Surface:
    """An upright prism over a convex outline; its caps fan from `centre`, or else a corner."""
    n = len(outline)
    index = np.arange(n)
    after = np.roll(index, -1)
    vertices = [np.c_[outline, np.full(n, low)], np.c_[outline, np.full(n, high)]]
    sides = np.concatenate([np.c_[index, after, after + n], np.c_[index, after + n, index + n]])
    if centre is None:
        # From the corner before last, which no arc touches.
        fan = np.array([(n - 2, (i - 2) % n, (i - 1) % n) for i in range(1, n - 1)])
        caps = np.concatenate([fan[:, ::-1], fan + n])
    else:
        vertices.append(np.array([[*centre, low], [*centre, high]]))
        bottom = np.c_[after, index, np.full(n, 2 * n)]
        top = np.c_[index + n, after + n, np.full(n, 2 * n + 1)]
        caps = np.concatenate([bottom, top])
    return Surface(np.concatenate(vertices), np.concatenate([sides, caps]))


def _geodesic(frequency: int) -> Surface:
    """The unit sphere as an icosahedron whose faces are cut into frequency² triangles."""
    golden = (1 + math.sqrt(5)) / 2
    corners = np.array(
        [(-1, golden, 0), (1, golden, 0), (-1, -golden, 0), (1, -golden, 0),
         (0, -1, golden), (0, 1, golden), (0, -1, -golden), (0, 1, -golden),
         (golden, 0, -1), (golden, 0, 1), (-golden, 0, -1), (-golden, 0, 1)]
    )  # fmt: skip
    triangles = np.array(
        [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4),
         (11, 10, 2), (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8),
         (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    )  # fmt: skip
    n = frequency
    lattice = [(i, j) for i in range(n + 1) for j in range(n + 1 - i)]
    row = {ij: k for k, ij in enumerate(lattice)}
    cells = [(row[i, j], row[i + 1, j], row[i, j + 1]) for i, j in lattice if i + j < n]
    cells += [
        (row[i + 1, j], row[i + 1, j + 1], row[i, j + 1]) for i, j in lattice if i + j < n - 1
    ]
    weights = np.array([(n - i - j, i, j) for i, j in lattice]) / n
    points = np.einsum("pw,twc->tpc", weights, corners[triangles]).reshape(-1, 3)
    faces = (np.array(cells) + len(lattice) * np.arange(20)[:, None, None]).reshape(-1, 3)
    # Points on shared edges come out of different sums, equal only to rounding.
    _, first, index = np.unique(
        np.rint(points * 1e9), axis=0, return_index=True, return_inverse=True
    )
    vertices = points[first]
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    return Surface(vertices, index.ravel()[faces])
