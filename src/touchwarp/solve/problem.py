"""From a scene and its goals to the boundary-value problem: frame, surfaces, boundary data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.goals import Goal, outer_box
from touchwarp.scene import Scene, Surface
from touchwarp.solve.blend import HELD, Blend
from touchwarp.solve.boundary import Boundary
from touchwarp.solve.frame import Frame, frame_of_box
from touchwarp.solve.region import OUTER
from touchwarp.solve.stencil import LANES

PADDING = 0.04
"""How far the grid reaches beyond an outer surface that is no box along its axes, in its size."""

_BOX_FACES = np.array(
    [
        [0, 1, 3],
        [0, 3, 2],
        [4, 6, 7],
        [4, 7, 5],
        [0, 4, 5],
        [0, 5, 1],
        [2, 3, 7],
        [2, 7, 6],
        [0, 2, 6],
        [0, 6, 4],
        [1, 5, 7],
        [1, 7, 3],
    ],
    np.int64,
)


@dataclass(frozen=True, eq=False)
class Problem:
    """Δu = λu in Ω with u given on all surfaces.

    Attributes:
        frame: where the grid lies.
        boundary: the surfaces, in root-grid coordinates.
        vertices: for each prop, its rows among the boundary's corners.
        outer_box: (2, 3) m, scene frame: ∂Ω1, or the box around it.
        mirror_depth: m, from the sliding plane down to the outer box's floor; 0 without a plane.
        screening: λ, m⁻².
        blend: how goals give way to fixed surfaces that they contradict.
    """

    frame: Frame
    boundary: Boundary
    vertices: dict[str, slice]
    outer_box: NDArray[np.float64]
    mirror_depth: float
    screening: float
    blend: Blend

    @property
    def normal_lanes(self) -> NDArray[np.bool_]:
        """(4,) lanes of `goal_data` that vanish on the sliding plane: the normal component."""
        return np.array([False, False, self.frame.mirrored, False])

    def goal_data(self, goals: Mapping[str, Goal]) -> NDArray[np.float64]:
        """(v, 4) boundary data at the corners: u along the table's axes in m, and 0."""
        data = np.zeros((len(self.boundary.corners), LANES))
        for name, rows in self.vertices.items():
            data[rows, :3] = self.frame.axes_from_scene(goals[name].displacement)
        return data


def make_problem(
    scene: Scene, goals: Mapping[str, Goal], box: NDArray[np.float64] | None = None
) -> Problem:
    """The problem of a scene whose parts have been checked to fit together.

    `box`, (2, 3) m, scene frame, is ∂Ω1 instead of the one that the scene's `box_scale` gives.
    """
    if box is None:
        box = outer_box(scene, goals)
    frame, depth, outer = _place(scene, box)
    surfaces: list[tuple[Surface, int]] = []
    vertices: dict[str, slice] = {}
    count = 0
    for number, prop in enumerate(scene.props):
        goal = goals[prop.name]
        surfaces.append((Surface(goal.prop_points, goal.faces), number))
        vertices[prop.name] = slice(count, count + len(goal.prop_points))
        count += len(goal.prop_points)
    reach = float(np.linalg.norm(box[1] - box[0]))
    for fixed in scene.fixed:
        if fixed.contact == "hold":
            surfaces.append((fixed.surface or _sheet(fixed.plane, box.mean(axis=0), reach), HELD))
    if outer is not None:
        surfaces.append((outer, OUTER))
    corners, faces, owner = [], [], []
    count = 0
    for surface, number in surfaces:
        corners.append(frame.to_grid(surface.vertices))
        faces.append(surface.faces + count)
        owner.append(np.full(len(surface.faces), number, np.int16))
        count += len(surface.vertices)
    boundary = Boundary(
        np.concatenate(corners), np.concatenate(faces).astype(np.int32), np.concatenate(owner)
    )
    return Problem(
        frame,
        boundary,
        vertices,
        box,
        depth,
        scene.objective.screening,
        Blend.of(scene, frame, boundary),
    )


def _place(scene: Scene, box: NDArray[np.float64]) -> tuple[Frame, float, Surface | None]:
    """The frame, the depth under the sliding plane, and ∂Ω1 where the grid's faces are not it."""
    outer = scene.outer.surface
    corners = np.stack(np.meshgrid(*box.T, indexing="ij"), axis=-1).reshape(-1, 3)
    fixed = scene.slide_plane
    if fixed is None or fixed.plane is None:
        return frame_of_box(_padded(box) if outer is not None else box), 0.0, outer
    point, normal = (np.asarray(v, dtype=np.float64) for v in fixed.plane)
    rotation, along_axes = _axes(normal)
    local = (corners - point) @ rotation
    heights = local[:, 2]
    if heights.min() >= 0.0 or heights.max() <= 0.0:
        return frame_of_box(_padded(box) if outer is not None else box), 0.0, outer
    if outer is None and not along_axes:
        outer = Surface(corners, _BOX_FACES)
    around = np.stack([local.min(axis=0), local.max(axis=0)])
    if outer is not None:
        around = _padded(around)
    around[0, 2] = 0.0
    frame = frame_of_box(around, rotation, point, mirrored=True)
    return frame, float(-heights.min()), outer


def _padded(box: NDArray[np.float64]) -> NDArray[np.float64]:
    margin = PADDING * (box[1] - box[0]).max()
    return np.asarray(box + margin * np.array([[-1.0], [1.0]]))


def _axes(normal: NDArray[np.float64]) -> tuple[NDArray[np.float64], bool]:
    """(3, 3) table to scene with the third axis along a normal; whether all lie along the
    scene's."""
    k = int(np.abs(normal).argmax())
    if abs(abs(normal[k]) - 1.0) < 1e-9:
        third = np.zeros(3)
        third[k] = np.sign(normal[k])
        first = np.zeros(3)
        first[(k + 1) % 3] = 1.0
        return np.stack([first, np.cross(third, first), third], axis=1), True
    side = np.zeros(3)
    side[int(np.abs(normal).argmin())] = 1.0
    second = np.cross(normal, side)
    second /= np.linalg.norm(second)
    return np.stack([np.cross(second, normal), second, normal], axis=1), False


def _sheet(
    plane: tuple[Sequence[float], Sequence[float]] | None,
    centre: NDArray[np.float64],
    reach: float,
) -> Surface:
    """A held plane as a square that spans the outer box."""
    assert plane is not None
    point, normal = (np.asarray(v, dtype=np.float64) for v in plane)
    rotation, _ = _axes(normal)
    foot = centre - ((centre - point) @ normal) * normal
    a, b = reach * rotation[:, 0], reach * rotation[:, 1]
    return Surface(
        np.stack([foot - a - b, foot + a - b, foot + a + b, foot - a + b]),
        np.array([[0, 1, 2], [0, 2, 3]]),
    )
