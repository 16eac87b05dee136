"""The field's error, found without the solver: walks on spheres over the warp's own defects.

The exact u equals its mean over any sphere in Ω, times s r / sinh(s r) with s = √λ. By how much
the warp's u misses that at a point is its *defect* there, measured by a rule of 26 points, turned
at random. The error e = u_warp − u has the same defect, so walking from x to the boundary in random
steps on spheres (Muller 1956), e(x) is the mean of the defects met on the way, weighted by the
factors before them, plus the error at the walk's end, which the contact checks measure. As defects
are tiny where the warp is good, a few dozen walks a point are enough.

A sliding plane is a mirror: balls may reach through it, and walks that cross it go on above it with
the sign of the normal component turned.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from touchwarp.check.case import Case, Finding
from touchwarp.check.report import Check, measured, place, unmeasured
from touchwarp.warp.plane_table import PlaneTableWarp
from touchwarp.warp.table import TableWarp

Float = NDArray[np.float64]

POINTS = 64
WALKS = 32
MOST_STEPS = 400

LOOKED_AT = 12_000
"""Sample points of Ω that the points are chosen from."""

CLOSE = 2e-4
"""m from the boundary, where a walk ends."""

_BALL = 0.75
"""Radius of a step over the distance to the boundary: nearer to 1 walks are shorter, but the rule
misses more of the harmonics beyond its degree."""

_SURE = 3.0
"""Standard errors by which an error must exceed the limit to count."""


def check_field(case: Case) -> Finding:
    """Error of u at seeded points of Ω, from walks on spheres, against the tolerance.

    Points lie farther than the edge radius from sharp edges. The value is the greatest error less
    `_SURE` standard errors of its estimate.
    """
    title = "Error of the field, by random walks"
    if case.meta is None or not isinstance(case.warp, (TableWarp, PlaneTableWarp)):
        return Finding(
            [
                unmeasured(
                    "field.max",
                    title,
                    "mm",
                    group="told",
                    detail=f"A {type(case.warp).__name__} does not claim to solve eq. 5.",
                )
            ],
            {},
        )
    points = _points(case)
    error, doubt, lost = field_errors(case, points, WALKS, case.random("walks"))
    size = np.linalg.norm(error, axis=1)
    sure = np.maximum(size - _SURE * doubt, 0.0)
    sure = np.where(np.isfinite(sure), sure, np.inf)
    worst = int(sure.argmax())
    # noise adds to the square of each estimate on average
    rms = float(np.sqrt(max(0.0, np.mean(size**2 - doubt**2))))
    detail = (
        f"{len(points)} points, {WALKS} walks each, no use of the solver. At the worst point "
        f"{1e3 * size[worst]:.2g} ± {1e3 * doubt[worst]:.1g} mm; rms over all {1e3 * rms:.2g} mm."
    )
    if lost:
        detail += f" {lost} walks were cut off."
    checks: list[Check] = [
        measured(
            "field.max",
            title,
            1e3 * float(sure[worst]),
            "mm",
            limit=1e3 * case.tolerance,
            where=place(points, worst),
            detail=detail,
            source="tolerance of the scene; mean value property of eq. 5",
        )
    ]
    return Finding(checks, {"points": points, "error": error, "doubt": doubt})


def field_errors(
    case: Case, points: Float, walks: int, rng: np.random.Generator
) -> tuple[Float, Float, int]:
    """Estimated u_warp − u, without the part that comes from the boundary.

    Args:
        case: whose warp and region.
        points: (n, d) m, in Ω.
        walks: from each point, two at least.
        rng: of the walks.

    Returns:
        (n, d) m, the standard errors (n,) m of those vectors, and how many walks were cut off.
    """
    n, d = points.shape
    rule, weights = _rule(d)
    s = np.sqrt(case.screening)
    mirror = _mirror(case)
    at = np.repeat(points, walks, axis=0)
    sign = np.ones(at.shape)
    factor = np.ones(len(at))
    total = np.zeros(at.shape)
    active = np.arange(len(at))
    for _ in range(MOST_STEPS):
        distance = _distance_to_boundary(case, at[active])
        going = distance > CLOSE
        active, radius = active[going], _BALL * distance[going]
        if len(active) == 0:
            break
        here = at[active]
        turn = _random_turns(len(active), d, rng)
        directions = np.einsum("nij,kj->nki", turn, rule)
        around = here[:, None, :] + radius[:, None, None] * directions
        mean = np.einsum("k,nki->ni", weights, _mirrored_u(case, around, mirror))
        fades = _fade(s * radius, d)
        defect = _mirrored_u(case, here, mirror) - fades[:, None] * mean
        total[active] += factor[active, None] * sign[active] * defect
        factor[active] *= fades
        chosen = _random_turns(len(active), d, rng)[:, :, 0]
        moved, flipped = _reflect(here + radius[:, None] * chosen, mirror)
        at[active] = moved
        sign[active] *= flipped
    each = total.reshape(n, walks, d)
    spread = each.std(axis=1, ddof=1) / np.sqrt(walks)
    return each.mean(axis=1), np.linalg.norm(spread, axis=1), len(active)


def _points(case: Case) -> Float:
    """Points of Ω off the sharp edges, half of them within 20 mm of a prop."""
    rng = case.random("field")
    probes = case.probes.points[:: max(1, len(case.probes.points) // LOOKED_AT)]
    distance = case.region.distance_to_props(probes)
    low = np.min([p.body.vertices.min(axis=0) for p in case.props], axis=0)
    high = np.max([p.body.vertices.max(axis=0) for p in case.props], axis=0)
    reach = float((high - low).max())
    edges = np.concatenate([p.edges.sample(p.goal, 20_000, rng)[0] for p in case.props])
    free = np.ones(len(probes), bool)
    if len(edges):
        free = cKDTree(edges).query(probes)[0] > case.edge_radius
    found = []
    for some in ((distance > 5e-4) & (distance <= 0.02), (distance > 0.02) & (distance < reach)):
        among = np.flatnonzero(some & free)
        if len(among):
            found.append(rng.choice(among, min(POINTS // 2, len(among)), replace=False))
    chosen: Float = probes[np.concatenate(found)]
    return chosen


def _distance_to_boundary(case: Case, points: Float) -> Float:
    """(n,) m to the nearest prop, held surface or ∂Ω1; sliding planes do not count."""
    low, high = case.region.box
    distance = case.region.distance_to_props(points)
    for body in case.region.holds:
        distance = np.minimum(distance, body.nearest(points)[0])
    if case.region.outer is not None:
        distance = np.minimum(distance, case.region.outer.nearest(points)[0])
    sides = np.concatenate([points - low, high - points], axis=1)
    for fixed in case.scene.fixed:
        if fixed.plane is not None and fixed.contact == "hold":
            point, normal = (np.asarray(v, float) for v in fixed.plane)
            distance = np.minimum(distance, (points - point) @ normal)
        elif fixed.plane is not None:
            # the box's side behind the mirror is no boundary
            normal = np.asarray(fixed.plane[1], float)
            behind = np.concatenate([normal, -normal]) > 1.0 - 1e-9
            sides = np.where(behind, np.inf, sides)
    if case.region.outer is None:
        distance = np.minimum(distance, sides.min(axis=1))
    return distance


def _mirror(case: Case) -> tuple[Float, Float] | None:
    plane = case.scene.slide_plane
    if plane is None or plane.plane is None:
        return None
    return np.asarray(plane.plane[0], float), np.asarray(plane.plane[1], float)


def _reflect(points: Float, mirror: tuple[Float, Float] | None) -> tuple[Float, Float]:
    """Points (n, d) brought above the mirror, and (n, d) factors, see `_mirrored_u`."""
    if mirror is None:
        return points, np.ones(points.shape)
    point, normal = mirror
    depth = np.minimum((points - point) @ normal, 0.0)
    flip = np.where(depth[:, None] < 0.0, 1.0 - 2.0 * np.abs(normal) ** 2, 1.0)
    return points - 2.0 * depth[:, None] * normal, flip


def _mirrored_u(case: Case, points: Float, mirror: tuple[Float, Float] | None) -> Float:
    """u (..., d) continued through the sliding plane as a mirrored scene would have it."""
    flat, _ = _reflect(points.reshape(-1, case.dimension), mirror)
    u = case.warp.displacement(flat)
    if mirror is not None:
        point, normal = mirror
        under = (points.reshape(-1, case.dimension) - point) @ normal < 0.0
        u = u - 2.0 * np.where(under, u @ normal, 0.0)[:, None] * normal
    return u.reshape(points.shape)


def _fade(q: Float, d: int) -> Float:
    """What the mean over a sphere is multiplied by: q / sinh q in space, 1 / I0(q) in the plane."""
    if d == 2:
        return np.asarray(1.0 / np.i0(q))
    small = q < 1e-6
    return np.where(small, 1.0, q / np.sinh(np.where(small, 1.0, q)))


def _rule(d: int) -> tuple[Float, Float]:
    """Unit vectors (k, d) and weights (k,): exact to degree 7 (Lebedev, 26 points); 11 in 2-D."""
    if d == 2:
        angle = 2.0 * np.pi * np.arange(12) / 12
        return np.stack([np.cos(angle), np.sin(angle)], axis=1), np.full(12, 1.0 / 12)
    grid = np.stack(np.meshgrid(*[[-1, 0, 1]] * 3, indexing="ij"), -1).reshape(-1, 3)
    ones = np.abs(grid).sum(axis=1)
    grid, ones = grid[ones > 0], ones[ones > 0]
    weights = np.array([0.0, 1.0 / 21.0, 4.0 / 105.0, 9.0 / 280.0])[ones]
    return grid / np.sqrt(ones)[:, None], weights


def _random_turns(count: int, d: int, rng: np.random.Generator) -> Float:
    """(count, d, d) rotations, uniform."""
    if d == 2:
        angle = rng.uniform(0.0, 2.0 * np.pi, count)
        cos, sin = np.cos(angle), np.sin(angle)
        return np.stack([np.stack([cos, -sin], 1), np.stack([sin, cos], 1)], 1)
    q = rng.standard_normal((count, 4))
    w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=1) for row in rows], axis=1)
