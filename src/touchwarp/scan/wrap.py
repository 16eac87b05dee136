"""A closed surface around a scan: where its winding number falls through one half.

The generalised winding number w (Jacobson et al. 2013; fast by Barill et al. 2018) is 1 inside and
0 outside of a closed surface, and passes smoothly between the two in the holes of an open one. With
the distance d to the scan, the zero set of (1 − 2w)·d lies on the scan where there is one, to the
second order in the voxel, and spans its holes where there is none.

Only voxels that the zero set crosses are looked at, found by following it from the scan: the cost
grows with the square of the resolution, not the cube.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import SceneError
from touchwarp.scan.deviation import face_areas, face_normals
from touchwarp.scene.surface import Surface

Float = NDArray[np.float64]
Int = NDArray[np.int64]
Progress = Callable[[str, float], None]

MOST_CORNERS = 3_000_000
"""About 1 GB of work; a finer voxel is refused."""

# Voxel corners in the order that libigl's marching cubes wants them.
_CORNERS = np.array(
    [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
)
# The four of them on each of a voxel's six faces, and the step to the neighbour across it.
_SIDES = [
    ([0, 3, 4, 7], (-1, 0, 0)),
    ([1, 2, 5, 6], (1, 0, 0)),
    ([0, 1, 4, 5], (0, -1, 0)),
    ([2, 3, 6, 7], (0, 1, 0)),
    ([0, 1, 2, 3], (0, 0, -1)),
    ([4, 5, 6, 7], (0, 0, 1)),
]
# Of three grid coordinates, 21 bits each, one key.
_BITS = 21


def wrap(
    surface: Surface, voxel: float, offset: float = 0.0, progress: Progress | None = None
) -> Surface:
    """The surface where the winding number of `surface` falls through one half.

    Closed whatever the input; in several pieces where the input is. Details smaller than two
    voxels, such as a wall, come out with holes: use a voxel less than half of the thinnest wall.

    Args:
        surface: triangles whose faces are turned alike, holes and crossings allowed.
        voxel: m, side of a marching cube.
        offset: m, how far outside (or, if negative, inside) of that the result lies.
        progress: called as progress(step, part done).

    Raises:
        SceneError: the voxel is so small that the work would not fit in memory, or so large that
            nothing is left.
    """
    report = progress or (lambda step, part: None)
    needed = corner_count(surface, voxel)
    if needed > MOST_CORNERS:
        least = voxel * (needed / MOST_CORNERS) ** 0.5
        raise SceneError(
            f"a voxel of {voxel * 1e3:.3g} mm needs about {needed / 1e6:.0f} million corners; at "
            f"most {MOST_CORNERS / 1e6:.0f} million are allowed: use {least * 1e3:.2g} mm or more."
        )
    # off the input's own lattice, where corners on the surface would have no side
    origin = surface.bounds[0] - voxel * np.array([1.37, 1.53, 1.71])
    field = _Field(surface, origin, voxel, offset)
    fresh = seen = _seeds(surface, origin, voxel, offset)
    crossed: list[Int] = []
    while len(fresh):
        report("wrapping", 1 - 1 / (1 + 0.2 * len(crossed)))
        inside = field.at(fresh) < 0
        mixed = inside.any(axis=1) & ~inside.all(axis=1)
        crossed.append(fresh[mixed])
        beyond = []
        for corners, step in _SIDES:
            side = inside[:, corners]
            leaves = side.any(axis=1) & ~side.all(axis=1)
            beyond.append(_key(_unkey(fresh[leaves]) + step))
        fresh = _unique(np.concatenate(beyond))
        fresh = fresh[seen[np.minimum(np.searchsorted(seen, fresh), len(seen) - 1)] != fresh]
        seen = np.sort(np.concatenate([seen, fresh]), kind="stable")
    voxels = np.concatenate(crossed)
    if len(voxels) == 0:
        raise SceneError(
            f"nothing of the mesh is left at a voxel of {voxel * 1e3:.3g} mm: it has no inside "
            "(an open sheet, or faces turned both ways), or is thinner than that voxel; use a "
            "smaller one, or a closed mesh."
        )
    return field.zero_set(voxels)


def corner_count(surface: Surface, voxel: float) -> float:
    """About how many voxel corners a wrap evaluates."""
    return 3.0 * float(face_areas(surface).sum()) / voxel**2


class _Field:
    """(1 − 2w)·d − offset at voxel corners."""

    def __init__(self, surface: Surface, origin: Float, voxel: float, offset: float) -> None:
        import igl

        self.surface, self.origin, self.voxel, self.offset = surface, origin, voxel, offset
        self.winding = igl.FastWindingNumberBVH()
        self.winding.init(surface.vertices, surface.faces)
        self.tree = igl.AABB()
        self.tree.init(surface.vertices, surface.faces)
        self.known: list[tuple[Int, Float]] = []

    def at(self, voxels: Int) -> Float:
        """(n, 8): the values at the corners of voxels (n,) keys."""
        keys, index = np.unique(_corners(voxels), return_inverse=True)
        values = self._evaluate(self.points(keys))
        self.known.append((keys, values))
        return np.asarray(values[index.reshape(-1, 8)])

    def _evaluate(self, points: Float) -> Float:
        w = np.clip(np.asarray(self.winding.winding_number(points)), 0.0, 1.0)
        squared, _, _ = self.tree.squared_distance(
            self.surface.vertices, self.surface.faces, points
        )
        value = (1 - 2 * w) * np.sqrt(np.asarray(squared)) - self.offset
        # a corner on the zero set itself counts as outside, by a length that moves nothing
        value[value == 0] = 1e-9 * self.voxel
        return np.asarray(value)

    def points(self, keys: Int) -> Float:
        return np.asarray(self.origin + self.voxel * _unkey(keys))

    def zero_set(self, voxels: Int) -> Surface:
        """The triangles of the zero set in voxels (n,) keys, turned outward."""
        import igl

        known = np.concatenate([keys for keys, _ in self.known])
        values = np.concatenate([values for _, values in self.known])
        order = np.argsort(known, kind="stable")
        used, index = np.unique(_corners(voxels), return_inverse=True)
        vertices, faces, _ = igl.marching_cubes(
            values[order[np.searchsorted(known, used, sorter=order)]],
            self.points(used),
            np.ascontiguousarray(index.reshape(-1, 8)),
            0.0,
        )
        return Surface(np.asarray(vertices), np.asarray(faces))


def _seeds(surface: Surface, origin: Float, voxel: float, offset: float) -> Int:
    """Keys, ascending, of the voxels near the surface moved by `offset` along its normals."""
    corners = surface.vertices[surface.faces]
    corners = corners + offset * face_normals(surface)[:, None]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    parts = np.maximum(1, np.ceil(longest / voxel)).astype(np.int64)
    found = []
    for n in np.unique(parts):
        weights = np.array([(i, j, n - i - j) for i in range(n + 1) for j in range(n + 1 - i)]) / n
        batch = max(1, 2_000_000 // len(weights))
        which = np.flatnonzero(parts == n)
        for start in range(0, len(which), batch):
            some = corners[which[start : start + batch]]
            points = np.einsum("pw,twc->tpc", weights, some).reshape(-1, 3)
            found.append(_unique(_key(np.floor((points - origin) / voxel).astype(np.int64))))
    return _unique(np.concatenate(found))


def _unique(keys: Int) -> Int:
    # by sorting: NumPy's hash table is several times slower on keys like these
    ordered = np.sort(keys, axis=None)
    return ordered[np.r_[True, ordered[1:] != ordered[:-1]]] if len(ordered) else ordered


def _corners(voxels: Int) -> Int:
    return _key(_unkey(voxels)[:, None] + _CORNERS)


def _key(cells: Int) -> Int:
    """(...,) one integer of (..., 3) grid coordinates, which may be a little below zero."""
    cells = cells + (1 << (_BITS - 1))
    return np.asarray((cells[..., 0] << (2 * _BITS)) | (cells[..., 1] << _BITS) | cells[..., 2])


def _unkey(keys: Int) -> Int:
    mask = (1 << _BITS) - 1
    cells = np.stack([keys >> (2 * _BITS), (keys >> _BITS) & mask, keys & mask], axis=-1)
    return cells - (1 << (_BITS - 1))
