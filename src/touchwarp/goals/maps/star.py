"""One vertex among its neighbours on the domain: the barrier energy of its star, and its moves.

A point of the sphere is a unit vector, one of the flat torus (x, y, 1). In both, twice the
oriented area of a triangle is det(a, b, c): on the torus exactly, on the sphere as a barrier that
is positive just where the spherical triangle is turned outward and smaller than a half-sphere. So
one set of formulas serves both; `flat` only chooses tangents and how a moved point comes back to
the domain.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from touchwarp.goals.maps.rings import MOST_NEIGHBOURS


@njit(cache=True, error_model="numpy")
def tangents(x, y, z, flat):
    """Two orthonormal tangents of the domain at a point."""
    if flat:
        return 1.0, 0.0, 0.0, 0.0, 1.0, 0.0
    if abs(x) < 0.6:
        ux, uy, uz = 0.0, -z, y
    else:
        ux, uy, uz = z, 0.0, -x
    n = np.sqrt(ux * ux + uy * uy + uz * uz)
    ux, uy, uz = ux / n, uy / n, uz / n
    return ux, uy, uz, y * uz - z * uy, z * ux - x * uz, x * uy - y * ux


@njit(cache=True, error_model="numpy")
def set_targets(vertices, ring, degree, v, scale, target):
    """Per triangle (v, b, c) of the star: its target area and half its cotangents at v, b, c."""
    for j in range(degree[v]):
        b, c = ring[v, j], ring[v, (j + 1) % degree[v]]
        at_v, at_b, at_c = 0.0, 0.0, 0.0
        for d in range(3):
            at_v += (vertices[c, d] - vertices[b, d]) ** 2
            at_b += (vertices[v, d] - vertices[c, d]) ** 2
            at_c += (vertices[b, d] - vertices[v, d]) ** 2
        total = at_v + at_b + at_c
        square = 2 * (at_v * at_b + at_b * at_c + at_c * at_v)
        square -= at_v * at_v + at_b * at_b + at_c * at_c
        # A sliver counts as a triangle of some width: without area it would have no target.
        area = max(np.sqrt(max(0.0, square)) / 4, 1e-3 * total)
        target[j, 0] = area * scale
        target[j, 1] = (total - 2 * at_v) / (8 * area)
        target[j, 2] = (total - 2 * at_b) / (8 * area)
        target[j, 3] = (total - 2 * at_c) / (8 * area)


@njit(cache=True, error_model="numpy")
def star_energy(points, ring, shift, degree, v, px, py, pz, target, dirichlet, slope, wanted):
    """Σ (a² + μ a D)/B + B over the star of v at p; a: target area, D: Dirichlet energy, B: area.

    Fills slope (9,) with the gradient and the Hessian (xx, yy, zz, xy, xz, yz) in space if wanted.
    Infinite where a triangle is turned over.
    """
    energy = 0.0
    if wanted:
        for i in range(9):
            slope[i] = 0.0
    k = degree[v]
    for j in range(k):
        i = (j + 1) % k
        b, c = ring[v, j], ring[v, i]
        bx, by, bz = points[b, 0] + shift[v, j, 0], points[b, 1] + shift[v, j, 1], points[b, 2]
        cx, cy, cz = points[c, 0] + shift[v, i, 0], points[c, 1] + shift[v, i, 1], points[c, 2]
        gx = 0.5 * (by * cz - bz * cy)
        gy = 0.5 * (bz * cx - bx * cz)
        gz = 0.5 * (bx * cy - by * cx)
        area = gx * px + gy * py + gz * pz
        if area <= 1e-17:
            return np.inf
        ux, uy, uz = bx - px, by - py, bz - pz
        wx, wy, wz = cx - px, cy - py, cz - pz
        ex, ey, ez = cx - bx, cy - by, cz - bz
        at_b, at_c = target[j, 2], target[j, 3]
        stretch = (
            target[j, 1] * (ex * ex + ey * ey + ez * ez)
            + at_b * (wx * wx + wy * wy + wz * wz)
            + at_c * (ux * ux + uy * uy + uz * uz)
        )
        mixed = dirichlet * target[j, 0]
        top = target[j, 0] ** 2 + mixed * stretch
        energy += top / area + area
        if not wanted:
            continue
        dx = -2 * (at_b * wx + at_c * ux)
        dy = -2 * (at_b * wy + at_c * uy)
        dz = -2 * (at_b * wz + at_c * uz)
        m, t = mixed / area, 1.0 - top / (area * area)
        slope[0] += m * dx + t * gx
        slope[1] += m * dy + t * gy
        slope[2] += m * dz + t * gz
        h, r, o = 2 * top / area**3, m / area, 2 * m * (at_b + at_c)
        slope[3] += o + h * gx * gx - 2 * r * dx * gx
        slope[4] += o + h * gy * gy - 2 * r * dy * gy
        slope[5] += o + h * gz * gz - 2 * r * dz * gz
        slope[6] += h * gx * gy - r * (dx * gy + dy * gx)
        slope[7] += h * gx * gz - r * (dx * gz + dz * gx)
        slope[8] += h * gy * gz - r * (dy * gz + dz * gy)
    return energy


@njit(cache=True, error_model="numpy")
def relax(points, ring, shift, degree, v, target, dirichlet, slope, flat):
    """One damped Newton step of v on the energy of its star."""
    px, py, pz = points[v, 0], points[v, 1], points[v, 2]
    args = (points, ring, shift, degree, v)
    start = star_energy(*args, px, py, pz, target, dirichlet, slope, True)
    if start == np.inf:
        return
    ux, uy, uz, wx, wy, wz = tangents(px, py, pz, flat)
    gu = slope[0] * ux + slope[1] * uy + slope[2] * uz
    gw = slope[0] * wx + slope[1] * wy + slope[2] * wz
    hx = slope[3] * ux + slope[6] * uy + slope[7] * uz
    hy = slope[6] * ux + slope[4] * uy + slope[8] * uz
    hz = slope[7] * ux + slope[8] * uy + slope[5] * uz
    uu, uw = hx * ux + hy * uy + hz * uz, hx * wx + hy * wy + hz * wz
    hx = slope[3] * wx + slope[6] * wy + slope[7] * wz
    hy = slope[6] * wx + slope[4] * wy + slope[8] * wz
    hz = slope[7] * wx + slope[8] * wy + slope[5] * wz
    ww = hx * wx + hy * wy + hz * wz
    half, apart = (uu + ww) / 2, np.sqrt(((uu - ww) / 2) ** 2 + uw * uw)
    floor = 1e-6 * (abs(half) + apart) + 1e-300
    lift = max(0.0, floor - (half - apart))
    uu, ww = uu + lift, ww + lift
    det = uu * ww - uw * uw
    du, dw = (uw * gw - ww * gu) / det, (uw * gu - uu * gw) / det
    step = min(1.0, 0.5 / (np.sqrt(du * du + dw * dw) + 1e-300))
    for _ in range(25):
        su, sw = step * du, step * dw
        qx, qy, qz = px + su * ux + sw * wx, py + su * uy + sw * wy, pz + su * uz + sw * wz
        if not flat:
            n = np.sqrt(qx * qx + qy * qy + qz * qz)
            qx, qy, qz = qx / n, qy / n, qz / n
        if star_energy(*args, qx, qy, qz, target, dirichlet, slope, False) < start:
            points[v, 0], points[v, 1], points[v, 2] = qx, qy, qz
            return
        step *= 0.4


@njit(cache=True, error_model="numpy")
def kernel_point(corners, k, flat):
    """A point from which all of a ring (k, 3) is seen, deep inside the ring's kernel.

    The kernel is where n_j · p > 0 for the edges' half-spaces n_j. The search goes from the
    ring's first vertex, onto which the new one had collapsed, and from the ring's middle, then
    climbs the least n_j · p.
    """
    normal = np.empty((MOST_NEIGHBOURS, 3))
    centre = np.zeros(3)
    size = 0.0
    for j in range(k):
        a, b = corners[j], corners[(j + 1) % k]
        normal[j, 0] = a[1] * b[2] - a[2] * b[1]
        normal[j, 1] = a[2] * b[0] - a[0] * b[2]
        normal[j, 2] = a[0] * b[1] - a[1] * b[0]
        n = normal[j, 0] ** 2 + normal[j, 1] ** 2 + (0.0 if flat else normal[j, 2] ** 2)
        n = np.sqrt(n) + 1e-300
        square = 0.0
        for d in range(3):
            normal[j, d] /= n
            centre[d] += a[d] / k
            square += (a[d] - corners[0, d]) ** 2
        size = max(size, np.sqrt(square))
    best = centre.copy()
    _onto_domain(best, flat)
    depth, _ = _least_side(normal, k, best)
    inward = normal[0] + normal[k - 1]
    if flat:
        inward[2] = 0.0
    inward /= np.sqrt((inward**2).sum()) + 1e-300
    reach = size
    for _ in range(60):
        point = corners[0] + reach * inward
        _onto_domain(point, flat)
        side, _ = _least_side(normal, k, point)
        if side > depth:
            depth, best = side, point
        reach *= 0.6
    step = 0.3 * size
    for _ in range(200):
        _, nearest = _least_side(normal, k, best)
        point = best + step * normal[nearest]
        _onto_domain(point, flat)
        side, _ = _least_side(normal, k, point)
        if side > depth:
            depth, best = side, point
        else:
            step *= 0.8
    return best, depth


@njit(cache=True, error_model="numpy")
def _onto_domain(point, flat):
    if flat:
        point[2] = 1.0
    else:
        point /= np.sqrt((point**2).sum()) + 1e-300


@njit(cache=True, error_model="numpy")
def _least_side(normal, k, point):
    least, which = np.inf, 0
    for j in range(k):
        side = normal[j, 0] * point[0] + normal[j, 1] * point[1] + normal[j, 2] * point[2]
        if side < least:
            least, which = side, j
    return least, which
