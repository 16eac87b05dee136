"""The kinds `area_preserving` and `match`: from a prop and a spec to a goal."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.fingertip_curvature import FINGERTIP_RADIUS, fingertip_curvature
from touchwarp.goals.goal import Goal
from touchwarp.goals.maps.areas import polish_areas, spread, target_shares
from touchwarp.goals.maps.base import Base, find_base
from touchwarp.goals.maps.closed_mesh import ClosedMesh
from touchwarp.goals.maps.fit_triangles import fit_triangles
from touchwarp.goals.maps.hyperbolic.deck import Deck
from touchwarp.goals.maps.hyperbolic.layout import HyperbolicLayout, unplaced
from touchwarp.goals.maps.hyperbolic.marking import find_marking
from touchwarp.goals.maps.hyperbolic.overlay import overlay
from touchwarp.goals.maps.hyperbolic.parameterise import fine_mesh
from touchwarp.goals.maps.hyperbolic.parameterise import lay_out as lay_out_marked
from touchwarp.goals.maps.hyperbolic.search import MarkedPair, search_classes
from touchwarp.goals.maps.layout import Layout, triangle_areas
from touchwarp.goals.maps.parameterise import check_topology, lay_out, work_mesh
from touchwarp.goals.maps.refine import Weights
from touchwarp.goals.maps.search import Found, Pair, Plan, Progress, search_map
from touchwarp.goals.measure import measure_map
from touchwarp.goals.surface_tree import SurfaceTree
from touchwarp.scene.map_goals import AreaPreservingGoal, MatchGoal
from touchwarp.scene.scene import Prop

Float = NDArray[np.float64]

TRANSPORT_AREA_WEIGHT = 20.0
"""Areas hardly change while transport is minimised; the polish does the rest."""
AREA_AIM = 4e-3
LANDMARK_WEIGHT = 100.0
BASE_WEIGHT = 1e6
"""Holds what stands on the plane within hundredths of a millimetre; then it is put there."""
LANDMARK_REACH = 0.02
"""Landmarks farther from their surface than this part of its diagonal are taken for mistakes."""


def area_preserving_goal(
    prop: Prop, spec: AreaPreservingGoal, progress: Progress | None = None
) -> Goal:
    """The map that keeps shares of area and, of those, moves mass least (optimal transport).

    Raises:
        GoalError: the surfaces are not closed, or of different genus.
    """
    start = time.perf_counter()
    pair = _pair(prop, spec, np.zeros(2), np.zeros((0, 2, 3)), progress)
    plan = Plan(
        weights=Weights(displacement=1.0, area=TRANSPORT_AREA_WEIGHT),
        area_path=(2.0, 8.0),
        starts=spec.starts,
        seed=spec.seed,
    )
    found = _search(pair, plan, progress)
    layout = polish_areas(found.layout, target_shares(pair.prop.mesh.face_areas), AREA_AIM)
    return _goal(spec, pair, Found(layout, found.energies, found.size), start, progress)


def match_goal(prop: Prop, spec: MatchGoal, progress: Progress | None = None) -> Goal:
    """The one-to-one map of least displacement and most smoothness; see `maps.refine`.

    Raises:
        GoalError: the surfaces are not closed, or of different genus; a landmark is far from its
            surface; there is no base where one is asked for.
    """
    start = time.perf_counter()
    landmarks = np.array([(mark.prop, mark.virtual) for mark in spec.landmarks]).reshape(-1, 2, 3)
    pair = _pair(
        prop, spec, np.array([spec.normal_weight, spec.curvature_weight]), landmarks, progress
    )
    plan = Plan(
        weights=Weights(
            displacement=spec.displacement_weight,
            smoothness=spec.smoothness_weight,
            area=spec.area_weight,
            landmarks=LANDMARK_WEIGHT,
            base=BASE_WEIGHT,
        ),
        area_path=(max(2.0, spec.area_weight), max(0.5, spec.area_weight)),
        starts=spec.starts,
        seed=spec.seed,
    )
    return _goal(spec, pair, _search(pair, plan, progress), start, progress)


def _search(pair: Pair, plan: Plan, progress: Progress | None) -> Found:
    if isinstance(pair, MarkedPair):
        return search_classes(pair, plan, progress)
    return search_map(pair, plan, progress)


def _pair(
    prop: Prop,
    spec: AreaPreservingGoal | MatchGoal,
    field_weights: Float,
    landmarks: Float,
    progress: Progress | None,
) -> Pair:
    """Both surfaces laid out, with the fields that have a weight: normals, curvature."""
    meshes = (work_mesh(prop.surface, "the prop"), work_mesh(spec.virtual, "the virtual object"))
    check_topology(*meshes, spec.kind)
    handles = meshes[0].genus > 1
    if handles:
        meshes = fine_mesh(prop.surface, "the prop"), fine_mesh(spec.virtual, "the virtual object")
    layouts, markings = [], []
    for k, mesh in enumerate(meshes):
        if progress is not None:
            progress("laying the surfaces out", k / 2)
        if handles:
            markings.append(find_marking(mesh))
        else:
            layouts.append(lay_out(mesh))
    fields = [_fields(mesh, *field_weights) for mesh in meshes]
    placed = [
        _on_surface(mesh, landmarks[:, k], what)
        for k, (mesh, what) in enumerate(zip(meshes, ("prop", "virtual object"), strict=True))
    ]
    base: Base | None = None
    if isinstance(spec, MatchGoal) and spec.base is not None:
        base = find_base(meshes[0], spec.virtual, np.array(spec.base))
    rest = (fields[0], fields[1]), np.stack(placed, axis=1), base
    if handles:
        deck = Deck(meshes[0].genus)
        virtual = lay_out_marked(markings[1], deck)
        return MarkedPair(unplaced(meshes[0], deck), virtual, *rest, marking=markings[0])
    return Pair(layouts[0], layouts[1], *rest)


def _fields(mesh: ClosedMesh, normal_weight: float, curvature_weight: float) -> Float:
    """(n, c): normals, and curvatures in units of the fingertip's, each by its weight's root."""
    columns = [np.zeros((len(mesh.vertices), 0))]
    if normal_weight > 0:
        columns.append(np.sqrt(normal_weight) * mesh.vertex_normals)
    if curvature_weight > 0:
        for radius in (FINGERTIP_RADIUS, 2 * FINGERTIP_RADIUS):
            felt = fingertip_curvature(mesh.vertices, mesh.faces, radius)
            columns.append(np.sqrt(curvature_weight) * FINGERTIP_RADIUS * felt.mean[:, None])
    return np.concatenate(columns, axis=1)


def _on_surface(mesh: ClosedMesh, points: Float, what: str) -> Float:
    """The nearest points (l, 3) of a surface; raises where one is far from it."""
    if len(points) == 0:
        return points
    nearest = SurfaceTree(mesh.vertices, mesh.faces).nearest(points)
    worst = int(nearest.distance.argmax())
    if nearest.distance[worst] > LANDMARK_REACH * mesh.diagonal:
        raise GoalError(
            f"landmark {worst + 1} lies {nearest.distance[worst] * 1e3:.3g} mm from the {what}, "
            f"where a point of its surface is needed (up to {100 * LANDMARK_REACH:g} % of its "
            "diagonal off): give it in metres, in the scene's frame, after posing."
        )
    return nearest.points


def _goal(
    spec: AreaPreservingGoal | MatchGoal,
    pair: Pair,
    found: Found,
    start: float,
    progress: Progress | None,
) -> Goal:
    """The goal on triangles fine enough for the tolerance, with its report."""
    layout, virtual = found.layout, pair.virtual
    if progress is not None:
        progress("fitting triangles to the virtual surface", 0.0)
    searched = time.perf_counter()
    points, images, faces, told = _on_triangles(spec, pair, layout)
    pairs = pair.landmarks if len(pair.landmarks) else None
    goal = Goal(
        prop_points=points,
        virtual_points=images,
        faces=faces,
        kind=spec.kind,
        virtual_surface=spec.virtual,
        landmarks=pairs,
    )
    report: dict[str, Any] = {
        **measure_map(goal).summary(),
        **told,
        "domain_area_std": spread(layout.shares, target_shares(layout.mesh.face_areas)),
        "transport_cost_m2": _transport_cost(layout, virtual),
        "start_energies": found.energies,
        "search_seconds": searched - start,
        "seconds": time.perf_counter() - start,
    }
    return Goal(points, images, faces, spec.kind, report, None, spec.virtual, pairs)


def _on_triangles(
    spec: AreaPreservingGoal | MatchGoal, pair: Pair, layout: Layout
) -> tuple[Float, Float, NDArray[np.int64], dict[str, Any]]:
    """Points, images and faces of the map, and what the report says of them."""
    virtual, base = pair.virtual, pair.base
    if isinstance(layout, HyperbolicLayout) and isinstance(virtual, HyperbolicLayout):
        cells = overlay(layout, virtual)
        images = cells.images
        if base is not None:
            on_base = base.standing[layout.mesh.faces[cells.prop_face]].all(axis=1)
            standing = np.unique(cells.faces[on_base])
            images[standing] = base.tree.nearest(images[standing]).points
        tree = SurfaceTree(spec.virtual.vertices, spec.virtual.faces)
        middles = images[cells.faces].mean(axis=1)
        return (
            cells.points,
            images,
            cells.faces,
            {
                "domain": "hyperbolic",
                "domain_flips": int((layout.shares <= 0).sum() + (virtual.shares <= 0).sum()),
                "image_distance_max": float(tree.nearest(middles).distance.max()),
                "subdivision_capped": False,
            },
        )
    fine = fit_triangles(layout, virtual, spec.virtual, spec.tolerance_mm * 1e-3, base)
    areas = triangle_areas(fine.places, fine.faces, fine.corner_shift, layout.flat)
    told = {
        "domain": "torus" if layout.flat else "sphere",
        "domain_flips": int((areas <= 0).sum()),
        "image_distance_max": fine.distance,
        "subdivision_capped": fine.capped,
    }
    return fine.points, fine.images, fine.faces, told


def _transport_cost(layout: Layout, virtual: Layout) -> float:
    """m²: the mean of |g − x|² over the prop's area."""
    locator = virtual.locator()
    locator.find(layout.points)
    moved = locator.values(virtual.mesh.vertices) - layout.mesh.vertices
    return float(layout.mesh.vertex_areas @ (moved**2).sum(axis=1) / layout.mesh.area)
