"""Seeded sample points of Ω: dense near the props, each standing for a known volume.

Space is divided into cubes, halved towards the surfaces; each cube holds one point, placed at
random within it. Sums over the points are then integrals over Ω (stratified Monte Carlo).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.check.region import Region
from touchwarp.goals.surface_samples import SurfaceSamples

Float = NDArray[np.float64]
Int = NDArray[np.int64]

ROOTS_ALONG_LONGEST_SIDE = 48
FINEST_CUBES = 200_000
"""Aimed-at number of cubes of the finest size around all props together."""

_CUBES_PER_SIDE_SQUARED = 8.0
"""Finest cubes for each square of their side on the surface: about four on either side."""

_MOST_HALVINGS = 10


@dataclass(frozen=True, eq=False)
class Probes:
    """Points of Ω.

    Attributes:
        points: (n, d) m, scene frame.
        volume: (n,) m³ (m² in the plane): what each stands for.
        side: (n,) m: its cube's side.
        u: (n, d) m: displacement there.
        slopes: (n, d, d): ∂f/∂x there.
    """

    points: Float
    volume: Float
    side: Float
    u: Float
    slopes: Float

    @property
    def determinant(self) -> Float:
        """(n,) det ∂f."""
        return determinants(self.slopes)

    @property
    def gain(self) -> Float:
        """(n, d) singular values of ∂f, greatest first."""
        return singular_values(self.slopes)


def place_probes(
    region: Region,
    surfaces: tuple[SurfaceSamples, ...],
    areas: tuple[float, ...],
    rng: np.random.Generator,
) -> tuple[Float, Float]:
    """Points of Ω (n, d) m and the sides (n,) m of their cubes.

    Args:
        region: Ω.
        surfaces: samples of each prop's surface.
        areas: their areas, m².
        rng: where the places within the cubes come from.
    """
    low, high = region.box
    d = len(low)
    root_side = float((high - low).max()) / ROOTS_ALONG_LONGEST_SIDE
    shape = np.maximum(np.ceil((high - low) / root_side - 1e-9).astype(np.int64), 1)
    keys = np.arange(int(np.prod(shape)), dtype=np.int64)
    cubes = np.stack(np.unravel_index(keys, tuple(shape)), axis=1).astype(np.int64)
    depths = [_depth(area, root_side, d, len(areas)) for area in areas]
    points: list[Float] = []
    sides: list[Float] = []
    side = root_side
    for level in range(max(depths) + 1):
        reaching = [
            s.points[:: max(1, len(s.points) // 300_000)]
            for s, depth in zip(surfaces, depths, strict=True)
            if depth > level
        ]
        split = np.zeros(len(cubes), bool)
        if reaching:
            near = _around(np.floor((np.concatenate(reaching) - low) / side).astype(np.int64))
            split = np.isin(_key(cubes), _key(near))
        leaves = cubes[~split]
        placed = low + (leaves + rng.random((len(leaves), d))) * side
        points.append(placed)
        sides.append(np.full(len(leaves), side))
        offsets = np.stack(np.meshgrid(*[[0, 1]] * d, indexing="ij"), -1).reshape(-1, d)
        cubes = (2 * cubes[split][:, None, :] + offsets).reshape(-1, d)
        side /= 2
    everywhere, all_sides = np.concatenate(points), np.concatenate(sides)
    kept = region.contains(everywhere)
    return everywhere[kept], all_sides[kept]


def _depth(area: float, root_side: float, d: int, props: int) -> int:
    """How often cubes at a surface of this area are halved."""
    if d == 3:
        finest = np.sqrt(_CUBES_PER_SIDE_SQUARED * area * props / FINEST_CUBES)
    else:
        finest = _CUBES_PER_SIDE_SQUARED * area * props / (0.1 * FINEST_CUBES)
    return int(np.clip(np.ceil(np.log2(root_side / finest)), 1, _MOST_HALVINGS))


def _around(cells: Int) -> Int:
    """The cells and all that touch them, each once."""
    d = cells.shape[1]
    cells = _once(cells)
    steps = np.stack(np.meshgrid(*[[-1, 0, 1]] * d, indexing="ij"), -1).reshape(-1, d)
    return _once((cells[:, None, :] + steps).reshape(-1, d))


def _once(cells: Int) -> Int:
    _, first = np.unique(_key(cells), return_index=True)
    return cells[first]


def _key(cells: Int) -> Int:
    """One number for each cell; coordinates may be from -2¹⁹ to 2¹⁹."""
    key = np.zeros(len(cells), np.int64)
    for column in cells.T:
        key = (key << 20) + (column + (1 << 19))
    return key


def determinants(slopes: Float) -> Float:
    """(n,) determinants of (n, d, d)."""
    if slopes.shape[-1] == 2:
        flat: Float = slopes[:, 0, 0] * slopes[:, 1, 1] - slopes[:, 0, 1] * slopes[:, 1, 0]
        return flat
    a, b, c = slopes[:, 0], slopes[:, 1], slopes[:, 2]
    det: Float = np.einsum("ij,ij->i", a, np.cross(b, c))
    return det


def singular_values(slopes: Float) -> Float:
    """(n, d) singular values of (n, d, d), greatest first: roots of the eigenvalues of JᵀJ."""
    squares = np.linalg.eigvalsh(np.einsum("nji,njk->nik", slopes, slopes))
    values: Float = np.sqrt(np.maximum(squares[:, ::-1], 0.0))
    return values
