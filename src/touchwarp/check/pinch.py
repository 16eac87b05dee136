"""Pinches: pairs of opposite surface points that thumb and finger can hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.check.case import PropCase
from touchwarp.goals.surface_samples import face_normals

Float = NDArray[np.float64]

WIDEST = 0.1
"""m: the widest pinch."""

NARROWEST = 1e-3
TRIED = 4000
_OPPOSED = np.cos(np.radians(150.0))
"""Normals of the two points differ by at least 150°."""


def find_pinches(prop: PropCase, rng: np.random.Generator) -> tuple[Float, Float, Float]:
    """Points (n, 3) m, widths (n,) m, and how much wider the virtual object is there, (n,).

    From each point a line follows the inward normal; its partner is where that line first leaves
    the prop, across a wall, and where it last does, across the whole.
    """
    taken = rng.choice(len(prop.samples.points), min(TRIED, len(prop.samples.points)), False)
    points = prop.samples.points[taken]
    targets = prop.samples.targets[taken]
    inward = -prop.body.outward * prop.samples.normals[taken]
    eps = 1e-6
    wall = prop.body.first_hit(points + eps * inward, inward) + eps
    whole = WIDEST - prop.body.first_hit(points + WIDEST * inward, -inward)
    found: list[tuple[Float, Float, Float]] = []
    for width in (wall, whole):
        fits = np.isfinite(width) & (width > NARROWEST) & (width <= WIDEST)
        if width is whole:
            fits &= ~(np.abs(whole - wall) < 1e-5)
        opposite = points[fits] + width[fits, None] * inward[fits]
        _, _, face = prop.body.nearest(opposite)
        normals = prop.body.outward * face_normals(prop.goal.prop_points, prop.goal.faces[face])
        opposed = np.einsum("ij,ij->i", normals, -inward[fits]) < _OPPOSED
        seen = np.linalg.norm(_targets(prop, opposite, face) - targets[fits], axis=1)
        change = seen / width[fits] - 1.0
        found.append((points[fits][opposed], width[fits][opposed], change[opposed]))
    return (
        np.concatenate([f[0] for f in found]),
        np.concatenate([f[1] for f in found]),
        np.concatenate([f[2] for f in found]),
    )


def _targets(prop: PropCase, points: Float, face: NDArray[np.int64]) -> Float:
    """g at (n, 3) points that lie on the given faces."""
    corners = prop.goal.faces[face]
    a, b, c = (prop.goal.prop_points[corners[:, k]] for k in range(3))
    e, f, r = b - a, c - a, points - a
    ee, ef, ff = (np.einsum("ij,ij->i", p, q) for p, q in ((e, e), (e, f), (f, f)))
    re, rf = np.einsum("ij,ij->i", r, e), np.einsum("ij,ij->i", r, f)
    det = np.maximum(ee * ff - ef * ef, 1e-300)
    v = np.clip((ff * re - ef * rf) / det, 0.0, 1.0)
    w = np.clip((ee * rf - ef * re) / det, 0.0, 1.0)
    va, vb, vc = (prop.goal.virtual_points[corners[:, k]] for k in range(3))
    targets: Float = va + v[:, None] * (vb - va) + w[:, None] * (vc - va)
    return targets
