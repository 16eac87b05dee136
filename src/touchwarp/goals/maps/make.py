"""The kinds `area_preserving` and `match`: from a prop and a spec to a goal."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.fingertip_curvature import FINGERTIP_RADIUS, curvature_measures
from touchwarp.goals.goal import Goal
from touchwarp.goals.maps.areas import KEPT, polish_areas, spread, target_shares
from touchwarp.goals.maps.base import Base, find_base
from touchwarp.goals.maps.closed_mesh import ClosedMesh
from touchwarp.goals.maps.evening import Evened, even_areas
from touchwarp.goals.maps.hyperbolic.deck import Deck
from touchwarp.goals.maps.hyperbolic.layout import unplaced
from touchwarp.goals.maps.hyperbolic.marking import find_marking
from touchwarp.goals.maps.hyperbolic.parameterise import lay_out as lay_out_marked
from touchwarp.goals.maps.hyperbolic.search import MarkedPair
from touchwarp.goals.maps.layout import Layout
from touchwarp.goals.maps.linear_map import linear_map
from touchwarp.goals.maps.parameterise import check_topology, lay_out, work_mesh
from touchwarp.goals.maps.refine import Weights
from touchwarp.goals.maps.search import Found, Pair, Plan, Progress
from touchwarp.goals.maps.tidy import Tidied
from touchwarp.goals.maps.unsheared import unsheared
from touchwarp.goals.measure import measure_map
from touchwarp.goals.surface_tree import SurfaceTree
from touchwarp.scene.map_goals import AREA_WEIGHT, AreaPreservingGoal, MatchGoal
from touchwarp.scene.scene import Prop

Float = NDArray[np.float64]

TRANSPORT_AREA_WEIGHT = 20.0
"""Areas hardly change while transport is minimised; the polish does the rest."""
AREA_FACTOR, KEPT_AREA_FACTOR = 1.2, 1.02
"""By which faces may change ratios of area for being fewer: in any map, and where they are kept."""
TOLERANCE_PARTS = (1.0, 0.5, 0.25)
"""Tried in turn until no face, as it cuts across an edge, looks turned to the certificate."""
EASY_FIELDS, FIELD_GROWTH = 0.15, 3.0
"""Weight of all fields that first maps can be refined with, and by what it then grows each time."""
LAST_FIELD_PART = 0.7
LANDMARK_WEIGHT = 100.0
BASE_WEIGHT = 1e6
"""Holds what stands on the plane there; on fine levels, to 0.01 mm."""
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
    tidied, pair = _pair(prop, spec, np.zeros(2), np.zeros((0, 2, 3)), progress)
    plan = Plan(
        weights=Weights(displacement=1.0, area=TRANSPORT_AREA_WEIGHT),
        area_path=(2.0, 8.0),
        starts=spec.starts,
        seed=spec.seed,
    )
    found = pair.search(plan, progress)
    with ThreadPoolExecutor() as pool:
        one, other = pool.map(_areas_kept, _whole(tidied, found.layout, pair.virtual))
    return _goal(spec, pair, found, [(one, other)], _area_spread(one), start, progress)


def match_goal(prop: Prop, spec: MatchGoal, progress: Progress | None = None) -> Goal:
    """The one-to-one map of least displacement and most smoothness; see `maps.refine`.

    Raises:
        GoalError: the surfaces are not closed, or of different genus; a landmark is far from its
            surface; there is no base where one is asked for.
    """
    start = time.perf_counter()
    landmarks = np.array([(mark.prop, mark.virtual) for mark in spec.landmarks]).reshape(-1, 2, 3)
    tidied, pair = _pair(
        prop, spec, np.array([spec.normal_weight, spec.curvature_weight]), landmarks, progress
    )
    area_weight = AREA_WEIGHT if spec.area_weight is None else spec.area_weight
    plan = Plan(
        weights=Weights(
            displacement=spec.displacement_weight,
            smoothness=spec.smoothness_weight,
            area=area_weight,
            landmarks=LANDMARK_WEIGHT,
            base=BASE_WEIGHT,
        ),
        area_path=(max(2.0, area_weight), max(0.5, area_weight)),
        starts=spec.starts,
        seed=spec.seed,
        field_path=_field_path(spec.normal_weight + spec.curvature_weight),
    )
    found = pair.search(plan, progress)

    def make(layout: Layout, weights: Weights) -> Goal:
        choices = [(layout, pair.virtual)]
        if pair.prop.mesh.genus < 2:
            smooth = unsheared(pair, layout, weights)
            if smooth[0] is not layout:
                choices.insert(0, smooth)
        wholes = [_whole(tidied, *layouts) for layouts in choices]
        return _goal(spec, pair, found, wholes, _area_spread(layout), start, progress)

    if spec.weighs_by_default:
        evened = even_areas(pair, found.layout, plan.fine_weights, make)
    else:
        evened = Evened(make(found.layout, plan.fine_weights), area_weight, "weights are given")
    told = {"area_weight": evened.area_weight, "area_weight_reason": evened.reason}
    return replace(evened.goal, report={**evened.goal.report, **told})


def _field_path(weight: float) -> list[float]:
    """Parts of the fields' whole weight to go through before all of it."""
    path = []
    part = EASY_FIELDS / weight if weight > 0 else 1.0
    while part < LAST_FIELD_PART:
        path.append(part)
        part *= FIELD_GROWTH
    return path


def _whole(tidied: tuple[Tidied, Tidied], prop: Layout, virtual: Layout) -> tuple[Layout, Layout]:
    """The whole meshes' layouts, needles included."""
    if prop.mesh.genus > 1:
        return prop, virtual  # nothing was taken out of them
    return tidied[0].restore(prop), tidied[1].restore(virtual)


def _areas_kept(layout: Layout) -> Layout:
    return polish_areas(layout, target_shares(layout.mesh.face_areas), KEPT)


def _area_spread(layout: Layout) -> float:
    return spread(layout.shares, target_shares(layout.mesh.face_areas))


def _pair(
    prop: Prop,
    spec: AreaPreservingGoal | MatchGoal,
    field_weights: Float,
    landmarks: Float,
    progress: Progress | None,
) -> tuple[tuple[Tidied, Tidied], Pair]:
    """Both surfaces without needles, then laid out, with the fields that have a weight."""
    # What takes long for a surface lets go of the interpreter's lock: both are worked on at once.
    with ThreadPoolExecutor() as pool:
        one, other = pool.map(
            work_mesh, (prop.surface, spec.virtual), ("the prop", "the virtual object")
        )
    tidied = one, other
    meshes = tidied[0].mesh, tidied[1].mesh
    check_topology(*meshes, spec.kind)
    handles = meshes[0].genus > 1
    if handles:
        meshes = tidied[0].whole, tidied[1].whole
    if progress is not None:
        progress("laying the surfaces out", 0.0)
    with ThreadPoolExecutor() as pool:
        if handles:
            markings = [find_marking(mesh) for mesh in meshes]
        else:
            layouts = list(pool.map(lay_out, meshes))
        fields = list(pool.map(lambda mesh: _fields(mesh, *field_weights), meshes))
    placed = [
        _on_surface(mesh, landmarks[:, k], what)
        for k, (mesh, what) in enumerate(zip(meshes, ("prop", "virtual object"), strict=True))
    ]
    base: Base | None = None
    if isinstance(spec, MatchGoal) and spec.base is not None:
        base = find_base(tidied[0].whole, tidied[1].whole, np.array(spec.base))
    marks = np.stack(placed, axis=1)
    rest = (fields[0], fields[1]), marks, base
    if handles:
        deck = Deck(meshes[0].genus)
        virtual = lay_out_marked(markings[1], deck)
        marked = MarkedPair(
            unplaced(meshes[0], deck),
            virtual,
            *rest,
            marking=markings[0],
            virtual_marking=markings[1],
        )
        return tidied, marked
    return tidied, Pair(layouts[0], layouts[1], *rest)


def _fields(mesh: ClosedMesh, normal_weight: float, curvature_weight: float) -> Float:
    """(n, c): normals, and curvatures in units of the fingertip's, each by its weight's root."""
    columns = [np.zeros((len(mesh.vertices), 0))]
    if normal_weight > 0:
        columns.append(np.sqrt(normal_weight) * mesh.vertex_normals)
    if curvature_weight > 0:
        measures = curvature_measures(mesh.vertices, mesh.faces)
        for radius in (FINGERTIP_RADIUS, 2 * FINGERTIP_RADIUS):
            felt = measures.over(radius)
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
    choices: list[tuple[Layout, Layout]],
    area_spread: float,
    start: float,
    progress: Progress | None,
) -> Goal:
    """The goal on triangles fine enough for the tolerance, with its report.

    Of the layouts to choose from, the first that give no face that looks turned are taken; if all
    do, those that give the fewest.
    """
    if progress is not None:
        progress("cutting the surfaces along one another", 0.0)
    tree = SurfaceTree(spec.virtual.vertices, spec.virtual.faces)
    pairs = pair.landmarks if len(pair.landmarks) else None
    area_factor = AREA_FACTOR if isinstance(spec, MatchGoal) else KEPT_AREA_FACTOR
    fewest = np.inf
    for layouts, part in product(choices, TOLERANCE_PARTS):
        points, images, faces = linear_map(*layouts, part * spec.tolerance_mm * 1e-3, area_factor)
        images = tree.nearest(images).points  # rounding in needles
        tried = Goal(points, images, faces, spec.kind, {}, None, spec.virtual, pairs)
        summary = measure_map(tried).summary()
        if summary["flips"] < fewest:
            fewest, goal, measured, (layout, virtual) = summary["flips"], tried, summary, layouts
        if fewest == 0:
            break
    report: dict[str, Any] = {
        **measured,
        "domain": ("sphere", "torus", "hyperbolic")[min(layout.mesh.genus, 2)],
        "domain_flips": int((layout.shares <= 0).sum() + (virtual.shares <= 0).sum()),
        "domain_area_std": area_spread,
        "transport_cost_m2": _transport_cost(layout, virtual),
        "start_energies": found.energies,
        "image_distance_max": measured["distance_max"],
        "seconds": time.perf_counter() - start,
    }
    return replace(goal, report=report)


def _transport_cost(layout: Layout, virtual: Layout) -> float:
    """m²: the mean of |g − x|² over the prop's area."""
    locator = virtual.locator()
    locator.find(layout.points)
    moved = locator.values(virtual.mesh.vertices) - layout.mesh.vertices
    return float(layout.mesh.vertex_areas @ (moved**2).sum(axis=1) / layout.mesh.area)
