"""A map on fewer triangles, its image within a tolerance of what it was.

Vertices of an overlay collapse onto neighbours. A vertex inside a flat part of the prop may go to
any neighbour, one on a straight edge of the prop along that edge, others stay: so the prop keeps
its shape exactly, and all images that stay keep their places on the virtual surface. Each vertex
that is gone remains a witness of where its point of the prop belongs: no later collapse may take
the image there farther than the tolerance from it, or turn a triangle away from the normals that
its witnesses, its corners and its own cell of the overlay have.

Half-edge h = 3 f + k runs from corner k of face f to the next; its twin is the other face's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.scene.topology import opposite_halfedges

Float = NDArray[np.float64]
Int = NDArray[np.int64]

MOST_AROUND = 64
MOST_DEGREE = 24
MOST_WITNESSES = 1024
LEVELS = (1 / 16, 1 / 4, 1 / 2, 1.0, 1.0, 1.0)
"""Parts of the tolerance that passes allow, one after another: what costs least goes first."""
LEAST_COSINE = 0.4
"""Between a triangle's image and each normal of the virtual surface under it."""
LEAST_SHAPE = 0.05
"""Of new triangles, where the old ones were better: area over that of an even triangle."""
STRAIGHT = 1e-9
SAME_PLANE = 1.0 - 1e-12


@dataclass(frozen=True, eq=False)
class FineMap:
    """A map on many triangles, and what its simplification must respect.

    Attributes:
        points, images: (n, 3) m: on the prop, and on the virtual surface.
        faces: (m, 3), closed and manifold.
        plane: (m,) which flat part of the prop each face lies in; normal: (m, 3) that part's.
        image_normal: (m, 3) of the virtual surface under each face.
        ratio: (m,) the image's area over the face's, as the map has it.
    """

    points: Float
    images: Float
    faces: Int
    plane: Int
    normal: Float
    image_normal: Float
    ratio: Float


def simplify(
    fine: FineMap, tolerance: float, drift: float, area_factor: float
) -> tuple[Float, Float, Int]:
    """The simpler map: points (k, 3), images (k, 3) and faces (l, 3).

    Args:
        fine: the map.
        tolerance: m, how far its image may stray from what it was, along normals.
        drift: m, the same in any direction.
        area_factor: by which ratios of area may change in either direction, > 1.
    """
    corner_normals = np.zeros((len(fine.points), 3))
    for d in range(3):
        each = np.repeat(fine.image_normal[:, d], 3)
        corner_normals[:, d] = np.bincount(fine.faces.ravel(), each, len(fine.points))
    corner_normals /= np.bincount(fine.faces.ravel(), minlength=len(fine.points))[:, None]
    faces, m = fine.faces.copy(), len(fine.faces)
    opposite = opposite_halfedges(faces, len(fine.points)).reshape(3, m).T
    twin = np.ascontiguousarray(opposite % m * 3 + opposite // m).reshape(-1)
    alive, left = _simplify(
        faces,
        twin,
        fine.points,
        fine.images,
        corner_normals,
        fine.plane,
        fine.normal,
        fine.image_normal,
        fine.ratio,
        np.array(LEVELS),
        (tolerance, drift, area_factor),
    )
    chosen = np.flatnonzero(alive)
    number = np.full(len(alive), -1)
    number[chosen] = np.arange(len(chosen))
    return fine.points[chosen], fine.images[chosen], number[faces[left]]


@njit(cache=True, error_model="numpy")
def _simplify(
    faces, twin, points, images, corner_normals, plane, normal, image_normal, ratio, levels, bounds
):
    n, m = len(points), len(faces)
    start = np.empty(n, np.int64)
    for h in range(3 * m):
        start[faces[h // 3, h % 3]] = h
    alive, left = np.ones(n, np.bool_), np.ones(m, np.bool_)
    changed = np.ones(n, np.bool_)
    head, following = np.full(m, -1), np.full(n, -1)
    ring, out = np.empty(MOST_AROUND, np.int64), np.empty(MOST_AROUND, np.int64)
    other, other_out = np.empty(MOST_AROUND, np.int64), np.empty(MOST_AROUND, np.int64)
    score = np.empty(MOST_AROUND)
    witness, to_face = np.empty(MOST_WITNESSES, np.int64), np.empty(MOST_WITNESSES, np.int64)
    mesh = (faces, points, images, corner_normals, plane, normal, image_normal, ratio)
    for level in levels:
        strict = (bounds[0] * level, bounds[1] * level, 1.0 + (bounds[2] - 1.0) * level)
        if level < 1.0:
            changed[:] = True
        for v in range(n):
            if not alive[v] or not changed[v]:
                continue
            changed[v] = False
            k = _around(faces, twin, start[v], ring, out)
            if k < 0:
                continue
            one, two = _creases(points, plane, twin, v, k, ring, out)
            if one == -2:
                continue
            for i in range(k):
                score[i] = -1.0
                if one < 0 or i in (one, two):
                    score[i] = _shape_after(mesh, v, i, k, ring, out)
            while True:
                i = int(score[:k].argmax())
                if score[i] < 0.0:
                    break
                score[i] = -1.0
                w = ring[i]
                degree = _around(faces, twin, start[w], other, other_out)
                if degree < 0 or not 3 <= degree + k - 4 <= MOST_DEGREE:
                    continue
                if _shared(ring, k, other, degree) != 2:
                    continue
                count = _witnesses(
                    mesh, head, following, v, i, k, ring, out, strict, witness, to_face
                )
                if count < 0:
                    continue
                _collapse(faces, twin, start, left, head, v, i, k, ring, out)
                alive[v] = False
                for j in range(count):
                    following[witness[j]] = head[to_face[j]]
                    head[to_face[j]] = witness[j]
                changed[ring[:k]] = True
                break
    return alive, left


@njit(cache=True, error_model="numpy")
def _around(faces, twin, first, ring, out):
    """Neighbours of a vertex counter-clockwise, and the half-edges to them; -1 for too many."""
    h, k = first, 0
    while True:
        if k == MOST_AROUND:
            return -1
        f, c = h // 3, h % 3
        ring[k], out[k] = faces[f, (c + 1) % 3], h
        k += 1
        h = twin[3 * f + (c + 2) % 3]
        if h == first:
            return k


@njit(cache=True, error_model="numpy")
def _creases(points, plane, twin, v, k, ring, out):
    """The two places in the ring to which v may go; -1, -1: to all; -2, -2: to none."""
    one, two = -1, -1
    for i in range(k):
        if plane[out[i] // 3] != plane[twin[out[i]] // 3]:
            if two >= 0:
                return -2, -2
            if one < 0:
                one = i
            else:
                two = i
    if one < 0:
        return -1, -1
    if two < 0:
        return -2, -2
    px, py, pz = _from(points[v], points[ring[one]])
    qx, qy, qz = _from(points[v], points[ring[two]])
    x, y, z = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
    along = (qx - px) ** 2 + (qy - py) ** 2 + (qz - pz) ** 2
    bent = np.sqrt(x * x + y * y + z * z) > STRAIGHT * along
    if bent or px * qx + py * qy + pz * qz > 0:
        return -2, -2
    return one, two


@njit(cache=True, error_model="numpy")
def _from(start, end):
    return end[0] - start[0], end[1] - start[1], end[2] - start[2]


@njit(cache=True, error_model="numpy")
def _triangle(vertices, a, b, c):
    """Twice the area as a vector, and the sum of squared sides over its greatest area."""
    ux, uy, uz = vertices[b, 0] - vertices[a, 0], vertices[b, 1] - vertices[a, 1], vertices[b, 2]
    uz -= vertices[a, 2]
    wx, wy, wz = vertices[c, 0] - vertices[a, 0], vertices[c, 1] - vertices[a, 1], vertices[c, 2]
    wz -= vertices[a, 2]
    sides = ux * ux + uy * uy + uz * uz + wx * wx + wy * wy + wz * wz
    sides += (wx - ux) ** 2 + (wy - uy) ** 2 + (wz - uz) ** 2
    even = sides / (2 * np.sqrt(3.0)) + 1e-300
    return uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx, even


@njit(cache=True, error_model="numpy")
def _along(x, y, z, normal):
    return x * normal[0] + y * normal[1] + z * normal[2]


@njit(cache=True, error_model="numpy")
def _shape_after(mesh, v, i, k, ring, out):
    """The least shape of the triangles after v goes to ring[i]; -1 where that is worse than poor.

    On the prop and in the image; needles may give way to lesser needles.
    """
    _, points, images, _, _, normal, image_normal, _ = mesh
    before, after = np.inf, np.inf
    w = ring[i]
    for j in range(k):
        f, a, b = out[j] // 3, ring[j], ring[(j + 1) % k]
        x, y, z, even = _triangle(points, v, a, b)
        before = min(before, _along(x, y, z, normal[f]) / even)
        x, y, z, even = _triangle(images, v, a, b)
        before = min(before, _along(x, y, z, image_normal[f]) / even)
        if a == w or b == w:
            continue
        x, y, z, even = _triangle(points, w, a, b)
        after = min(after, _along(x, y, z, normal[f]) / even)
        x, y, z, even = _triangle(images, w, a, b)
        after = min(after, _along(x, y, z, image_normal[f]) / even)
    return after if after > 0.0 and after >= min(before, LEAST_SHAPE) else -1.0


@njit(cache=True, error_model="numpy")
def _shared(ring, k, other, degree):
    shared = 0
    for i in range(k):
        for j in range(degree):
            shared += ring[i] == other[j]
    return shared


@njit(cache=True, error_model="numpy")
def _witnesses(mesh, head, following, v, i, k, ring, out, bounds, witness, to_face):
    """The witnesses of v's star and the new faces that get them; -1 where one is let down."""
    _, points, images, corner_normals, plane, normal, image_normal, ratio = mesh
    area_factor = bounds[2]
    w = ring[i]
    for j in range(k):
        f, a, b = out[j] // 3, ring[j], ring[(j + 1) % k]
        if a == w or b == w:
            continue
        x, y, z, _ = _triangle(points, w, a, b)
        felt = _along(x, y, z, normal[f])
        x, y, z, _ = _triangle(images, w, a, b)
        seen = np.sqrt(x * x + y * y + z * z) + 1e-300
        if _along(x, y, z, image_normal[f]) < LEAST_COSINE * seen:
            return -1
        change = seen / (felt * ratio[f])
        if change > area_factor or change * area_factor < 1.0:
            return -1
        for corner in (w, a, b):
            mean = corner_normals[corner]
            square = mean[0] ** 2 + mean[1] ** 2 + mean[2] ** 2
            if _along(x, y, z, mean) < LEAST_COSINE * square * seen:
                return -1
    point, image = np.empty(3), np.empty(3)
    for j in range(k):  # between v and its neighbours, where diagonals change
        for d in range(3):
            point[d] = 0.5 * (points[v, d] + points[ring[j], d])
            image[d] = 0.5 * (images[v, d] + images[ring[j], d])
        if _strays(mesh, w, k, ring, out, point, image, plane[out[j] // 3], bounds)[0] < 0:
            return -1
    count = 0
    for j in range(-1, k):  # v itself, then those of each face around it
        s = v if j < 0 else head[out[j] // 3]
        part = -1 if j < 0 else plane[out[j] // 3]
        while s >= 0:
            if count == MOST_WITNESSES:
                return -1
            best, x, y, z = _strays(mesh, w, k, ring, out, points[s], images[s], part, bounds)
            if best < 0:
                return -1
            mean = corner_normals[s]
            square = mean[0] ** 2 + mean[1] ** 2 + mean[2] ** 2
            size = np.sqrt(x * x + y * y + z * z) + 1e-300
            if _along(x, y, z, mean) < LEAST_COSINE * square * size:
                return -1
            witness[count], to_face[count] = s, out[best] // 3
            count += 1
            if j < 0:
                break
            s = following[s]
    return count


@njit(cache=True, error_model="numpy")
def _strays(mesh, w, k, ring, out, point, image, part, bounds):
    """Which new face has the point, and its image's normal; -1 where its image strays too far."""
    _, points, images, _, plane, normal, _, _ = mesh
    inside, best = -np.inf, -1
    for t in range(k):
        f = out[t] // 3
        if ring[t] == w or ring[(t + 1) % k] == w or (part >= 0 and plane[f] != part):
            continue
        least = _parts(points, w, ring[t], ring[(t + 1) % k], normal[f], point)[3]
        if least > inside:
            inside, best = least, t
        if least >= 0.0:
            break
    if best < 0:
        return -1, 0.0, 0.0, 0.0
    a, b = ring[best], ring[(best + 1) % k]
    p, q, r, _ = _parts(points, w, a, b, normal[out[best] // 3], point)
    x, y, z, _ = _triangle(images, w, a, b)
    size = np.sqrt(x * x + y * y + z * z) + 1e-300
    gx = p * images[w, 0] + q * images[a, 0] + r * images[b, 0] - image[0]
    gy = p * images[w, 1] + q * images[a, 1] + r * images[b, 1] - image[1]
    gz = p * images[w, 2] + q * images[a, 2] + r * images[b, 2] - image[2]
    if abs(gx * x + gy * y + gz * z) > bounds[0] * size:
        best = -1
    if gx * gx + gy * gy + gz * gz > bounds[1] * bounds[1]:
        best = -1
    return best, x, y, z


@njit(cache=True, error_model="numpy")
def _parts(points, a, b, c, normal, p):
    """Barycentric coordinates of p in a triangle, and the least of them."""
    ux, uy, uz = _from(p, points[a])
    vx, vy, vz = _from(p, points[b])
    wx, wy, wz = _from(p, points[c])
    of_a = _along(vy * wz - vz * wy, vz * wx - vx * wz, vx * wy - vy * wx, normal)
    of_b = _along(wy * uz - wz * uy, wz * ux - wx * uz, wx * uy - wy * ux, normal)
    of_c = _along(uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx, normal)
    total = of_a + of_b + of_c
    return of_a / total, of_b / total, of_c / total, min(of_a, of_b, of_c) / total


@njit(cache=True, error_model="numpy")
def _collapse(faces, twin, start, left, head, v, i, k, ring, out):
    """Move v onto ring[i]; the two faces between them go."""
    w, before = ring[i], (i - 1) % k
    gone, lost = out[i] // 3, out[before] // 3
    c, d = out[i] % 3, out[before] % 3
    for f in (gone, lost):
        left[f] = False
    ahead, back = twin[3 * gone + (c + 1) % 3], twin[3 * gone + (c + 2) % 3]
    near, far = twin[3 * lost + d], twin[3 * lost + (d + 1) % 3]
    for j in range(k):
        faces[out[j] // 3, out[j] % 3] = w
        head[out[j] // 3] = -1
    twin[ahead], twin[back] = back, ahead
    twin[near], twin[far] = far, near
    # `ahead` and `far` end or start at the ring's neighbours of w, `back` and `near` at w
    start[w] = back if faces[back // 3, back % 3] == w else ahead
    for h, o, u in ((ahead, back, ring[(i + 1) % k]), (near, far, ring[before])):
        start[u] = h if faces[h // 3, h % 3] == u else o
