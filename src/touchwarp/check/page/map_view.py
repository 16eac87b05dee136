"""The goal's map in pictures: what colours both surfaces, and the shapes between them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.colors import ListedColormap
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from touchwarp.check.case import Case
from touchwarp.check.page.display_mesh import field
from touchwarp.check.page.palette import ERROR, GAIN, error_norm
from touchwarp.check.page.still import as_address, view
from touchwarp.check.region import Body
from touchwarp.goals.measure import MapMeasures
from touchwarp.goals.surface_samples import face_normals

Float = NDArray[np.float64]
Int = NDArray[np.int64]

BETWEEN = (0.0, 0.25, 0.5, 0.75, 1.0)
"""The in-between shapes (1 − t) x + t g(x) that are drawn."""

BESIDE = 80_000
"""More faces than this of a virtual object are not drawn behind its image."""

_SQUARES_ALONG = 12
_STILL_SAMPLES = 250_000
_STILL_HEIGHT = 300
_PAPER = np.array([0.80, 0.83, 0.86])
_DARK = 0.55


def map_fields(
    case: Case, parts: Sequence[tuple[Float, Float, Int]], others: Sequence[dict[str, Any]]
) -> list[dict[str, Any]]:
    """What a map's surfaces are coloured by; props whose goal is a transform stay neutral.

    Args:
        case: with at least one map.
        parts: for each prop, the corners of its display mesh, felt and seen, and their faces.
        others: fields that the warp's own view has, to be shown here too.
    """
    count = sum(len(part[0]) for part in parts)
    area, greatest, least = np.ones(count), np.ones(count), np.ones(count)
    curvature, distance = np.zeros(count), np.zeros(count)
    start = 0
    for prop, (felt, seen, face) in zip(case.props, parts, strict=True):
        own = slice(start, start + len(felt))
        start += len(felt)
        measures = case.maps.get(prop.name)
        if measures is None:
            continue
        area[own] = np.nan_to_num(measures.area_ratio[face], nan=1.0)
        greatest[own], least[own] = np.nan_to_num(measures.stretch[face], nan=1.0).T
        curvature[own] = _at(felt, measures.curvature.points, measures.curvature.change)
        distance[own] = _distance(seen, measures)
    tolerance = 1e3 * case.tolerance
    norm = error_norm(tolerance)
    bend = max(float(np.quantile(np.abs(curvature), 0.98)), 1.0)
    plain = field(
        "plain", "plain", "", np.zeros(count), (0.0, 1.0), ListedColormap([tuple(_PAPER)])
    )
    return [
        {**plain, "gradient": ""},
        field(
            "area",
            "area ratio",
            "×",
            area,
            _factors(area),
            GAIN,
            log=True,
            note="Share of the seen area over share of the felt area: purple takes more than its "
            "due, orange less; 1 in the middle.",
        ),
        field(
            "greatest",
            "greatest stretch",
            "×",
            greatest,
            _factors(greatest),
            GAIN,
            log=True,
            note="A stroke's seen over its felt length, in the direction where that is greatest; "
            "1 in the middle.",
        ),
        field(
            "least",
            "least stretch",
            "×",
            least,
            _factors(least),
            GAIN,
            log=True,
            note="A stroke's seen over its felt length, in the direction where that is least; "
            "1 in the middle.",
        ),
        field(
            "curvature",
            "change of curvature",
            "m⁻¹",
            curvature,
            (-bend, bend),
            GAIN,
            note="Mean curvature seen less felt, over a fingertip: purple is seen rounder or "
            "sharper than it is felt, orange flatter or more hollow.",
        ),
        *others,
        field(
            "distance",
            "distance to the virtual surface",
            "mm",
            1e3 * distance,
            (float(norm.vmin or 0.0), float(norm.vmax or 1.0)),
            ERROR,
            log=True,
            mark=(tolerance, "tolerance"),
            note="How far the image lies from the virtual object's own surface.",
        ),
    ]


def virtual_triangles(case: Case) -> Float:
    """(3 t, 3) m: corners of the virtual objects' own faces, to show where g leaves them bare."""
    surfaces = [m.virtual for m in case.maps.values() if m.goal.virtual_surface is not None]
    some = [s.vertices[s.faces].reshape(-1, 3) for s in surfaces if len(s.faces) <= BESIDE]
    return np.concatenate(some) if some else np.empty((0, 3))


def square_side(case: Case) -> float:
    """m, of the checkerboard's squares: whole millimetres, about a twelfth of the largest prop."""
    extent = max(float(np.ptp(p.goal.prop_points, axis=0).max()) for p in case.props)
    return 1e-3 * max(1, round(1e3 * extent / _SQUARES_ALONG))


def between_picture(case: Case) -> str:
    """A PNG as a data address: a row of the shapes between prop and virtual object."""
    side = square_side(case)
    share = _STILL_SAMPLES // len(case.props)
    felt: list[Float] = []
    seen: list[Float] = []
    normals: dict[float, list[Float]] = {t: [] for t in BETWEEN}
    for prop in case.props:
        goal, some = prop.goal, slice(None, None, max(1, len(prop.samples.points) // share))
        felt.append(prop.samples.points[some])
        seen.append(prop.samples.targets[some])
        for t in BETWEEN:
            vertices = (1.0 - t) * goal.prop_points + t * goal.virtual_points
            outward = prop.body.outward if t < 0.5 else prop.virtual.outward
            own = outward * face_normals(vertices, goal.faces)
            normals[t].append(own[prop.samples.face[some]])
    x, g = np.concatenate(felt), np.concatenate(seen)
    odd = np.floor(x / side + 0.371).astype(np.int64).sum(axis=1) & 1
    colours = np.where(odd == 1, _DARK, 1.0)[:, None] * _PAPER
    both = np.concatenate([x, g])
    row = [
        view(
            (1.0 - t) * x + t * g,
            np.concatenate(normals[t]),
            colours,
            math.radians(-60.0),
            height=_STILL_HEIGHT,
            around=both,
        )
        for t in BETWEEN
    ]
    return as_address(np.concatenate(row, axis=1))


def _at(points: Float, known: Float, values: Float) -> Float:
    _, nearest = cKDTree(known).query(points)
    found: Float = values[nearest]
    return found


def _distance(seen: Float, measures: MapMeasures) -> Float:
    corners, index = np.unique(seen, axis=0, return_inverse=True)
    body = Body("", measures.virtual.vertices, measures.virtual.faces)
    distance: Float = body.nearest(corners)[0][index.reshape(-1)]
    return distance


def _factors(values: Float) -> tuple[float, float]:
    """Ends as far above 1 as below, beyond which 2 % of the values lie."""
    with np.errstate(divide="ignore"):
        widest = float(np.quantile(np.abs(np.log(values)), 0.98, method="lower"))
    top = math.exp(min(max(widest, 0.05), 3.0))
    return 1.0 / top, top
