"""First maps between two layouts: turns of the sphere, or shifts and the half turn of the torus."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.goals.maps.layout import Layout
from touchwarp.goals.maps.locate import Locator

SAMPLES = 300
TURNS = 1200
SHIFTS = 24
NORMAL_SHARE = 0.1
"""How much a difference of normals counts beside one of position, in the surfaces' size."""


def first_maps(
    prop: Layout,
    virtual: Layout,
    prop_fields: NDArray[np.float64],
    virtual_fields: NDArray[np.float64],
    seed: int,
    count: int,
) -> list[Layout]:
    """The prop's layout placed over the virtual one's in the `count` best ways, best first.

    The ways differ from one another clearly; all keep areas.

    Args:
        prop, virtual: layouts on the same domain.
        prop_fields, virtual_fields: (n, c) what the map shall make equal, of like scale.
        seed: of the turns that are tried.
        count: how many to return, ≥ 1.
    """
    rng = np.random.default_rng(seed)
    areas = prop.mesh.vertex_areas
    sample = rng.choice(len(areas), size=SAMPLES, p=areas / areas.sum())
    candidates = _shifts() if prop.flat else _turns(rng)
    locator = Locator(virtual)
    placed = np.einsum("kij,sj->ksi", candidates, prop.points[sample])
    locator.find(placed.reshape(-1, 3))
    seen = locator.values(virtual_fields).reshape(*placed.shape[:2], -1)
    costs = ((seen - prop_fields[sample]) ** 2).sum(axis=2).mean(axis=1)
    chosen: list[int] = []
    for k in np.argsort(costs):
        if all(_apart(candidates[k], candidates[j], prop.flat) for j in chosen):
            chosen.append(int(k))
        if len(chosen) == count:
            break
    return [_placed(prop, candidates[k]) for k in chosen]


def _placed(layout: Layout, matrix: NDArray[np.float64]) -> Layout:
    """The layout under a matrix of the domain; a half turn of the torus also turns the lattice."""
    return Layout(
        layout.mesh,
        layout.points @ matrix.T,
        layout.corner_shift * (matrix[0, 0] if layout.flat else 1.0),
    )


def _turns(rng: np.random.Generator) -> NDArray[np.float64]:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.random(TURNS, random_state=rng).as_matrix())


def _shifts() -> NDArray[np.float64]:
    """(s, 3, 3): shifts of the torus on a grid, each with and without the half turn."""
    i, j, sign = np.meshgrid(np.arange(SHIFTS), np.arange(SHIFTS), [1.0, -1.0], indexing="ij")
    matrices = np.zeros((i.size, 3, 3))
    matrices[:, 0, 0] = matrices[:, 1, 1] = sign.ravel()
    matrices[:, 0, 2], matrices[:, 1, 2] = i.ravel() / SHIFTS, j.ravel() / SHIFTS
    matrices[:, 2, 2] = 1.0
    return matrices


def _apart(one: NDArray[np.float64], other: NDArray[np.float64], flat: bool) -> bool:
    """Whether two ways differ by 30°, by an eighth of the torus, or by the half turn."""
    if not flat:
        return bool(np.trace(one.T @ other) < 1 + 2 * np.cos(np.pi / 6))
    gap = (one - other)[:2, 2]
    gap -= np.rint(gap)
    return bool(one[0, 0] != other[0, 0] or np.abs(gap).max() > 0.125)
