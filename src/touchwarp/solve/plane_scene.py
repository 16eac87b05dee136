"""From a plane scene and its goals to the plane solver's problem, in the table frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import SolveError
from touchwarp.goals.goal import Goal
from touchwarp.scene.scene import Fixed, Scene
from touchwarp.solve.plane import PlaneProblem
from touchwarp.solve.plane_cuts import Curves
from touchwarp.solve.plane_grid import PlaneFeatures

SHARP_DEG = 20.0
"""A vertex at which a prop's outline turns by more is a corner."""

TOUCHING = 1e-6
"""m: a prop this near to a fixed line stands on it."""

PIECES_PER_BLEND = 16
"""Segments are split to this part of `blend_mm` where a goal must bend to a fixed line."""


@dataclass(frozen=True, eq=False)
class PlaneScene:
    """The problem and what is needed to make a warp of its solution.

    Attributes:
        problem: in the table frame.
        T_scene_table: (3, 3) rigid. A sliding line is y = 0 of the table frame.
        outer: (k, 2, 2) m, table frame: the outer polygon's segments; none where ∂Ω1 is the box.
        mirror_depth: m, how deep Ω goes on under a sliding line; None without one.
        contradiction_mm: the greatest displacement asked for where a fixed line forbids it.
    """

    problem: PlaneProblem
    T_scene_table: NDArray[np.float64]
    outer: NDArray[np.float64]
    mirror_depth: float | None
    contradiction_mm: float


@dataclass
class _Curve:
    points: NDArray[np.float64]
    segments: NDArray[np.int64]
    displacement: NDArray[np.float64]


def place_plane_scene(
    scene: Scene, goals: Mapping[str, Goal], outer_box: NDArray[np.float64]
) -> PlaneScene:
    """Turn a plane scene to the frame that it is solved in.

    Args:
        scene: of dimension 2.
        goals: one for each prop.
        outer_box: (2, 2) m, scene frame: the box of ∂Ω1, or the bounds of its polygon.
    Raises:
        SolveError: the scene is not plane, or the sliding line leaves no prop above it.
    """
    if scene.dimension != 2:
        raise SolveError(
            f"The scene has dimension {scene.dimension}; the plane solver needs 2: call solve, "
            "which chooses by dimension."
        )
    T_scene_table, slide = _table_frame(scene)
    rotation, origin = T_scene_table[:2, :2], T_scene_table[:2, 2]
    props = [
        _Curve((goal.prop_points - origin) @ rotation, goal.faces, goal.displacement @ rotation)
        for goal in goals.values()
    ]
    corners = [find_corners(p.points, p.segments) for p in props]
    features = PlaneFeatures(
        bounds=np.array([[p.points.min(axis=0), p.points.max(axis=0)] for p in props]),
        corners=np.concatenate(corners),
        owner=np.repeat(np.arange(len(props)), [len(c) for c in corners]),
    )
    outer = _outer_segments(scene, outer_box, T_scene_table)
    box = np.stack([outer.min(axis=(0, 1)), outer.max(axis=(0, 1))])
    if np.abs(np.abs(rotation).max(axis=0) - 1.0).max() < 1e-12 and scene.outer.surface is None:
        outer = np.empty((0, 2, 2))  # the box's sides are grid lines
    else:
        box += 0.02 * (box[1] - box[0]) * np.array([[-1.0], [1.0]])
    mirror_depth = None
    if slide is not None:
        if features.bounds[:, 1, 1].max() <= 0.0 or box[1, 1] <= 0.0:
            raise SolveError(
                f"No prop lies above the sliding line '{slide.name}'; props must be on the side "
                "that its normal points to: turn the normal round."
            )
        mirror_depth = max(0.0, -float(box[0, 1]))
        box[0, 1] = 0.0
    contradiction = 0.0
    held = [f for f in scene.fixed if f is not slide]
    for fixed in scene.fixed:
        if fixed.plane is None:
            continue
        point, normal = (np.asarray(v) for v in fixed.plane)
        line = (point - origin) @ rotation, normal @ rotation
        for prop in props:
            asked = blend_contact(prop, line, 1e-3 * fixed.blend_mm, fixed is slide)
            contradiction = max(contradiction, asked)
    still = [_held_curve(f, T_scene_table, box) for f in held]
    if len(outer):
        ends = np.arange(2 * len(outer)).reshape(-1, 2)
        still.append(_Curve(outer.reshape(-1, 2), ends, np.zeros((2 * len(outer), 2))))
    curves = _join([*props, *still])
    count = len(curves.segments)
    problem = PlaneProblem(
        box=box,
        features=features,
        curves=curves,
        outer=np.arange(count - len(outer), count),
        screening=scene.objective.screening,
        mirrored=slide is not None,
    )
    return PlaneScene(problem, T_scene_table, outer, mirror_depth, 1e3 * contradiction)


def find_corners(points: NDArray[np.float64], segments: NDArray[np.int64]) -> NDArray[np.float64]:
    """Sharp corners, loose ends and branchings of an outline: (c, 2) m.

    Args:
        points: (n, 2) m.
        segments: (m, 2); vertices in the same place count as one.
    """
    places, index = np.unique(np.rint(points * 1e9), axis=0, return_inverse=True)
    ends = index.ravel()[segments]
    ends = ends[ends[:, 0] != ends[:, 1]]
    directions = places[ends[:, 1]] - places[ends[:, 0]]
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    degree = np.bincount(ends.ravel(), minlength=len(places))
    leaving = np.zeros((len(places), 2))  # unit vectors away from a vertex: they cancel if straight
    np.add.at(leaving, ends[:, 0], directions)
    np.add.at(leaving, ends[:, 1], -directions)
    turn = 2.0 * np.sin(np.radians(SHARP_DEG) / 2.0)
    sharp = (degree > 0) & ((degree != 2) | (np.linalg.norm(leaving, axis=1) > turn))
    return np.asarray(places[sharp] * 1e-9)


def blend_contact(
    curve: _Curve,
    line: tuple[NDArray[np.float64], NDArray[np.float64]],
    width: float,
    sliding: bool,
) -> float:
    """Bend a goal to a fixed line that its prop stands on, over a width in m.

    What the goal asks for at the contact and the line forbids (all of it, or under a sliding line
    its normal component) is taken off, in full at the line and fading to nothing at `width`.

    Returns:
        the greatest displacement that was forbidden, m; where it is 0 nothing changes.
    """
    point, normal = line
    tangent = np.array([normal[1], -normal[0]])
    touching = np.abs((curve.points - point) @ normal) <= TOUCHING
    forbidden = curve.displacement[touching]
    if sliding:
        forbidden = (forbidden @ normal)[:, None] * normal
    contradiction = float(np.linalg.norm(forbidden, axis=1).max(initial=0.0))
    if contradiction < 1e-9:
        return 0.0
    along = (curve.points[touching] - point) @ tangent
    order = np.argsort(along)
    _split_near(curve, line, width)
    distance = np.abs((curve.points - point) @ normal)
    fraction = np.clip(distance / max(width, TOUCHING), 0.0, 1.0)
    keep = 1.0 - fraction**2 * (3.0 - 2.0 * fraction)
    foot = (curve.points - point) @ tangent
    for axis in range(2):
        wrong = np.interp(foot, along[order], forbidden[order, axis])
        curve.displacement[:, axis] -= keep * wrong
    return contradiction


def _split_near(
    curve: _Curve, line: tuple[NDArray[np.float64], NDArray[np.float64]], width: float
) -> None:
    """Split the segments that come within `width` of a line into short ones."""
    point, normal = line
    start, stop = curve.segments.T
    distance = np.abs((curve.points - point) @ normal)
    near = np.minimum(distance[start], distance[stop]) < width
    length = np.linalg.norm(curve.points[stop] - curve.points[start], axis=1)
    step = max(width, TOUCHING) / PIECES_PER_BLEND
    pieces = np.where(near, np.ceil(length / step), 1.0).astype(np.int64)
    pieces = np.clip(pieces, 1, 4096)
    rows = np.repeat(np.arange(len(start)), pieces)
    number = np.arange(len(rows)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    ends = []
    for value in (curve.points, curve.displacement):
        span = (value[stop] - value[start])[rows]
        ends.append(
            [value[start][rows] + span * ((number + k) / pieces[rows])[:, None] for k in (0, 1)]
        )
    (low, high), (low_moved, high_moved) = ends
    count = len(rows)
    curve.points = np.concatenate([low, high])
    curve.displacement = np.concatenate([low_moved, high_moved])
    curve.segments = np.stack([np.arange(count), np.arange(count) + count], axis=1)


def _table_frame(scene: Scene) -> tuple[NDArray[np.float64], Fixed | None]:
    """The scene's own frame, or one whose y axis is the sliding line's normal."""
    T_scene_table = np.eye(3)
    slide = scene.slide_plane
    if slide is not None and slide.plane is not None:
        point, normal = (np.asarray(v, dtype=np.float64) for v in slide.plane)
        T_scene_table[:2, :2] = np.array([[normal[1], normal[0]], [-normal[0], normal[1]]])
        T_scene_table[:2, 2] = point
    return T_scene_table, slide


def _outer_segments(
    scene: Scene, outer_box: NDArray[np.float64], T_scene_table: NDArray[np.float64]
) -> NDArray[np.float64]:
    """∂Ω1 as segments (k, 2, 2) m, table frame."""
    if scene.outer.surface is not None:
        points, segments = scene.outer.surface.vertices, scene.outer.surface.faces
    else:
        (west, south), (east, north) = outer_box
        points = np.array([[west, south], [east, south], [east, north], [west, north]])
        segments = np.array([[0, 1], [1, 2], [2, 3], [3, 0]])
    local = (points - T_scene_table[:2, 2]) @ T_scene_table[:2, :2]
    return np.asarray(local[segments])


def _held_curve(
    fixed: Fixed, T_scene_table: NDArray[np.float64], box: NDArray[np.float64]
) -> _Curve:
    """A held line, long enough to cross the box, or a held outline."""
    rotation, origin = T_scene_table[:2, :2], T_scene_table[:2, 2]
    if fixed.surface is not None:
        points = (fixed.surface.vertices - origin) @ rotation
        return _Curve(points, fixed.surface.faces, np.zeros_like(points))
    assert fixed.plane is not None
    point, normal = (np.asarray(v, dtype=np.float64) for v in fixed.plane)
    point, normal = (point - origin) @ rotation, normal @ rotation
    tangent = np.array([normal[1], -normal[0]])
    reach = float(np.linalg.norm(box[1] - box[0]))
    middle = point + tangent * ((box.mean(axis=0) - point) @ tangent)
    points = np.stack([middle - reach * tangent, middle + reach * tangent])
    return _Curve(points, np.array([[0, 1]]), np.zeros((2, 2)))


def _join(curves: list[_Curve]) -> Curves:
    first = np.cumsum([0, *(len(c.points) for c in curves)])
    return Curves(
        np.concatenate([c.points for c in curves]),
        np.concatenate([c.segments + k for c, k in zip(curves, first, strict=False)]),
        np.concatenate([c.displacement for c in curves]),
    )
