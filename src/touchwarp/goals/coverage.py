"""Whether the image of a prop lies on its virtual surface, all of it, once, and right side out."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from touchwarp.goals.goal import Goal
from touchwarp.goals.surface_samples import face_areas, face_normals, sample_surface
from touchwarp.goals.surface_tree import SurfaceTree
from touchwarp.scene.surface import Surface

Float = NDArray[np.float64]
Int = NDArray[np.int64]
Bool = NDArray[np.bool_]

REACH = 0.01
"""A point counts as covered up to this share of the virtual surface's diagonal along its normal."""

TOUCH = 1e-4
"""… and at any nearest point within this share: rays may slip through between two faces."""

COLLAPSED = 1e-9
"""A face is collapsed where its area shrinks to this share of what others shrink to, or less."""


class Coverage(NamedTuple):
    """How an image covers a virtual surface.

    Attributes:
        points: (n, 3) m of the virtual surface, uniform in area.
        covered: (n,) which of them the image reaches.
        handedness: 1 where the image's faces are wound like the virtual surface's, −1 where they
            are wound the other way, by the majority of their area.
        flipped: (m,) the faces whose image is turned against the majority, or has no area.
    """

    points: Float
    covered: Bool
    handedness: float
    flipped: Bool


def cover(goal: Goal, virtual: Surface, tree: SurfaceTree, samples: int, seed: int) -> Coverage:
    """Which faces are flipped, and which points of the virtual surface the image misses.

    A face is flipped if its image's normal opposes that of the virtual surface at the point nearest
    to the image's centre. A point of the virtual surface is covered if an image that is not flipped
    is met along the point's normal, within 1 % of the diagonal in or out: so a hole counts with its
    whole area, however small it is, and a thin wall's other side does not count.

    Args:
        goal: the map.
        virtual: what it should map to.
        tree: of the virtual surface.
        samples: points of the virtual surface to try.
        seed: of their choice.
    """
    normals = face_normals(virtual.vertices, virtual.faces)
    area = face_areas(goal.virtual_points, goal.faces)
    image_normals = face_normals(goal.virtual_points, goal.faces)
    below = tree.nearest(goal.virtual_points[goal.faces].mean(axis=1))
    facing = np.einsum("ij,ij->i", image_normals, normals[below.elements])
    handedness = 1.0 if float(area @ facing) >= 0.0 else -1.0
    felt = face_areas(goal.prop_points, goal.faces)
    collapsed = (felt > 0.0) & (area <= COLLAPSED * felt * (area.sum() / felt.sum()))
    flipped = (handedness * facing < 0.0) | collapsed
    tried = sample_surface(
        Goal(virtual.vertices, virtual.vertices, virtual.faces),
        samples,
        np.random.default_rng(seed),
    )
    diagonal = float(np.linalg.norm(np.ptp(virtual.bounds, axis=0)))
    proper = np.flatnonzero(~flipped)
    covered = np.zeros(len(tried.points), np.bool_)
    if len(proper) > 0:
        image = SurfaceTree(goal.virtual_points, goal.faces[proper])
        turned = handedness * image_normals[proper]
        near = image.nearest(tried.points)
        alike = np.einsum("ij,ij->i", turned[near.elements], tried.normals) > 0.0
        covered = alike & (near.distance <= TOUCH * diagonal)
        for side in (1.0, -1.0):
            left = np.flatnonzero(~covered)
            length, hit = image.first_hit(tried.points[left], side * tried.normals[left])
            alike = np.einsum("ij,ij->i", turned[hit], tried.normals[left]) > 0.0
            covered[left] = (length <= REACH * diagonal) & alike
    return Coverage(tried.points, covered, handedness, flipped)
