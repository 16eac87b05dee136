"""Local operations on the edges of a closed triangle mesh: split, collapse, flip, relax.

Half-edge h = 3·face + k runs from corner k of its face to the next; `twin[h]` is the half-edge the
other way. Removed faces have corners −1. `leaving[v]` is any half-edge that leaves vertex v.
`sharp[h]` marks creases, alike on both twins. All faces stay on closed manifolds of the same
topology: a collapse must fulfil the link condition (Dey et al. 1999).
"""

from __future__ import annotations

import numpy as np
from numba import njit

MOVE_FACING = 0.3
"""Least cosine between a face's normals before and after a vertex moves."""

COLLAPSE_FACING = 0.8
"""The same for a collapse: it must not eat thin rims and tips."""

FLIP_FACING = 0.8
"""Least cosine between the new faces of a flip and the mean of the old ones."""

FLATTEST = 0.05
"""A face whose height is less than this part of its base (half of it, by area) is flat."""


@njit(cache=True)
def after(h):
    """The next half-edge of the same face."""
    return h + 1 if h % 3 < 2 else h - 2


@njit(cache=True)
def before(h):
    """The previous half-edge of the same face."""
    return h - 1 if h % 3 > 0 else h + 2


@njit(cache=True)
def split_long(vertices, faces, twin, leaving, sharp, counts, limit):
    """Halve every edge longer than `limit`; new ones too. False where the arrays are full.

    counts: (2,) vertices and faces in use.
    """
    corner = faces.reshape(-1)
    h = -1
    while h + 1 < 3 * counts[1]:
        h += 1
        t = twin[h]
        if corner[h] < 0 or t < h:
            continue
        a, b = corner[h], corner[after(h)]
        if _length2(vertices, a, b) <= limit * limit:
            continue
        m, f = counts
        if m + 1 > len(vertices) or f + 2 > len(faces):
            return False
        for k in range(3):
            vertices[m, k] = 0.5 * (vertices[a, k] + vertices[b, k])
        # faces (a, b, c) and (b, a, d) become (a, m, c), (m, b, c) and (b, m, d), (m, a, d)
        h_bc, h_ca, t_ad, t_db = after(h), before(h), after(t), before(t)
        c, d = corner[h_ca], corner[t_db]
        new_h, new_t = 3 * f, 3 * (f + 1)
        corner[new_h], corner[new_h + 1], corner[new_h + 2] = m, b, c
        corner[new_t], corner[new_t + 1], corner[new_t + 2] = m, a, d
        corner[h_bc] = m
        corner[t_ad] = m
        _glue(twin, sharp, new_h + 1, twin[h_bc], sharp[h_bc])
        _glue(twin, sharp, new_t + 1, twin[t_ad], sharp[t_ad])
        _glue(twin, sharp, h_bc, new_h + 2, False)
        _glue(twin, sharp, t_ad, new_t + 2, False)
        crease = sharp[h]
        _glue(twin, sharp, h, new_t, crease)
        _glue(twin, sharp, t, new_h, crease)
        leaving[m], leaving[a], leaving[b] = new_h, h, t
        leaving[c], leaving[d] = h_ca, t_db
        counts[0], counts[1] = m + 1, f + 2
        h -= 1  # the first half may still be too long
    return True


@njit(cache=True)
def collapse_short(vertices, faces, twin, leaving, sharp, limit, longest):
    """Collapse edges shorter than `limit` where that keeps topology, creases and facing.

    No edge becomes longer than `longest`. A vertex on a crease moves along it or not at all.
    """
    corner = faces.reshape(-1)
    target = np.empty(3)
    done = 0
    for start in range(len(corner)):
        if corner[start] < 0:
            continue
        if _length2(vertices, corner[start], corner[after(start)]) >= limit * limit:
            continue
        for h in (start, twin[start]):
            a, b = corner[h], corner[after(h)]
            creases_a, creases_b = (
                _creases(a, twin, leaving, sharp),
                _creases(b, twin, leaving, sharp),
            )
            if creases_a > 2 or creases_a == 1 or (creases_a == 2 and not sharp[h]):
                continue
            middle = 0.5 if creases_a == 0 and creases_b == 0 else 0.0
            for k in range(3):
                target[k] = vertices[b, k] + middle * (vertices[a, k] - vertices[b, k])
            if not _is_linked(a, b, corner, twin, leaving):
                continue
            if not _faces_well(
                a, b, target, vertices, corner, twin, leaving, longest, COLLAPSE_FACING
            ):
                continue
            if middle > 0 and not _faces_well(
                b, a, target, vertices, corner, twin, leaving, longest, COLLAPSE_FACING
            ):
                continue
            _collapse(h, target, vertices, corner, twin, leaving, sharp)
            done += 1
            break
    return done


@njit(cache=True)
def _collapse(h, target, vertices, corner, twin, leaving, sharp):
    """Vertex a of h = a → b goes; b goes to `target`."""
    t = twin[h]
    a, b = corner[h], corner[after(h)]
    g = leaving[a]
    while True:
        corner[g] = b
        g = twin[before(g)]
        if g == leaving[a]:
            break
    h_bc, h_ca, t_ad, t_db = after(h), before(h), after(t), before(t)
    c, d = corner[h_ca], corner[t_db]
    c_to_b, b_to_c, d_to_b, b_to_d = twin[h_bc], twin[h_ca], twin[t_ad], twin[t_db]
    _glue(twin, sharp, c_to_b, b_to_c, sharp[h_bc] or sharp[h_ca])
    _glue(twin, sharp, d_to_b, b_to_d, sharp[t_ad] or sharp[t_db])
    for removed in (h, t):
        corner[removed] = corner[after(removed)] = corner[before(removed)] = -1
    leaving[a], leaving[b], leaving[c], leaving[d] = -1, b_to_c, c_to_b, d_to_b
    for k in range(3):
        vertices[b, k] = target[k]


@njit(cache=True)
def flip_for_valence(vertices, faces, twin, leaving, sharp):
    """Flip each edge whose flip brings its four vertices nearer to six neighbours each."""
    corner = faces.reshape(-1)
    done = 0
    for h in range(len(corner)):
        t = twin[h]
        if corner[h] < 0 or t < h or sharp[h]:
            continue
        a, b = corner[h], corner[t]
        c, d = corner[before(h)], corner[before(t)]
        n_a, n_b = _valence(a, twin, leaving), _valence(b, twin, leaving)
        n_c, n_d = _valence(c, twin, leaving), _valence(d, twin, leaving)
        now = abs(n_a - 6) + abs(n_b - 6) + abs(n_c - 6) + abs(n_d - 6)
        then = abs(n_a - 7) + abs(n_b - 7) + abs(n_c - 5) + abs(n_d - 5)
        if then >= now or n_a <= 3 or n_b <= 3 or c == d:
            continue
        if _is_edge(c, d, corner, twin, leaving) or not _flips_well(vertices, a, b, c, d):
            continue
        h_bc, h_ca, t_ad, t_db = after(h), before(h), after(t), before(t)
        beyond = (twin[h_ca], twin[t_ad], twin[t_db], twin[h_bc])
        crease = (sharp[h_ca], sharp[t_ad], sharp[t_db], sharp[h_bc])
        # (a, b, c) and (b, a, d) become (d, c, a) and (c, d, b)
        corner[h], corner[h_bc], corner[h_ca] = d, c, a
        corner[t], corner[t_ad], corner[t_db] = c, d, b
        _glue(twin, sharp, h_bc, beyond[0], crease[0])
        _glue(twin, sharp, h_ca, beyond[1], crease[1])
        _glue(twin, sharp, t_ad, beyond[2], crease[2])
        _glue(twin, sharp, t_db, beyond[3], crease[3])
        leaving[a], leaving[b], leaving[c], leaving[d] = h_ca, t_db, h_bc, t_ad
        done += 1
    return done


@njit(cache=True)
def relaxed(vertices, faces, twin, leaving, sharp):
    """Where each vertex would go: to its neighbours' middle along its tangent plane; and how many
    creases it has, (n,), −1 for one that was removed. Vertices on creases stay."""
    corner = faces.reshape(-1)
    target = vertices.copy()
    creases = np.full(len(vertices), -1, np.int64)
    for v in range(len(vertices)):
        if leaving[v] < 0:
            continue
        creases[v] = _creases(v, twin, leaving, sharp)
        if creases[v] > 0:
            continue
        middle, normal = np.zeros(3), np.zeros(3)
        count = 0
        h = leaving[v]
        while True:
            x, y = corner[after(h)], corner[before(h)]
            middle += vertices[x]
            normal += np.cross(vertices[x] - vertices[v], vertices[y] - vertices[v])
            count += 1
            h = twin[before(h)]
            if h == leaving[v]:
                break
        step = middle / count - vertices[v]
        size2 = (normal * normal).sum()
        if size2 > 0:
            target[v] = vertices[v] + step - normal * ((normal * step).sum() / size2)
    return target, creases


@njit(cache=True)
def place(vertices, faces, twin, leaving, target):
    """Move each vertex to its target, or half or a quarter of the way, if no face turns over."""
    corner = faces.reshape(-1)
    for v in range(len(vertices)):
        if leaving[v] < 0:
            continue
        part = 1.0
        for _ in range(3):
            goal = vertices[v] + part * (target[v] - vertices[v])
            if _faces_well(v, -1, goal, vertices, corner, twin, leaving, np.inf, MOVE_FACING):
                vertices[v] = goal
                break
            part *= 0.5


@njit(cache=True)
def _faces_well(a, b, target, vertices, corner, twin, leaving, longest, facing):
    """Whether a may go to `target` without turning a face over; faces that hold b are left out."""
    h = leaving[a]
    while True:
        x, y = corner[after(h)], corner[before(h)]
        if x != b and y != b:
            p, q = vertices[x], vertices[y]
            if b >= 0 and ((p - target) ** 2).sum() > longest * longest:
                return False
            old = np.cross(p - vertices[a], q - vertices[a])
            new = np.cross(p - target, q - target)
            old2, new2 = (old * old).sum(), (new * new).sum()
            base2 = ((p - q) ** 2).sum()
            flat = FLATTEST**2 * base2 * base2
            if new2 <= flat:
                # it may stay flat where it was flat
                if new2 < old2 or new2 == 0.0:
                    return False
            elif old2 > 0.01 * flat and (old * new).sum() < facing * np.sqrt(old2 * new2):
                return False
        h = twin[before(h)]
        if h == leaving[a]:
            return True


@njit(cache=True)
def _flips_well(vertices, a, b, c, d):
    """Whether the edge c–d, in place of a–b, leaves both faces facing as they did."""
    pa, pb, pc, pd = vertices[a], vertices[b], vertices[c], vertices[d]
    first, second = np.cross(pb - pa, pc - pa), np.cross(pa - pb, pd - pb)
    size = np.sqrt((first * first).sum()), np.sqrt((second * second).sum())
    if size[0] == 0.0 or size[1] == 0.0:
        return False
    facing = first / size[0] + second / size[1]
    length = np.sqrt((facing * facing).sum())
    for new in (np.cross(pc - pd, pa - pd), np.cross(pd - pc, pb - pc)):
        new_size = np.sqrt((new * new).sum())
        if new_size <= FLATTEST * ((pc - pd) ** 2).sum():
            return False
        if (facing * new).sum() < FLIP_FACING * length * new_size:
            return False
    return True


@njit(cache=True)
def _is_linked(a, b, corner, twin, leaving):
    """The link condition: exactly two vertices neighbour both, and neither has only three faces."""
    common = 0
    g = leaving[a]
    while True:
        x = corner[after(g)]
        if x != b and _is_edge(b, x, corner, twin, leaving):
            common += 1
            if _valence(x, twin, leaving) <= 3:
                return False
        g = twin[before(g)]
        if g == leaving[a]:
            return common == 2


@njit(cache=True)
def _is_edge(a, b, corner, twin, leaving):
    h = leaving[a]
    while True:
        if corner[after(h)] == b:
            return True
        h = twin[before(h)]
        if h == leaving[a]:
            return False


@njit(cache=True)
def _valence(v, twin, leaving):
    count = 0
    h = leaving[v]
    while True:
        count += 1
        h = twin[before(h)]
        if h == leaving[v]:
            return count


@njit(cache=True)
def _creases(v, twin, leaving, sharp):
    """How many sharp edges meet at v."""
    count = 0
    h = leaving[v]
    while True:
        count += sharp[h]
        h = twin[before(h)]
        if h == leaving[v]:
            return count


@njit(cache=True)
def _length2(vertices, a, b):
    length2 = 0.0
    for k in range(3):
        length2 += (vertices[a, k] - vertices[b, k]) ** 2
    return length2


@njit(cache=True)
def _glue(twin, sharp, h, t, crease):
    twin[h], twin[t] = t, h
    sharp[h] = sharp[t] = crease
