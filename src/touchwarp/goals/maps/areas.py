"""Area-preserving layouts: each triangle's share of the domain is its share of the surface.

Levenberg–Marquardt on all vertices at once. Far from the aim it descends Σ A²/a + a − 2A, whose
barrier lets no triangle turn over; near it Σ (a − A)²/A, whose minimum is the least spread. Before
each step every vertex by itself descends the former among its neighbours: what is uneven from
triangle to triangle is gone then, and no single one holds back the step of all.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.goals.maps.block_system import BlockSystem
from touchwarp.goals.maps.layout import Layout
from touchwarp.goals.maps.rings import build_rings
from touchwarp.goals.maps.settle import LEAST_CURVATURE, corner_tables, star_area
from touchwarp.goals.maps.star import tangents

KEPT = 6e-3
"""The spread of area ratios that a polish aims at where areas are to be kept."""
NEAR_AIM, SLOW_STEPS, SLOW = 4 / 3, 4, 0.9
"""Below so many aims a polish ends where so many steps leave more than this part of the spread."""
FAR_SPREAD = 0.05
FAR_RATIO = 0.3
LEAST_SHRINK = 0.05
"""No step may shrink a triangle to less than this part of its area."""
HALVINGS = 20
SWEEPS = 5
OWN_HALVINGS = 6
SLIVER = 1e-4
"""Triangles smaller than this part of the mean count as so large."""


def target_shares(areas: NDArray[np.float64]) -> NDArray[np.float64]:
    """(m,) shares of the domain for triangles of these areas; slivers get a little more."""
    lifted = np.maximum(areas, SLIVER * areas.mean())
    return np.asarray(lifted / lifted.sum())


def spread(shares: NDArray[np.float64], target: NDArray[np.float64]) -> float:
    """The standard deviation of a/A, weighted by A."""
    return float(np.sqrt(((shares - target) ** 2 / target).sum() / target.sum()))


def polish_areas(
    layout: Layout, target: NDArray[np.float64], aim: float, most_steps: int = 40
) -> Layout:
    """Move the vertices until the spread of area ratios is at most `aim`, or steps help little.

    Args:
        layout: with no triangle turned over.
        target: (m,) the shares wanted; they sum to 1.
        aim: the spread to stop at.
        most_steps: Newton steps at most.
    """
    system = BlockSystem(layout.mesh.faces, len(layout.points))
    star = _star(layout, target)
    damping = 1e-2
    spreads: list[float] = []
    for _ in range(most_steps):
        if star is not None:
            points = layout.points.copy()
            _even_out(star, points, SWEEPS, layout.flat)
            layout = layout.moved(points)
        shares = layout.shares
        now = spread(shares, target)
        earlier = spreads[-SLOW_STEPS] if len(spreads) >= SLOW_STEPS else np.inf
        if now <= aim or SLOW * earlier < now <= NEAR_AIM * aim:
            break
        spreads.append(now)
        far = now > FAR_SPREAD or (shares / target).min() < FAR_RATIO
        before = _energy(shares, target, far)
        frames = layout.frames()
        gradient = layout.area_gradients(frames) / layout.domain_area
        if far:
            first, second = 1 - (target / shares) ** 2, 2 * target**2 / shares**3
        else:
            first, second = (shares - target) / target, 1 / target
        stiffness = np.clip(layout.cotangents(), 0.01, 10)
        improved = False
        for _ in range(8):
            system.clear()
            system.add_areas(gradient, first, second)
            system.add_differences(damping * stiffness, layout.comparable(frames))
            move = system.solve(1e-9)
            step = 1.0
            for _ in range(8):
                trial, after = moved_unturned(layout, shares, frames, step * move)
                if after.min() > 0 and _energy(after, target, far) < before:
                    improved = True
                    break
                step *= 0.5
            if improved:
                break
            damping *= 8
        if not improved:
            break
        layout = trial
        damping = max(1e-5, damping * (0.25 if step == 1 else 0.7 if step > 0.3 else 2.0))
    return layout


def moved_unturned(
    layout: Layout,
    shares: NDArray[np.float64],
    frames: NDArray[np.float64],
    move: NDArray[np.float64],
) -> tuple[Layout, NDArray[np.float64]]:
    """The layout with its points moved, and the new shares; shorter moves where a triangle suffers.

    Corners of triangles that would shrink to next to nothing, or turn over, halve their moves until
    none does; so one thin triangle does not hold back all others.
    """
    faces = layout.mesh.faces
    step = np.ones(len(move))
    for _ in range(HALVINGS):
        trial = layout.moved(layout.along(frames, step[:, None] * move))
        after = trial.shares
        spoiled = ~(after >= LEAST_SHRINK * shares)
        if not spoiled.any():
            break
        corners = np.unique(faces[spoiled])
        step[corners] *= 0.5
    return trial, after


def _star(layout: Layout, target: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...] | None:
    """Rings and the shares wanted, as `settle` reads them; None where vertices move together only.

    That is on hyperbolic surfaces, and where a vertex has too many neighbours.
    """
    mesh = layout.mesh
    if mesh.genus > 1:
        return None
    *rings, built = build_rings(mesh.faces, layout.corner_shift, len(layout.points))
    after, _ = corner_tables(mesh.faces, rings[0], rings[2], target, np.zeros(mesh.faces.shape))
    return (*rings, after) if built else None


@njit(cache=True, error_model="numpy", nogil=True)
def _even_out(star, points, rounds, flat):
    """Move each vertex by itself by damped Newton steps on Σ A²/a + a around it, so many rounds."""
    whole = 1.0 if flat else 4 * np.pi
    trial = np.empty(3)
    for _ in range(rounds):
        for v in range(len(points)):
            x, y, z = points[v]
            frame = tangents(x, y, z, flat)
            before, g_s, g_t, h_ss, h_st, h_tt = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for i in range(star[2][v]):
                wanted = star[3][v, i]
                area, p, q, r = star_area(v, points[v], i, star, points, flat)
                area /= whole
                a = (p * frame[0] + q * frame[1] + r * frame[2]) / whole
                b = (p * frame[3] + q * frame[4] + r * frame[5]) / whole
                before += (area - wanted) ** 2 / area
                first, second = 1.0 - (wanted / area) ** 2, 2.0 * wanted**2 / area**3
                g_s, g_t = g_s + first * a, g_t + first * b
                h_ss, h_st, h_tt = (
                    h_ss + second * a * a,
                    h_st + second * a * b,
                    h_tt + second * b * b,
                )
            lift = LEAST_CURVATURE * (h_ss + h_tt) + 1e-300
            h_ss, h_tt = h_ss + lift, h_tt + lift
            determinant = h_ss * h_tt - h_st * h_st
            s, t = (h_st * g_t - h_tt * g_s) / determinant, (h_st * g_s - h_ss * g_t) / determinant
            for _ in range(OWN_HALVINGS):
                for d in range(3):
                    trial[d] = points[v, d] + s * frame[d] + t * frame[3 + d]
                if not flat:
                    trial /= np.sqrt((trial**2).sum())
                after = 0.0
                for i in range(star[2][v]):
                    wanted = star[3][v, i]
                    area = star_area(v, trial, i, star, points, flat)[0] / whole
                    after += (area - wanted) ** 2 / area if area > 0.0 else np.inf
                if after < before:
                    points[v] = trial
                    break
                s, t = 0.5 * s, 0.5 * t


def _energy(shares: NDArray[np.float64], target: NDArray[np.float64], far: bool) -> float:
    if far:
        return float((target**2 / shares + shares - 2 * target).sum())
    return float(((shares - target) ** 2 / target).sum())
