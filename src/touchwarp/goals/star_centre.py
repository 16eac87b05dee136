"""Points that see the whole of a surface, and rays that test them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.goals.line_crossings import RadialLines
from touchwarp.goals.surface_samples import face_normals
from touchwarp.scene.surface import Surface

Float = NDArray[np.float64]

TEST_RAYS = 10_000


@dataclass(frozen=True, eq=False)
class Kernel:
    """The point that sees most of some surfaces.

    Attributes:
        centre: (3,) m.
        depth: m, how far it is in front of every face's plane, at least; negative where no point
            is in front of all.
    """

    centre: Float
    depth: float


def star_kernel(*surfaces: Surface) -> Kernel:
    """The centre of the largest ball in front of every face's plane: where all faces are seen from.

    A surface is star-shaped exactly from the points of its kernel, which is the meeting of all its
    faces' inner half-spaces; its Chebyshev centre is a linear programme in four unknowns.

    Args:
        surfaces: each oriented alike throughout, outward or inward.
    """
    from scipy.optimize import linprog

    normals, offsets = [], []
    for surface in surfaces:
        normal = outward_normals(surface)
        proper = np.abs(normal).max(axis=1) > 0
        normals.append(normal[proper])
        first = surface.vertices[surface.faces[proper, 0]]
        offsets.append(np.einsum("ij,ij->i", normal[proper], first))
    box = np.concatenate([surface.bounds for surface in surfaces])
    middle, half = box.mean(axis=0), float(np.ptp(box, axis=0).max()) / 2
    # Lengths in units of half the box, from its middle: |c| ≤ 1 there.
    rows = np.concatenate(normals)
    reach = (np.concatenate(offsets) - rows @ middle) / half
    # the depth has no lower bound: two bodies may face each other from any distance
    bounds = [(-1, 1)] * 3 + [(None, 1)]
    solved = linprog([0, 0, 0, -1], np.c_[rows, np.ones(len(rows))], reach, bounds=bounds)
    centre, depth = solved.x[:3], float(solved.x[3])
    if depth > 0:
        # Other balls may be as large: move towards the middle while half the depth is left.
        fall = rows @ centre
        room = reach - rows @ centre - depth / 2
        share = np.min(np.where(fall < 0, room / np.maximum(-fall, 1e-300), np.inf))
        centre = centre * (1 - min(1.0, float(share)))
        depth = float((reach - rows @ centre).min())
    return Kernel(middle + half * centre, half * depth)


def outward_normals(surface: Surface) -> Float:
    """(m, 3) unit normals of faces that are all turned alike, out of the body; 0 for needles."""
    corners = surface.vertices[surface.faces] - surface.bounds.mean(axis=0)
    normal = np.nan_to_num(face_normals(surface.vertices, surface.faces))
    volume = (corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])).sum()
    # An open sheet in a plane through the middle has no volume but for rounding.
    inside_out = volume < -1e-9 * np.ptp(surface.bounds, axis=0).max() ** 3
    return -normal if inside_out else normal


def blocked_rays(lines: RadialLines) -> tuple[float, Float]:
    """The share of rays, even over the sphere, that do not cross a surface just once; one of them.

    Args:
        lines: of the surface, out of the centre to test.

    Returns:
        The share, and the direction (3,) of a ray that fails, or zeros.
    """
    directions = even_directions(TEST_RAYS)
    fails = lines.crossings(directions).count != 1
    one = directions[int(fails.argmax())] if fails.any() else np.zeros(3)
    return float(fails.mean()), one


def even_directions(count: int) -> Float:
    """(count, 3) unit vectors spread evenly over the sphere: the Fibonacci lattice."""
    n = np.arange(count) + 0.5
    polar = np.arccos(1 - 2 * n / count)
    azimuth = np.pi * (1 + np.sqrt(5)) * n
    return np.stack(
        [np.cos(azimuth) * np.sin(polar), np.sin(azimuth) * np.sin(polar), np.cos(polar)], axis=1
    )
