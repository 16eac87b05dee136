"""Area-preserving layouts: each triangle's share of the domain is its share of the surface.

Levenberg–Marquardt on all vertices at once. Far from the aim it descends Σ A²/a + a − 2A, whose
barrier lets no triangle turn over; near it Σ (a − A)²/A, whose minimum is the least spread.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.goals.maps.block_system import BlockSystem
from touchwarp.goals.maps.layout import Layout

FAR_SPREAD = 0.05
FAR_RATIO = 0.3
LEAST_SHRINK = 0.05
"""No step may shrink a triangle to less than this part of its area."""
HALVINGS = 20
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
    """Move the vertices until the spread of area ratios is at most `aim`, or no step helps.

    Args:
        layout: with no triangle turned over.
        target: (m,) the shares wanted; they sum to 1.
        aim: the spread to stop at.
        most_steps: Newton steps at most.
    """
    system = BlockSystem(layout.mesh.faces, len(layout.points))
    damping = 1e-2
    shares = layout.shares
    for _ in range(most_steps):
        if spread(shares, target) <= aim:
            break
        far = spread(shares, target) > FAR_SPREAD or (shares / target).min() < FAR_RATIO
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
        layout, shares = trial, after
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


def _energy(shares: NDArray[np.float64], target: NDArray[np.float64], far: bool) -> float:
    if far:
        return float((target**2 / shares + shares - 2 * target).sum())
    return float(((shares - target) ** 2 / target).sum())
