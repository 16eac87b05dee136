"""Concentric circles in the plane: displacement d on the inner one, 0 on the outer.

λ = 0:  u = d ln(R/r) / ln(R/a)
λ > 0:  u = d [K0(sr) I0(sR) − I0(sr) K0(sR)] / [the same at r = a],  s = √λ
"""

import numpy as np
from scipy.special import i0e, k0e


def displacement(x, centre, inner, outer, moved, screening):
    """u (n, 2) m at x (n, 2) m between the circles of radius `inner` and `outer`, m."""
    r = np.linalg.norm(x - centre, axis=1)
    if screening == 0:
        part = np.log(outer / r) / np.log(outer / inner)
    else:
        s = np.sqrt(screening)
        part = _screened(s, r, outer) / _screened(s, inner, outer) * np.exp(-s * (r - inner))
    return part[:, None] * np.asarray(moved)


def _screened(s, r, outer):
    """The bracket above, times exp(s (r − R)): the scaled functions do not overflow."""
    return k0e(s * r) * i0e(s * outer) - i0e(s * r) * k0e(s * outer) * np.exp(-2 * s * (outer - r))


def outline(centre, radius, corners=720):
    """A regular polygon's vertices (n, 2) m and segments (n, 2); its sides bow by r (π/n)² / 2."""
    angle = 2 * np.pi * np.arange(corners) / corners
    points = np.asarray(centre) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    number = np.arange(corners)
    return points, np.stack([number, (number + 1) % corners], axis=1)


def points_between(rng, count, centre, inner, outer):
    """(count, 2) m between the circles: half of them even over the area, half close to `inner`."""
    even = np.sqrt(rng.uniform(inner**2, outer**2, count // 2))
    close = inner + rng.exponential(0.05 * inner, count - count // 2)
    r = np.clip(np.concatenate([even, close]), inner * (1 + 1e-5), outer * (1 - 1e-5))
    angle = rng.uniform(0, 2 * np.pi, count)
    return np.asarray(centre) + r[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
