"""One vertex among its neighbours on the domain: the barrier energy of its star, and its moves.

A point of the sphere is a unit vector, one of the flat torus (x, y, 1), one of the hyperbolic
plane (x, y, z) with z² − x² − y² = 1. In all three, twice the oriented area of a triangle is
det(a, b, c): on the torus exactly, elsewhere as a barrier that is positive just where the triangle
is turned outward (and, on the sphere, smaller than a half-sphere). So one set of formulas serves
all, with ⟨a, b⟩ = a_x b_x + a_y b_y + κ a_z b_z; the curvature κ = 1, 0 or −1 only chooses that
product, tangents, and how a moved point comes back to the domain.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from touchwarp.goals.maps.rings import MOST_NEIGHBOURS

MOST_REACH = 4.0
"""How far a kernel is searched for from the ring's first vertex; more than a sphere's diameter."""


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
def tangents_on(x, y, z, curvature):
    """Two orthonormal tangents of any of the domains."""
    if curvature >= 0.0:
        return tangents(x, y, z, curvature == 0.0)
    t = -1.0 / (1.0 + z)  # those of (0, 0, 1), carried along the line from there
    return 1.0 - t * x * x, -t * x * y, x, -t * x * y, 1.0 - t * y * y, y


@njit(cache=True, error_model="numpy")
def onto_domain(point, curvature):
    """Bring a point near the domain back onto it; whether that can be done."""
    if curvature == 0.0:
        point[2] = 1.0
        return True
    square = point[0] * point[0] + point[1] * point[1] + curvature * point[2] * point[2]
    if curvature < 0.0 and (square >= 0.0 or point[2] <= 0.0):
        return False
    size = np.sqrt(abs(square)) + 1e-300
    for d in range(3):
        point[d] /= size
    return True


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
def star_energy(around, k, px, py, pz, target, dirichlet, slope, wanted, curvature):
    """Σ (a² + μ a D)/B + B over the star of v at p; a: target area, D: Dirichlet energy, B: area.

    The ring is around[:k]. Fills slope (9,) with the gradient and the Hessian (xx, yy, zz, xy, xz,
    yz) in space if wanted. Infinite where a triangle is turned over.
    """
    energy = 0.0
    if wanted:
        for i in range(9):
            slope[i] = 0.0
    for j in range(k):
        i = (j + 1) % k
        bx, by, bz = around[j, 0], around[j, 1], around[j, 2]
        cx, cy, cz = around[i, 0], around[i, 1], around[i, 2]
        gx = 0.5 * (by * cz - bz * cy)
        gy = 0.5 * (bz * cx - bx * cz)
        gz = 0.5 * (bx * cy - by * cx)
        area = gx * px + gy * py + gz * pz
        if not area > 1e-17:
            return np.inf
        ux, uy, uz = bx - px, by - py, bz - pz
        wx, wy, wz = cx - px, cy - py, cz - pz
        ex, ey, ez = cx - bx, cy - by, cz - bz
        at_b, at_c = target[j, 2], target[j, 3]
        stretch = (
            target[j, 1] * (ex * ex + ey * ey + curvature * ez * ez)
            + at_b * (wx * wx + wy * wy + curvature * wz * wz)
            + at_c * (ux * ux + uy * uy + curvature * uz * uz)
        )
        mixed = dirichlet * target[j, 0]
        top = target[j, 0] ** 2 + mixed * stretch
        energy += top / area + area
        if not wanted:
            continue
        dx = -2 * (at_b * wx + at_c * ux)
        dy = -2 * (at_b * wy + at_c * uy)
        dz = -2 * (at_b * wz + at_c * uz) * curvature
        m, t = mixed / area, 1.0 - top / (area * area)
        slope[0] += m * dx + t * gx
        slope[1] += m * dy + t * gy
        slope[2] += m * dz + t * gz
        h, r, o = 2 * top / area**3, m / area, 2 * m * (at_b + at_c)
        slope[3] += o + h * gx * gx - 2 * r * dx * gx
        slope[4] += o + h * gy * gy - 2 * r * dy * gy
        slope[5] += o * curvature + h * gz * gz - 2 * r * dz * gz
        slope[6] += h * gx * gy - r * (dx * gy + dy * gx)
        slope[7] += h * gx * gz - r * (dx * gz + dz * gx)
        slope[8] += h * gy * gz - r * (dy * gz + dz * gy)
    return energy


@njit(cache=True, error_model="numpy")
def relax(points, ring, shift, degree, v, target, dirichlet, slope, flat):
    """One damped Newton step of v on the energy of its star, on the sphere or the torus."""
    around = np.empty((MOST_NEIGHBOURS, 3))
    for j in range(degree[v]):
        w = ring[v, j]
        around[j, 0] = points[w, 0] + shift[v, j, 0]
        around[j, 1] = points[w, 1] + shift[v, j, 1]
        around[j, 2] = points[w, 2]
    relax_among(around, degree[v], points[v], target, dirichlet, slope, 0.0 if flat else 1.0)


@njit(cache=True, error_model="numpy")
def relax_among(around, k, point, target, dirichlet, slope, curvature):
    """One damped Newton step of a point (3,) on the energy of its star, with ring around[:k]."""
    px, py, pz = point[0], point[1], point[2]
    start = star_energy(around, k, px, py, pz, target, dirichlet, slope, True, curvature)
    if start == np.inf:
        return
    ux, uy, uz, wx, wy, wz = tangents_on(px, py, pz, curvature)
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
    trial = np.empty(3)
    for _ in range(25):
        su, sw = step * du, step * dw
        trial[0], trial[1] = px + su * ux + sw * wx, py + su * uy + sw * wy
        trial[2] = pz + su * uz + sw * wz
        if onto_domain(trial, curvature):
            qx, qy, qz = trial
            if (
                star_energy(around, k, qx, qy, qz, target, dirichlet, slope, False, curvature)
                < start
            ):
                point[:] = trial
                return
        step *= 0.4


@njit(cache=True, error_model="numpy")
def kernel_point(corners, k, flat):
    """`kernel_point_on` the sphere or the torus."""
    return kernel_point_on(corners, k, 0.0 if flat else 1.0)


@njit(cache=True, error_model="numpy")
def kernel_point_on(corners, k, curvature):
    """A point from which all of a ring (k, 3) is seen, deep inside the ring's kernel.

    The kernel is where n_j · p > 0 for the edges' half-spaces n_j. The search goes from the
    ring's first vertex, onto which the new one had collapsed, and from the ring's middle, then
    climbs the least n_j · p.
    """
    normal = np.empty((MOST_NEIGHBOURS, 3))
    best, inward, point = np.zeros(3), np.empty(3), np.empty(3)
    size = 0.0
    for j in range(k):
        a, b = corners[j], corners[(j + 1) % k]
        normal[j, 0] = a[1] * b[2] - a[2] * b[1]
        normal[j, 1] = a[2] * b[0] - a[0] * b[2]
        normal[j, 2] = a[0] * b[1] - a[1] * b[0]
        n = _length(normal[j], curvature) + 1e-300
        for d in range(3):
            normal[j, d] /= n
            best[d] += a[d] / k
            point[d] = a[d] - corners[0, d]
        size = max(size, _length(point, curvature))
    size = min(size, MOST_REACH)
    onto_domain(best, curvature)
    depth, _ = _least_side(normal, k, best)
    for d in range(3):
        inward[d] = normal[0, d] + normal[k - 1, d]
    inward[2] *= curvature
    n = _length(inward, curvature) + 1e-300
    reach = size
    for _ in range(60):
        for d in range(3):
            point[d] = corners[0, d] + reach * (inward[d] / n)
        reach *= 0.6
        if onto_domain(point, curvature):
            side, _ = _least_side(normal, k, point)
            if side > depth:
                depth = side
                best, point = point, best
    step = 0.3 * size
    for _ in range(200):
        _, nearest = _least_side(normal, k, best)
        point[0] = best[0] + step * normal[nearest, 0]
        point[1] = best[1] + step * normal[nearest, 1]
        point[2] = best[2] + step * curvature * normal[nearest, 2]
        deeper = False
        if onto_domain(point, curvature):
            side, _ = _least_side(normal, k, point)
            deeper = side > depth
        if deeper:
            depth = side
            best, point = point, best
        else:
            step *= 0.8
    return best, depth


@njit(cache=True, error_model="numpy")
def _length(vector, curvature):
    square = vector[0] * vector[0] + vector[1] * vector[1]
    return np.sqrt(abs(square + curvature * vector[2] * vector[2]))


@njit(cache=True, error_model="numpy")
def _least_side(normal, k, point):
    least, which = np.inf, 0
    for j in range(k):
        side = normal[j, 0] * point[0] + normal[j, 1] * point[1] + normal[j, 2] * point[2]
        if side < least:
            least, which = side, j
    return least, which
