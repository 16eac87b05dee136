"""Small folds of a map's straight images taken out.

Where the virtual layout shears, three corners of a triangle that is sound on the domain may have
images that wind the other way. Each such corner, and each next to one, goes to the surface's point
nearest to the mean of its neighbours' images, unless more triangles around it would fold.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.goals.maps.base import Base
from touchwarp.goals.surface_tree import SurfaceTree
from touchwarp.scene.surface import Surface

Float = NDArray[np.float64]
Int = NDArray[np.int64]

ROUNDS = 60
COLOURS = 4
"""Corners take turns by colours drawn once, so that few neighbours move at once."""


def folded_faces(images: Float, faces: Int, tree: SurfaceTree, normals: Float) -> Float:
    """(m,) 1 where a face's straight image looks inward on the surface, else 0.

    Args:
        images: (n, 3) m.
        faces: (m, 3).
        tree: of the surface; normals: (k, 3) of its faces.
    """
    a, b, c = (images[faces[:, k]] for k in range(3))
    crossed = np.cross(b - a, c - a)
    below = normals[tree.nearest((a + b + c) / 3).elements]
    return np.asarray((crossed * below).sum(axis=1) <= 0, dtype=np.float64)


def iron(images: Float, faces: Int, surface: Surface, base: Base | None = None) -> Float:
    """Images (n, 3) m on the surface with fewer folded faces; the rest stay where they are.

    Args:
        images: (n, 3) m, on the surface.
        faces: (m, 3).
        surface: the virtual surface.
        base: whose vertices move on the virtual object's base alone.
    """
    tree = SurfaceTree(surface.vertices, surface.faces)
    corners = surface.vertices[surface.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    folded = folded_faces(images, faces, tree, normals)
    images = images.copy()
    colour = np.random.default_rng(0).integers(COLOURS, size=len(images))
    for turn in range(ROUNDS):
        if not folded.any():
            break
        moving = np.zeros(len(images), np.bool_)
        moving[faces[folded > 0]] = True
        moving[faces[moving[faces].any(axis=1)]] = True
        moving &= colour == turn % COLOURS
        if not moving.any():
            continue
        around = np.flatnonzero(moving[faces].any(axis=1))
        near = faces[around]
        total, count = np.zeros_like(images), np.zeros(len(images))
        for k in range(3):
            for other in (near[:, k - 1], near[:, k - 2]):
                np.add.at(total, near[:, k], images[other])
                np.add.at(count, near[:, k], 1.0)
        trial = images.copy()
        trial[moving] = tree.nearest(total[moving] / count[moving, None]).points
        if base is not None:
            kept = moving & base.standing
            trial[kept] = base.tree.nearest(total[kept] / count[kept, None]).points
        after = folded.copy()
        after[around] = folded_faces(trial, near, tree, normals)
        gain = np.zeros(len(images))
        for k in range(3):
            np.add.at(gain, near[:, k], folded[around] - after[around])
        moving &= gain >= 0  # ties too: a fold of several triangles opens step by step
        images[moving] = trial[moving]
        folded[around] = folded_faces(images, near, tree, normals)
    return images
