"""A surface divided finely without being changed: short edges for what is spread over it.

Edges are halved, the longest of their neighbourhood first (Rivara 1997). After each halving the
diagonals of flat quadrangles beside it are turned until the flat parts are Delaunay triangulations
again (Lawson 1977): halving alone would cut the needles of CAD meshes into ever more needles.

Half-edge h = 3 f + k runs from corner k of face f to the next; its twin is the other face's.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.goals.surface_samples import face_areas
from touchwarp.scene.surface import Surface
from touchwarp.scene.weld import weld

Float = NDArray[np.float64]
Int = NDArray[np.int64]

MOST_FACES = 60_000
"""Large surfaces are divided less finely, to about this many faces."""

_FLAT = 1.0 - 1e-12
"""Two faces are in one plane where the cosine between their normals is greater."""


def refine(surface: Surface, longest: float) -> Surface:
    """The same surface with no edge longer than `longest`, m, its vertices welded.

    A surface that would get more than about `MOST_FACES` faces is divided less finely. Edges that
    more than two faces share are divided alike in all of them.
    """
    vertices, faces = weld(surface.vertices, surface.faces)
    area = float(face_areas(vertices, faces).sum())
    # halving may end at half of the longest; as many equilateral triangles would cover the area
    longest = max(longest, 2.0 * math.sqrt(4.0 / math.sqrt(3.0) * area / MOST_FACES))
    side = vertices[faces] - vertices[np.roll(faces, -1, axis=1)]
    if np.linalg.norm(side, axis=2).max() <= longest:
        return Surface(vertices, faces)
    most = 4 * MOST_FACES + len(faces)
    all_vertices = np.empty((len(vertices) + most, 3))
    all_vertices[: len(vertices)] = vertices
    all_faces = np.empty((most, 3), np.int64)
    all_faces[: len(faces)] = faces
    twin = np.full(3 * most, -1)
    twin[: 3 * len(faces)] = _twins(faces, len(vertices))
    n, m = _refine(all_vertices, all_faces, twin, len(vertices), len(faces), longest**2)
    return Surface(*weld(all_vertices[:n], all_faces[:m]))


def _twins(faces: Int, count: int) -> Int:
    """(3 m,) each half-edge's twin; -1 on rims and where faces do not meet two by two, wound alike.

    Nor have two faces with the same three corners twins in each other.
    """
    start, end = faces.reshape(-1), np.roll(faces, -1, axis=1).reshape(-1)
    opposite = np.roll(faces, -2, axis=1).reshape(-1)
    key = np.minimum(start, end) * count + np.maximum(start, end)
    order = np.argsort(key, kind="stable")
    ordered = key[order]
    first = np.flatnonzero(np.r_[True, ordered[1:] != ordered[:-1]])
    size = np.diff(np.r_[first, len(key)])
    one, two = order[first[size == 2]], order[first[size == 2] + 1]
    proper = (start[one] == end[two]) & (opposite[one] != opposite[two])
    one, two = one[proper], two[proper]
    twin = np.full(len(key), -1)
    twin[one], twin[two] = two, one
    return twin


@njit(cache=True, nogil=True)
def _refine(vertices, faces, twin, n, m, longest_squared):
    """Divide until edges are short or the arrays full; the new numbers of vertices and faces."""
    stack = np.empty(4096, np.int64)
    for h in range(3 * m):
        stack[0] = h
        _turn_diagonals(vertices, faces, twin, stack, 1)
    found = True
    while found:
        found = False
        f = 0
        while f < m:
            e = _longest(vertices, faces, f)
            if _squared(vertices, faces, f, e) <= longest_squared:
                f += 1
                continue
            if m + 2 > len(faces):
                return n, m
            found = True
            # across ever longer edges, to one that is the longest on both sides
            t = f
            while twin[3 * t + e] >= 0:
                other = twin[3 * t + e] // 3
                k = _longest(vertices, faces, other)
                if _squared(vertices, faces, other, k) <= _squared(vertices, faces, t, e):
                    break
                t, e = other, k
            size = _halve(vertices, faces, twin, stack, t, e, n, m)
            n += 1
            m += size // 2
            _turn_diagonals(vertices, faces, twin, stack, size)
    return n, m


@njit(cache=True)
def _halve(vertices, faces, twin, stack, t, e, n, m):
    """Halve an edge of face t, and of its neighbour: the middle is vertex n, new faces from m.

    Returns:
        How many half-edges were put on the stack: those that face the new vertex.
    """
    a, b, c = faces[t, e], faces[t, (e + 1) % 3], faces[t, (e + 2) % 3]
    across, right, left = twin[3 * t + e], twin[3 * t + (e + 1) % 3], twin[3 * t + (e + 2) % 3]
    for k in range(3):
        vertices[n, k] = 0.5 * (vertices[a, k] + vertices[b, k])
    _set_face(faces, t, a, n, c)
    _set_face(faces, m, n, b, c)
    _link(twin, 3 * t + 2, left)
    _link(twin, 3 * m + 1, right)
    _link(twin, 3 * t + 1, 3 * m + 2)
    stack[0], stack[1] = 3 * t + 2, 3 * m + 1
    if across < 0:
        twin[3 * t] = twin[3 * m] = -1
        return 2
    g, j = across // 3, across % 3
    d = faces[g, (j + 2) % 3]
    right, left = twin[3 * g + (j + 1) % 3], twin[3 * g + (j + 2) % 3]
    w = m + 1
    _set_face(faces, g, n, a, d)
    _set_face(faces, w, b, n, d)
    _link(twin, 3 * g + 1, right)
    _link(twin, 3 * w + 2, left)
    _link(twin, 3 * w + 1, 3 * g + 2)
    _link(twin, 3 * t, 3 * g)
    _link(twin, 3 * m, 3 * w)
    stack[2], stack[3] = 3 * g + 1, 3 * w + 2
    return 4


@njit(cache=True)
def _turn_diagonals(vertices, faces, twin, stack, size):
    """Turn the half-edges on the stack, and then those around, where that widens flat angles."""
    while size > 0:
        size -= 1
        h = stack[size]
        o = twin[h]
        if o < 0:
            continue
        t, g = h // 3, o // 3
        e, j = h % 3, o % 3
        a, b = faces[t, e], faces[t, (e + 1) % 3]
        c, d = faces[t, (e + 2) % 3], faces[g, (j + 2) % 3]
        if c == d or not _in_one_plane(vertices, a, b, c, d):
            continue
        if _cotangent(vertices, c, a, b) + _cotangent(vertices, d, b, a) >= -1e-9:
            continue
        to_b, to_a = twin[3 * t + (e + 1) % 3], twin[3 * t + (e + 2) % 3]
        from_a, from_d = twin[3 * g + (j + 1) % 3], twin[3 * g + (j + 2) % 3]
        _set_face(faces, t, c, a, d)
        _set_face(faces, g, d, b, c)
        _link(twin, 3 * t, to_a)
        _link(twin, 3 * t + 1, from_a)
        _link(twin, 3 * g, from_d)
        _link(twin, 3 * g + 1, to_b)
        _link(twin, 3 * t + 2, 3 * g + 2)
        if size + 4 <= len(stack):
            stack[size], stack[size + 1] = 3 * t, 3 * t + 1
            stack[size + 2], stack[size + 3] = 3 * g, 3 * g + 1
            size += 4


@njit(cache=True)
def _set_face(faces, f, a, b, c):
    faces[f, 0], faces[f, 1], faces[f, 2] = a, b, c


@njit(cache=True)
def _link(twin, h, o):
    twin[h] = o
    if o >= 0:
        twin[o] = h


@njit(cache=True)
def _squared(vertices, faces, f, e):
    return squared_length(vertices, faces[f, e], faces[f, (e + 1) % 3])


@njit(cache=True)
def squared_length(vertices, a, b):
    """|b − a|²."""
    x, y, z = _difference(vertices, a, b)
    return x * x + y * y + z * z


@njit(cache=True)
def _longest(vertices, faces, f):
    longest, length = 0, -1.0
    for e in range(3):
        squared = _squared(vertices, faces, f, e)
        if squared > length:
            longest, length = e, squared
    return longest


@njit(cache=True)
def _in_one_plane(vertices, a, b, c, d):
    ux, uy, uz = normal_of(vertices, a, b, c)
    wx, wy, wz = normal_of(vertices, a, d, b)
    sizes = np.sqrt((ux * ux + uy * uy + uz * uz) * (wx * wx + wy * wy + wz * wz))
    return ux * wx + uy * wy + uz * wz > _FLAT * sizes


@njit(cache=True)
def normal_of(vertices, a, b, c):
    """(b − a) × (c − a)."""
    px, py, pz = _difference(vertices, a, b)
    qx, qy, qz = _difference(vertices, a, c)
    return py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx


@njit(cache=True)
def _cotangent(vertices, corner, left, right):
    px, py, pz = _difference(vertices, corner, left)
    qx, qy, qz = _difference(vertices, corner, right)
    x, y, z = normal_of(vertices, corner, left, right)
    return (px * qx + py * qy + pz * qz) / max(np.sqrt(x * x + y * y + z * z), 1e-300)


@njit(cache=True)
def _difference(vertices, a, b):
    x, y, z = vertices[a, 0], vertices[a, 1], vertices[a, 2]
    return vertices[b, 0] - x, vertices[b, 1] - y, vertices[b, 2] - z
