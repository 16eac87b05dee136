"""A map's vertices moved one after another, each to where it is best among its neighbours.

What is rough in a map, as after vertices returned, settles in a few rounds, and no thin triangle
holds back the rest; what is smooth is for `refine`, which moves all at once. A vertex descends, by
damped Newton steps on the domain, the energy of `refine` as a function of this vertex alone:

    W |g − y|² + w_f A_i Σ_c (G_c(g) − F_c,i)² + w_b A_i (n·g − h)² + w_a Σ A²/a + a

over the triangles around it. y is where displacement and smoothness want it, given its neighbours,
and W the sum of their weights.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from touchwarp.goals.maps.locate import value_and_slopes, walk_to
from touchwarp.goals.maps.star import tangents

HALVINGS = 8
SHORTER = 0.4
LEAST_CURVATURE = 1e-7


@njit(cache=True, error_model="numpy")
def corner_tables(faces, ring, degree, of_faces, of_corners):
    """Values of faces (m,) and corners (m, 3), as `settle` reads them.

    Returns:
        (n, …) the value of the face after each neighbour, and (n, …) the sum of the values of the
        corners opposite the edge to it.
    """
    after, across = np.zeros(ring.shape), np.zeros(ring.shape)
    for f in range(len(faces)):
        for k in range(3):
            v, ahead, back = faces[f, k], faces[f, (k + 1) % 3], faces[f, (k + 2) % 3]
            for i in range(degree[v]):
                if ring[v, i] == ahead:
                    after[v, i] = of_faces[f]
                    across[v, i] += of_corners[f, (k + 2) % 3]
                elif ring[v, i] == back:
                    across[v, i] += of_corners[f, (k + 1) % 3]
    return after, across


@njit(cache=True, error_model="numpy", nogil=True)
def settle(
    star, points, face, felt, virtual, weights, shares, plane, standing, chosen, rounds, flat
):
    """Move the chosen vertices, so many rounds.

    Args:
        star: (ring, shift, degree) of the prop's mesh (see `rings`), then for each neighbour (n, …)
            the share of area due to the triangle after it, and the cotangents of the edge to it.
        points: (n, 3) of the domain; face: (n,) virtual triangles near them. Both are changed.
        felt: (n, 3 + c) the prop's positions and fields.
        virtual: (corners, neighbours, jumps, faces, values), values (k, 3 + c) like `felt`.
        weights: of displacement, smoothness, area, fields, base.
        shares: (n,) of area.
        plane: (4,) normal and height; standing: (n,) the vertices that shall show on it.
        chosen: (k,) the vertices that may move, in the order in which they do.
        rounds: how many.
        flat: whether the domain is the torus.
    """
    ring, _, degree, _, cotangents = star
    n, channels = felt.shape
    seen, slopes = np.empty((n, channels)), np.empty((channels, 2))
    for v in range(n):
        face[v] = walk_to(points[v], face[v], virtual, flat)
        frame = tangents(points[v, 0], points[v, 1], points[v, 2], flat)
        value_and_slopes(points[v], face[v], virtual, frame, seen[v], slopes, flat)
    wanted, pull = np.empty(channels), np.empty(channels)
    own, trial, spare = np.empty(channels), np.empty(3), np.empty((channels, 2))
    for _ in range(rounds):
        for v in chosen:
            total = weights[0] * shares[v]
            for d in range(3):
                wanted[d] = total * felt[v, d]
            for i in range(degree[v]):
                w, weight = ring[v, i], weights[1] * cotangents[v, i]
                total += weight
                for d in range(3):
                    wanted[d] += weight * (felt[v, d] + seen[w, d] - felt[w, d])
            for d in range(3):
                wanted[d], pull[d] = wanted[d] / total, total
            for c in range(3, channels):
                wanted[c], pull[c] = felt[v, c], weights[3] * shares[v]
            hold = weights[4] * shares[v] if standing[v] else 0.0
            aims = (wanted, pull, plane, hold, weights[2])
            x, y, z = points[v]
            frame = tangents(x, y, z, flat)
            value_and_slopes(points[v], face[v], virtual, frame, own, slopes, flat)
            s, t = _newton_step(v, star, points, aims, own, slopes, frame, flat)
            before = _energy(v, points[v], star, points, aims, own, flat)
            step = 1.0
            for _ in range(HALVINGS):
                for d in range(3):
                    trial[d] = points[v, d] + step * (s * frame[d] + t * frame[3 + d])
                if not flat:
                    trial /= np.sqrt((trial**2).sum())
                there = walk_to(trial, face[v], virtual, flat)
                value_and_slopes(trial, there, virtual, frame, own, spare, flat)
                if _energy(v, trial, star, points, aims, own, flat) < before:
                    points[v], face[v], seen[v] = trial, there, own
                    break
                step *= SHORTER


@njit(cache=True, error_model="numpy")
def _newton_step(v, star, points, aims, own, slopes, frame, flat):
    """The move (s, t) along the frame that would be best were the energy quadratic."""
    wanted, pull, plane, hold, area_weight = aims
    g_s, g_t, h_ss, h_st, h_tt = 0.0, 0.0, 0.0, 0.0, 0.0
    for c in range(len(own)):
        gap, a, b = own[c] - wanted[c], slopes[c, 0], slopes[c, 1]
        g_s, g_t = g_s + pull[c] * gap * a, g_t + pull[c] * gap * b
        h_ss, h_st, h_tt = h_ss + pull[c] * a * a, h_st + pull[c] * a * b, h_tt + pull[c] * b * b
    if hold > 0.0:
        off, a, b = -plane[3], 0.0, 0.0
        for d in range(3):
            off += plane[d] * own[d]
            a += plane[d] * slopes[d, 0]
            b += plane[d] * slopes[d, 1]
        g_s, g_t = g_s + hold * off * a, g_t + hold * off * b
        h_ss, h_st, h_tt = h_ss + hold * a * a, h_st + hold * a * b, h_tt + hold * b * b
    whole = 1.0 if flat else 4 * np.pi
    for i in range(star[2][v]):
        area, x, y, z = star_area(v, points[v], i, star, points, flat)
        area /= whole
        a = (x * frame[0] + y * frame[1] + z * frame[2]) / whole
        b = (x * frame[3] + y * frame[4] + z * frame[5]) / whole
        square = star[3][v, i] ** 2
        first = 0.5 * area_weight * (1.0 - square / area**2)
        second = area_weight * square / area**3
        g_s, g_t = g_s + first * a, g_t + first * b
        h_ss, h_st, h_tt = h_ss + second * a * a, h_st + second * a * b, h_tt + second * b * b
    lift = LEAST_CURVATURE * (h_ss + h_tt) + 1e-300
    h_ss, h_tt = h_ss + lift, h_tt + lift
    determinant = h_ss * h_tt - h_st * h_st
    return (h_st * g_t - h_tt * g_s) / determinant, (h_st * g_s - h_ss * g_t) / determinant


@njit(cache=True, error_model="numpy")
def _energy(v, place, star, points, aims, own, flat):
    wanted, pull, plane, hold, area_weight = aims
    energy = 0.0
    for c in range(len(own)):
        energy += pull[c] * (own[c] - wanted[c]) ** 2
    if hold > 0.0:
        off = plane[0] * own[0] + plane[1] * own[1] + plane[2] * own[2] - plane[3]
        energy += hold * off**2
    whole = 1.0 if flat else 4 * np.pi
    for i in range(star[2][v]):
        area = star_area(v, place, i, star, points, flat)[0] / whole
        if area <= 0.0:
            return np.inf
        energy += area_weight * (star[3][v, i] ** 2 / area + area)
    return energy


@njit(cache=True, error_model="numpy")
def star_area(v, place, i, star, points, flat):
    """The i-th triangle around vertex v, were v at `place`: its area, and how that grows with it.

    What `area_and_gradient` gives for the one corner that moves, with no array to fill.

    Args:
        v: the vertex; place: (3,).
        i: the triangle between the i-th neighbour and the next.
        star: (ring, shift, degree, …) as of `settle`.
        points: (n, 3) of the domain.
        flat: whether the domain is the torus.

    Returns:
        The area, and the three components of its gradient.
    """
    ring, shift, degree = star[0], star[1], star[2]
    j = (i + 1) % degree[v]
    b, c = ring[v, i], ring[v, j]
    ax, ay, az = place[0], place[1], place[2]
    bx, by, bz = points[b, 0] + shift[v, i, 0], points[b, 1] + shift[v, i, 1], points[b, 2]
    cx, cy, cz = points[c, 0] + shift[v, j, 0], points[c, 1] + shift[v, j, 1], points[c, 2]
    gx, gy, gz = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
    det = ax * gx + ay * gy + az * gz
    if flat:
        return 0.5 * det, 0.5 * gx, 0.5 * gy, 0.5 * gz
    rest = 1.0 + (ax * bx + ay * by + az * bz)
    rest += bx * cx + by * cy + bz * cz
    rest += cx * ax + cy * ay + cz * az
    scale = 2.0 / (det * det + rest * rest)
    gx = scale * (rest * gx - det * (bx + cx))
    gy = scale * (rest * gy - det * (by + cy))
    gz = scale * (rest * gz - det * (bz + cz))
    return 2.0 * np.arctan2(det, rest), gx, gy, gz
