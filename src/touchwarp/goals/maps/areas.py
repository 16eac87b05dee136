"""Area-preserving layouts: each triangle's share of the domain is its share of the surface.

Levenberg–Marquardt on all vertices at once. Far from the aim it descends Σ A²/a + a − 2A, whose
barrier lets no triangle turn over; near it Σ (a − A)²/A, whose minimum is the least spread.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.goals.maps.block_system import BlockSystem
from touchwarp.goals.maps.layout import Layout, area_and_gradient, gather_corners
from touchwarp.goals.maps.star import tangents

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
    faces, flat = layout.mesh.faces, layout.flat
    system = BlockSystem(faces, len(layout.points))
    damping = 1e-2
    shares = layout.shares
    for _ in range(most_steps):
        if spread(shares, target) <= aim:
            break
        far = spread(shares, target) > FAR_SPREAD or (shares / target).min() < FAR_RATIO
        before = _energy(shares, target, far)
        frames = frames_at(layout.points, flat)
        gradient = area_gradients(layout.points, faces, layout.corner_shift, frames, flat)
        gradient /= layout.domain_area
        if far:
            first, second = 1 - (target / shares) ** 2, 2 * target**2 / shares**3
        else:
            first, second = (shares - target) / target, 1 / target
        stiffness = _clipped_cotangents(layout)
        improved = False
        for _ in range(8):
            system.clear()
            system.add_areas(gradient, first, second)
            system.add_differences(damping * stiffness, frames)
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


def frames_at(points: NDArray[np.float64], flat: bool) -> NDArray[np.float64]:
    """(n, 3, 2): two tangents of the domain at each point, as columns."""
    return np.asarray(_frames(points, flat))


def moved_along(
    points: NDArray[np.float64], frames: NDArray[np.float64], move: NDArray[np.float64], flat: bool
) -> NDArray[np.float64]:
    """Points moved by (n, 2) along their tangents, and back onto the domain."""
    moved = points + np.einsum("ndi,ni->nd", frames, move)
    if not flat:
        moved /= np.linalg.norm(moved, axis=1, keepdims=True)
    return np.asarray(moved)


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
        trial = layout.moved(moved_along(layout.points, frames, step[:, None] * move, layout.flat))
        after = trial.shares
        spoiled = after < LEAST_SHRINK * shares
        if not spoiled.any():
            break
        corners = np.unique(faces[spoiled])
        step[corners] *= 0.5
    return trial, after


def _energy(shares: NDArray[np.float64], target: NDArray[np.float64], far: bool) -> float:
    if far:
        return float((target**2 / shares + shares - 2 * target).sum())
    return float(((shares - target) ** 2 / target).sum())


def _clipped_cotangents(layout: Layout) -> NDArray[np.float64]:
    """(m, 3) cotangent weights of the layout itself, kept positive; they only damp."""
    corners = layout.corners
    sides = np.stack(
        [((corners[:, k - 2] - corners[:, k - 1]) ** 2).sum(axis=1) for k in range(3)], axis=1
    )
    areas = np.abs(layout.shares)[:, None] * layout.domain_area
    return np.asarray(
        np.clip((sides.sum(axis=1, keepdims=True) - 2 * sides) / (8 * areas), 0.01, 10)
    )


@njit(cache=True, error_model="numpy")
def _frames(points, flat):
    frames = np.empty((len(points), 3, 2))
    for v in range(len(points)):
        ux, uy, uz, wx, wy, wz = tangents(points[v, 0], points[v, 1], points[v, 2], flat)
        frames[v, 0, 0], frames[v, 1, 0], frames[v, 2, 0] = ux, uy, uz
        frames[v, 0, 1], frames[v, 1, 1], frames[v, 2, 1] = wx, wy, wz
    return frames


@njit(cache=True, error_model="numpy")
def area_gradients(points, faces, corner_shift, frames, flat):
    """(m, 3, 2): how each triangle's area changes with its corners' moves along their tangents."""
    result = np.zeros((len(faces), 3, 2))
    corners = np.empty((3, 3))
    gradient = np.empty((3, 3))
    for f in range(len(faces)):
        gather_corners(points, faces, corner_shift, f, corners)
        area_and_gradient(corners, flat, gradient)
        for k in range(3):
            v = faces[f, k]
            for d in range(3):
                result[f, k, 0] += gradient[k, d] * frames[v, d, 0]
                result[f, k, 1] += gradient[k, d] * frames[v, d, 1]
    return result
