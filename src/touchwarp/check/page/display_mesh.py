"""A mesh for the page's 3-D views: thinned or refined, in numbers that JSON can carry.

Small faces are merged, large ones divided, so that values per corner show what happens between the
mesh's own vertices.
"""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from matplotlib.colors import Colormap
from numpy.typing import NDArray

from touchwarp.check.case import PropCase
from touchwarp.check.page.palette import colour_bytes, css_gradient
from touchwarp.goals.goal import Goal
from touchwarp.goals.surface_samples import face_normals

Float = NDArray[np.float64]
Int = NDArray[np.int64]

DIVISIONS_ALONG = 70
"""Faces longer than the object over this are divided."""


def display_mesh(prop: PropCase, most: int) -> tuple[Float, Float, Int]:
    """Corners of triangles (3 t, 3) m on the prop and on the virtual object, and (3 t,) their face.

    Args:
        prop: with its goal.
        most: of triangles.
    """
    goal = prop.goal
    faces, kept = _thinned(goal, most)
    felt, seen = goal.prop_points[faces], goal.virtual_points[faces]
    extent = float(np.ptp(felt, axis=(0, 1)).max())
    return _divided(felt, seen, kept, extent / DIVISIONS_ALONG, most)


def field(
    key: str,
    name: str,
    unit: str,
    values: Float,
    ends: tuple[float, float],
    colours: Colormap,
    *,
    log: bool = False,
    mark: tuple[float, str] | None = None,
    note: str = "",
) -> dict[str, Any]:
    """Values per corner, 8-bit between two ends, with the colours that show them.

    Args:
        key, name, unit: for the script, and for people.
        values: (3 t,) in `unit`.
        ends: the values of the first and the last colour.
        colours: from the one to the other.
        log: by factors instead of differences.
        mark: a value to be marked on the scale where it is on it, and what it is.
        note: what a reader has to know of it, a sentence.
    """
    low, high = ends
    if log:
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.log(values / low) / np.log(high / low)
    else:
        share = (values - low) / (high - low)
    return {
        "key": key,
        "name": name,
        "unit": unit,
        "values": packed(_eight(share)),
        "low": low,
        "high": high,
        "log": log,
        "colours": packed(colour_bytes(colours)),
        "gradient": css_gradient(colours),
        "beyond": [bool((values < low).any()), bool((values > high).any())],
        "mark": mark,
        "note": note,
    }


def _divided(
    felt: Float, seen: Float, face: Int, longest: float, most: int
) -> tuple[Float, Float, Int]:
    """Triangles (t, 3, 3) halved across their longest edges until none is longer than `longest`.

    Returns:
        Corners (3 t, 3) m on the prop and on the virtual object, and (3 t,) the face they are of.
    """
    while len(felt) < most:
        length = np.linalg.norm(felt - np.roll(felt, -1, axis=1), axis=2)
        long = np.flatnonzero(length.max(axis=1) > longest)
        long = long[np.argsort(-length[long].max(axis=1))][: most - len(felt)]
        if len(long) == 0:
            break
        first = length[long].argmax(axis=1)
        halves = []
        for corners in (felt, seen):
            rows = np.arange(len(long))
            a, b, c = (corners[long][rows, (first + k) % 3] for k in range(3))
            middle = 0.5 * (a + b)
            one, two = np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)
            halves.append(np.concatenate([np.delete(corners, long, axis=0), one, two]))
        face = np.concatenate([np.delete(face, long), face[long], face[long]])
        felt, seen = halves
    return felt.reshape(-1, 3), seen.reshape(-1, 3), np.repeat(face, 3)


def _thinned(goal: Goal, most: int) -> tuple[Int, Int]:
    """Faces with their vertices merged on ever coarser cubes, and which of all they were.

    Of the vertices in a cube the one at the sharpest corner stays, so that edges do not fray.
    """
    points, faces = goal.prop_points, goal.faces
    cells = 160
    kept = np.arange(len(faces))
    thinned = faces
    sharpest = np.argsort(_bluntness(goal), kind="stable") if len(faces) > most else kept
    while len(thinned) > most:
        low = points.min(axis=0)
        side = float(np.ptp(points, axis=0).max()) / cells
        key = np.floor((points - low) / side).astype(np.int64)
        flat = (key[:, 0] << 40) + (key[:, 1] << 20) + key[:, 2]
        _, first, same = np.unique(flat[sharpest], return_index=True, return_inverse=True)
        merged_into = np.empty(len(points), np.int64)
        merged_into[sharpest] = sharpest[first][same.reshape(-1)]
        merged = merged_into[faces]
        proper = (merged != np.roll(merged, 1, axis=1)).all(axis=1)
        kept = np.flatnonzero(proper)
        _, once = np.unique(np.sort(merged[kept], axis=1), axis=0, return_index=True)
        kept = kept[once]
        thinned = merged[kept]
        cells = int(cells * 0.8)
    return thinned, kept


def _bluntness(goal: Goal) -> Float:
    """(n,) how far the normals around each vertex agree, on the prop and on its image."""
    blunt = np.zeros(len(goal.prop_points))
    for vertices in (goal.prop_points, goal.virtual_points):
        sums = np.zeros_like(vertices)
        corners = np.repeat(face_normals(vertices, goal.faces), 3, axis=0)
        np.add.at(sums, goal.faces.reshape(-1), corners)
        count = np.bincount(goal.faces.reshape(-1), minlength=len(vertices))
        blunt += np.linalg.norm(sums, axis=1) / np.maximum(count, 1)
    return blunt


def sixteen(points: Float, low: Float, high: Float) -> NDArray[np.uint16]:
    """Positions as 16-bit numbers between two corners of a box."""
    span = np.maximum(high - low, 1e-12)
    return np.round(65535.0 * (points - low) / span).astype("<u2")


def _eight(values: Float) -> NDArray[np.uint8]:
    return np.round(255.0 * np.clip(np.nan_to_num(values, nan=1.0), 0.0, 1.0)).astype(np.uint8)


def packed(array: NDArray[Any]) -> str:
    """An array's bytes as text."""
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode("ascii")
