"""Maps from shape to shape whose every quantity is known, and ways to spoil them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.goals import Goal
from touchwarp.goals.refinement import refine
from touchwarp.scene.shapes import box, sphere
from touchwarp.scene.surface import Surface

RADIUS = 0.05
STRETCH = np.diag([1.2, 0.8, 1.0])


def ball(facet_mm: float = 0.05) -> Surface:
    return sphere(RADIUS, facet_mm)


def ellipsoid_map(facet_mm: float = 0.05) -> Goal:
    """A ball, stretched by 1.2 and 0.8 in x and y, onto the ellipsoid that this gives."""
    surface = ball(facet_mm)
    image = Surface(surface.vertices @ STRETCH, surface.faces)
    return Goal(surface.vertices, image.vertices, surface.faces, "match", virtual_surface=image)


def cube_map(side: float = 0.08, edge: float = 2e-3) -> Goal:
    """A cube onto a ball, by rays from the centre."""
    cube = refine(box([side] * 3), edge)
    length = np.linalg.norm(cube.vertices, axis=1, keepdims=True)
    return Goal(
        cube.vertices,
        RADIUS * cube.vertices / length,
        cube.faces,
        "direction",
        virtual_surface=ball(0.005),
    )


def identity_map(surface: Surface, virtual: Surface | None = None, shift: Any = 0.0) -> Goal:
    """Every point to itself, moved by `shift`, m."""
    return Goal(
        surface.vertices,
        surface.vertices + np.asarray(shift),
        surface.faces,
        "match",
        virtual_surface=surface if virtual is None else virtual,
    )


def with_one_flip(goal: Goal) -> Goal:
    """One vertex's image is pushed across the far side of one of its faces, along the surface."""
    a, b, c = goal.faces[0]
    images = goal.virtual_points.copy()
    middle = 0.5 * (images[b] + images[c])
    images[a] = middle + 0.5 * (middle - images[a])
    return replace(goal, virtual_points=images)


def with_a_hole(goal: Goal, around: NDArray[np.float64], radius: float) -> Goal:
    """The faces of the prop whose images are near a point are missing."""
    centre = goal.virtual_points[goal.faces].mean(axis=1)
    return replace(goal, faces=goal.faces[np.linalg.norm(centre - around, axis=1) > radius])


def doubled(goal: Goal) -> Goal:
    """A ball's image winds twice round the z axis."""
    x, y, z = goal.virtual_points.T
    azimuth, out = 2.0 * np.arctan2(y, x), np.hypot(x, y)
    images = np.stack([out * np.cos(azimuth), out * np.sin(azimuth), z], axis=1)
    return replace(goal, virtual_points=images)
