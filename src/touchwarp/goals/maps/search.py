"""The search for a map between two laid-out surfaces: several starts, coarse to fine."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from touchwarp.goals.maps.areas import polish_areas, target_shares
from touchwarp.goals.maps.base import Base
from touchwarp.goals.maps.composition import first_maps
from touchwarp.goals.maps.layout import Layout
from touchwarp.goals.maps.levels import Levels
from touchwarp.goals.maps.refine import Landmarks, MapProblem, Standing, Weights
from touchwarp.goals.surface_tree import SurfaceTree

Float = NDArray[np.float64]
Progress = Callable[[str, float], None]

COARSEST = 600
"""Vertices of the coarsest level; each next one has four times as many."""
GROWTH = 4
NEARLY_ALL = 0.5
"""A level with more than this part of all vertices is the whole mesh."""
COARSE_STEPS, MIDDLE_STEPS, FINE_STEPS = 60, 20, 6
SETTLING_ROUNDS = 20
COARSE_AREA_AIM = 0.03
FINE_HOLD = 100.0
"""Landmarks and the base count so much more from the second level on, when they are near already.
"""
NORMAL_SHARE = 0.3
"""Of normals beside positions, when first maps are compared."""


@dataclass(frozen=True)
class Plan:
    """What a search minimises, and how it gets there.

    Attributes:
        weights: of the energy at the end.
        area_path: weights of area that the coarsest level goes through first.
        starts: how many first maps are tried.
        seed: of everything random.
        field_path: weights of all fields, after these; a strong field from the start gets stuck.
    """

    weights: Weights
    area_path: Sequence[float]
    starts: int
    seed: int
    field_path: Sequence[float] = ()

    @property
    def easiest(self) -> Weights:
        """Those of the energy, but for its fields, which count as at the start of their path."""
        return replace(self.weights, fields=(*self.field_path, self.weights.fields)[0])

    def path(self) -> Iterator[Weights]:
        """The weights that the coarsest level goes through; those of the energy are the last."""
        for area in self.area_path:
            yield replace(self.easiest, area=area)
        for fields in (*self.field_path, self.weights.fields):
            yield replace(self.weights, fields=fields)

    @property
    def fine_weights(self) -> Weights:
        """The weights from the second level on."""
        own = self.weights
        return replace(own, landmarks=FINE_HOLD * own.landmarks, base=FINE_HOLD * own.base)


@dataclass(frozen=True, eq=False)
class Found:
    """The map found, as the prop's layout over the virtual surface's.

    Attributes:
        layout: the prop's mesh on the virtual layout's domain.
        energies: of each start at the coarsest level, in the order of first maps.
        size: m, the unit of length that the energies are in.
    """

    layout: Layout
    energies: list[float]
    size: float


@dataclass(frozen=True, eq=False)
class Pair:
    """Two laid-out surfaces, and what their map shall make equal.

    Attributes:
        prop, virtual: layouts on the same domain.
        fields: (n, c) prop, (k, c) virtual: scaled by the square roots of their weights.
        landmarks: (l, 2, 3) m, points of the prop and of the virtual surface.
        base: what both stand on, if that must stay.
    """

    prop: Layout
    virtual: Layout
    fields: tuple[Float, Float]
    landmarks: Float = field(default_factory=lambda: np.zeros((0, 2, 3)))
    base: Base | None = None

    def search(self, plan: Plan, progress: Progress | None = None) -> Found:
        """The best map found; see `search_map`."""
        return search_map(self, plan, progress)

    @property
    def size(self) -> float:
        """m: the mean of the roots of both areas."""
        return float(np.sqrt(self.prop.mesh.area) + np.sqrt(self.virtual.mesh.area)) / 2

    def places(self, layout: Layout) -> Float:
        """Positions of a layout's vertices about its surface's centre, in units of `size`."""
        whole = self.virtual if layout is self.virtual else self.prop
        return np.asarray((layout.mesh.vertices - whole.mesh.centre) / self.size)

    def problem(
        self, layout: Layout, chosen: NDArray[np.int64], density: Float | None = None
    ) -> MapProblem:
        """The problem on some vertices (k,) of the prop, with their mesh's layout."""
        return MapProblem(
            layout,
            self.virtual,
            (self.places(layout), self.places(self.virtual)),
            (self.fields[0][chosen], self.fields[1]),
            1 / self.size,
            self._landmarks_on(layout),
            self._standing(layout),
            density,
        )

    def _standing(self, layout: Layout) -> Standing | None:
        if self.base is None:
            return None
        height = (self.base.height - self.virtual.mesh.centre @ self.base.normal) / self.size
        return Standing(self.base.stands(layout.mesh.vertices), self.base.normal, float(height))

    def _landmarks_on(self, layout: Layout) -> Landmarks | None:
        if len(self.landmarks) == 0:
            return None
        mesh = layout.mesh
        tree = SurfaceTree(mesh.vertices, mesh.faces)
        nearest = tree.nearest(self.landmarks[:, 0])
        image = (self.landmarks[:, 1] - self.virtual.mesh.centre) / self.size
        return Landmarks(nearest.elements, tree.weights(nearest), image)


def search_map(pair: Pair, plan: Plan, progress: Progress | None = None) -> Found:
    """The best map of all starts, refined on the prop's whole mesh.

    Args:
        pair: the surfaces.
        plan: weights, starts and seed.
        progress: called with the step's name and the part of it that is done.
    """

    def tell(step: str, done: float) -> None:
        if progress is not None:
            progress(step, done)

    tell("first maps", 0.0)
    normals = [NORMAL_SHARE * layout.mesh.vertex_normals for layout in (pair.prop, pair.virtual)]
    firsts = first_maps(
        pair.prop,
        pair.virtual,
        np.concatenate([pair.places(pair.prop), normals[0]], axis=1),
        np.concatenate([pair.places(pair.virtual), normals[1]], axis=1),
        plan.seed,
        plan.starts,
    )
    tell("coarse maps", 0.0)
    coarse = []
    with ThreadPoolExecutor() as pool:
        for found in pool.map(lambda first: _coarse(pair, plan, first), firsts):
            coarse.append(found)
            tell("coarse maps", len(coarse) / len(firsts))
    energies = [energy for energy, _ in coarse]
    best = coarse[int(np.argmin(energies))][1]
    whole = len(pair.prop.points)
    while True:
        count = GROWTH * best.count
        best.put_back(whole if count > NEARLY_ALL * whole else count)
        chosen, layout = best.now()
        steps = FINE_STEPS if best.whole else MIDDLE_STEPS
        weights = plan.fine_weights
        problem = pair.problem(layout, chosen)
        layout = problem.settle(layout, weights, SETTLING_ROUNDS)
        layout = problem.refine(
            layout, weights, steps, progress=lambda done: tell("fine map", done)
        )
        best.points[chosen] = layout.points
        if best.whole:
            break
    tell("fine map", 1.0)
    return Found(best.whole_layout(), energies, pair.size)


def _coarse(pair: Pair, plan: Plan, first: Layout) -> tuple[float, Levels]:
    """A first map's coarsest level, refined along the plan's path, and its energy then."""
    levels = Levels(first, COARSEST)
    levels.relax(40)
    chosen, layout = levels.now()
    layout = polish_areas(layout, target_shares(layout.mesh.face_areas), COARSE_AREA_AIM)
    problem = pair.problem(layout, chosen)
    for weights in plan.path():
        layout = problem.refine(layout, weights, COARSE_STEPS)
    levels.points[chosen] = layout.points
    return problem.energy(layout, plan.weights), levels
