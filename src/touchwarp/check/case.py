"""What every check is given: scene, warp, goals, Ω, and the samples they share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from touchwarp.check.brick_faces import cell_sides
from touchwarp.check.contradiction import Contradiction, find_contradictions
from touchwarp.check.probes import Probes, place_probes
from touchwarp.check.region import Body, Region, make_body
from touchwarp.check.report import Check
from touchwarp.goals.goal import Goal
from touchwarp.goals.measure import MapMeasures, measure_map
from touchwarp.goals.surface_samples import (
    SharpEdges,
    SurfaceSamples,
    face_areas,
    find_sharp_edges,
    sample_surface,
)
from touchwarp.scene.scene import Scene
from touchwarp.warp.bricks import Bricks
from touchwarp.warp.meta import WarpMeta
from touchwarp.warp.protocol import Warp

Float = NDArray[np.float64]

EDGE_SAMPLES = 100_000

ON_PLANE = 5e-6
"""m: a foot nearer than this to a fixed plane lies on it."""


class Finding(NamedTuple):
    """What one family of checks found.

    Attributes:
        checks: its checks, in reading order.
        shown: the arrays that the page draws of it, by name.
    """

    checks: list[Check]
    shown: dict[str, Any]


@dataclass(frozen=True, eq=False)
class PropCase:
    """One prop with its goal, its samples and its two surfaces.

    Attributes:
        name: the prop's.
        goal: g on it.
        samples: of its surface, uniform in area.
        edges: its sharp edges and rims.
        body: its surface.
        area: m², of its surface.
    """

    name: str
    goal: Goal
    samples: SurfaceSamples
    edges: SharpEdges
    body: Body
    area: float

    @cached_property
    def virtual(self) -> Body:
        """The virtual object's surface, taken as closed where the prop's is."""
        body = Body(self.name, self.goal.virtual_points, self.goal.faces, closed=self.body.closed)
        if self.goal.matrix is not None and np.linalg.det(self.goal.matrix) < 0:
            body.outward = -self.body.outward
        else:
            body.outward = self.body.outward
        return body

    @cached_property
    def boundary_maximum(self) -> float:
        """Greatest |u| asked for on this prop, m: at a vertex, since g is linear on faces."""
        used = np.unique(self.goal.faces)
        return float(np.linalg.norm(self.goal.displacement[used], axis=1).max())


@dataclass(frozen=True, eq=False)
class Case:
    """A scene and a warp to be checked.

    Attributes:
        scene: as read.
        warp: any warp, in the scene's frame.
        meta: what the warp says of itself; None for warps without a file.
        props: in the scene's order.
        region: Ω.
        tolerance: m.
        edge_radius: m, of the tube around sharp edges where the exact warp is singular.
        screening: λ in m⁻².
        seed: of all samples.
    """

    scene: Scene
    warp: Warp
    meta: WarpMeta | None
    props: tuple[PropCase, ...]
    region: Region
    tolerance: float
    edge_radius: float
    screening: float
    seed: int

    @property
    def dimension(self) -> int:
        """3, or 2 in a plane scene."""
        return int(self.region.box.shape[1])

    @property
    def boundary_maximum(self) -> float:
        """Greatest |u| on the boundary of Ω, m."""
        return max(p.boundary_maximum for p in self.props)

    def random(self, family: str) -> np.random.Generator:
        """A family's own random numbers: adding a family changes no other's samples."""
        return np.random.default_rng([self.seed, *family.encode()])

    def contact_error(self, points: Float, targets: Float) -> Float:
        """(n,) m: |f − g| at (n, d) points with goals `targets`; inf where f is not finite."""
        if len(points) == 0:
            return np.zeros(0)
        error: Float = np.linalg.norm(self.warp(points) - targets, axis=1)
        return np.where(np.isfinite(error), error, np.inf)

    @cached_property
    def contact_errors(self) -> dict[str, Float]:
        """By prop, (n,) m: the contact error at its surface samples."""
        return {p.name: self.contact_error(p.samples.points, p.samples.targets) for p in self.props}

    @cached_property
    def edge_contact(self) -> dict[str, tuple[Float, Float]]:
        """By prop, samples (n, d) m of its sharp edges and rims, and their contact error (n,) m."""
        found = {}
        for prop in self.props:
            rng = self.random("edges " + prop.name)
            points, targets = prop.edges.sample(prop.goal, EDGE_SAMPLES, rng)
            found[prop.name] = points, self.contact_error(points, targets)
        return found

    @cached_property
    def contradictions(self) -> dict[str, tuple[Contradiction, ...]]:
        """By prop, the fixed surfaces that forbid its goal where they touch it."""
        return {
            p.name: find_contradictions(self.scene, self.region, p.samples, self.tolerance)
            for p in self.props
        }

    def contradicted(self, prop: PropCase, points: Float) -> NDArray[np.bool_]:
        """(n,) whether at (n, d) points of a prop its goal gives way to a fixed surface."""
        given = np.zeros(len(points), bool)
        for contradiction in self.contradictions[prop.name]:
            given |= contradiction.at(points)
        return given

    @cached_property
    def greatest_contact_error(self) -> float:
        """m: on surfaces in reach and sharp edges, where no fixed surface forbids the goal."""
        greatest = 0.0
        for prop in self.props:
            reached = ~self.standing[prop.name]
            on_surface = prop.samples.points[reached], self.contact_errors[prop.name][reached]
            for points, error in (on_surface, self.edge_contact[prop.name]):
                kept = error[~self.contradicted(prop, points)]
                greatest = max(greatest, float(kept.max(initial=0.0)))
        return greatest

    @cached_property
    def standing(self) -> dict[str, NDArray[np.bool_]]:
        """By prop, (n,): samples of a closed prop's foot, where it lies in a fixed plane.

        No hand comes between the two. An open sheet that lies there is touched from above.
        """
        return {p.name: self._standing(p) for p in self.props}

    def _standing(self, prop: PropCase) -> NDArray[np.bool_]:
        points, outward = prop.samples.points, prop.body.outward * prop.samples.normals
        found = np.zeros(len(points), dtype=np.bool_)
        if prop.body.closed:
            for point, normal in self.region.planes:
                on = np.abs((points - point) @ normal) < ON_PLANE
                found |= on & (outward @ normal < -0.5)
        return found & ~found.all()  # what lies there whole is touched from above

    @cached_property
    def maps(self) -> dict[str, MapMeasures]:
        """By prop, what was measured of its goal, for goals that map one shape to another."""
        if self.dimension != 3:
            return {}
        return {
            p.name: measure_map(p.goal, seed=self.seed) for p in self.props if p.goal.matrix is None
        }

    @cached_property
    def surface_cell(self) -> float:
        """m: the diagonal of the largest cell of the table at a prop; 2 mm without a table."""
        return self.cell_at(np.concatenate([p.samples.points[::20] for p in self.props]))

    def cell_at(self, points: Float) -> float:
        """m: the diagonal of the largest of the table's cells at (n, 3) m, scene frame; or 2 mm."""
        bricks = getattr(self.warp, "bricks", None)
        if not isinstance(bricks, Bricks):
            return 2e-3
        return float(np.linalg.norm(cell_sides(bricks, points), axis=1).max())

    @cached_property
    def probes(self) -> Probes:
        """Sample points of Ω with u and ∂f."""
        points, side = place_probes(
            self.region,
            tuple(p.samples for p in self.props),
            tuple(p.area for p in self.props),
            self.random("probes"),
        )
        return Probes(
            points,
            side**self.dimension,
            side,
            self.warp.displacement(points),
            self.warp.jacobian(points),
        )


def open_case(
    scene: Scene,
    warp: Warp,
    goals: Mapping[str, Goal],
    box: Float,
    meta: WarpMeta | None,
    *,
    samples: int,
    seed: int,
) -> Case:
    """Sample the props and lay out Ω.

    Args:
        scene: as read.
        warp: in the scene's frame.
        goals: by prop.
        box: (2, d) m, ∂Ω1 or its bounds.
        meta: what the warp says of itself, where it says anything.
        samples: surface samples, shared equally by the props.
        seed: of all samples.
    """
    share = -(-samples // len(scene.props))
    props = []
    for number, prop in enumerate(scene.props):
        goal = goals[prop.name]
        taken = sample_surface(goal, share, np.random.default_rng([seed, number]))
        props.append(
            PropCase(
                prop.name,
                goal,
                taken,
                find_sharp_edges(goal.prop_points, goal.faces),
                make_body(prop.name, goal.prop_points, goal.faces, taken),
                float(face_areas(goal.prop_points, goal.faces).sum()),
            )
        )
    outer = scene.outer.surface
    region = Region(
        props=tuple(p.body for p in props),
        holds=tuple(
            make_body(f.name, f.surface.vertices, f.surface.faces, None)
            for f in scene.fixed
            if f.surface is not None
        ),
        planes=tuple(
            (np.asarray(f.plane[0]), np.asarray(f.plane[1]))
            for f in scene.fixed
            if f.plane is not None
        ),
        box=np.asarray(box, float),
        outer=None if outer is None else make_body("outer", outer.vertices, outer.faces, None),
    )
    objective = scene.objective
    return Case(
        scene=scene,
        warp=warp,
        meta=meta,
        props=tuple(props),
        region=region,
        tolerance=1e-3 * (objective.tolerance_mm if meta is None else meta.tolerance_mm),
        edge_radius=1e-3 * (objective.edge_radius_mm if meta is None else meta.edge_radius_mm),
        screening=objective.screening if meta is None else meta.screening,
        seed=seed,
    )
