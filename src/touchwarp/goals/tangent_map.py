"""What a goal does to the surface at each point: the singular values of its tangent map.

A goal is linear on each face, so ∂g there is a constant matrix between the tangent planes. Its
singular values σ₁ ≥ σ₂ are the greatest and the least stretch, and σ₁σ₂ is the ratio of areas
(Floater & Hormann 2005).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.goals.goal import Goal

Float = NDArray[np.float64]


def tangent_maps(goal: Goal) -> Float:
    """(m, 3, 2): ∂g on each face, from an orthonormal frame of the face into space.

    The frame's first axis is along the face's first edge. Rows of faces without area are NaN.
    """
    a, b, c = (goal.prop_points[goal.faces[:, k]] for k in range(3))
    first, second = b - a, c - a
    length = np.linalg.norm(first, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        axis = first / length[:, None]
        along = np.einsum("ij,ij->i", second, axis)
        height = np.linalg.norm(second - along[:, None] * axis, axis=1)
        a, b, c = (goal.virtual_points[goal.faces[:, k]] for k in range(3))
        across = (b - a) / length[:, None]
        up = ((c - a) - along[:, None] * across) / height[:, None]
    maps = np.stack([across, up], axis=2)
    # an edge's length over a height of rounding size is no slope
    flat = ~(height > 1e-9 * np.maximum(length, np.abs(along)))
    maps[flat] = np.nan
    return maps


def stretches(maps: Float) -> Float:
    """(m, 2) singular values of (m, 3, 2) tangent maps, the greater first.

    σ₁² is the greater root of the Gram matrix. σ₂ is the area that the columns a, b span over σ₁,
    as the lesser root would lose half its digits where the two differ much.
    """
    a, b = maps[:, :, 0], maps[:, :, 1]
    aa, bb, ab = (np.einsum("mi,mi->m", one, other) for one, other in ((a, a), (b, b), (a, b)))
    greatest = np.sqrt(0.5 * (aa + bb + np.hypot(aa - bb, 2.0 * ab)))
    area = np.linalg.norm(np.cross(a, b), axis=1)
    least = np.divide(area, greatest, out=np.zeros_like(area), where=greatest != 0)
    return np.stack([greatest, least], axis=1)


def displacement_gradients(goal: Goal, maps: Float) -> tuple[Float, Float]:
    """|∇(g − x)|² on each face of the prop, and |∇(g⁻¹ − y)|² on each image: (m,), (m,).

    The paper's L2 (eq. 4) restricted to the two surfaces: 0 for a translation. With the face's own
    frame F and J = ∂g, the gradient of the displacement is J − F, and that of the inverse's
    (F − J) J⁺.
    """
    a, b, c = (goal.prop_points[goal.faces[:, k]] for k in range(3))
    with np.errstate(invalid="ignore", divide="ignore"):
        axis = (b - a) / np.linalg.norm(b - a, axis=1)[:, None]
        second = (c - a) - np.einsum("ij,ij->i", c - a, axis)[:, None] * axis
        second /= np.linalg.norm(second, axis=1)[:, None]
    change = maps - np.stack([axis, second], axis=2)
    forward = np.einsum("mij,mij->m", change, change)
    gram = np.einsum("mij,mik->mjk", maps, maps)
    determinant = gram[:, 0, 0] * gram[:, 1, 1] - gram[:, 0, 1] * gram[:, 1, 0]
    adjugate = np.empty_like(gram)
    adjugate[:, 0, 0], adjugate[:, 1, 1] = gram[:, 1, 1], gram[:, 0, 0]
    adjugate[:, 0, 1] = adjugate[:, 1, 0] = -gram[:, 0, 1]
    # |C J⁺|² = trace(C (JᵀJ)⁻¹ Cᵀ)
    product = np.einsum("mij,mjk,mik->m", change, adjugate, change)
    with np.errstate(invalid="ignore", divide="ignore"):
        backward = np.where(determinant > 0, product / determinant, np.inf)
    return forward, np.where(np.isfinite(forward), backward, np.nan)
