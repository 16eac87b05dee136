"""The cheap steps of a repair: duplicates, turned faces, pinched places, fragments, caps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.scan.curved_cap import least_area_cap
from touchwarp.scan.deviation import diagonal, face_areas
from touchwarp.scan.soundness import volume
from touchwarp.scene.surface import Surface
from touchwarp.scene.topology import bodies
from touchwarp.scene.weld import weld

Float = NDArray[np.float64]
Int = NDArray[np.int64]

FRAGMENT_SHARE = 0.01
"""A body with less than this share of the area is a fragment."""

PARTING = 1e-3
"""How far a doubled vertex is drawn to the middle of its fan."""

CAP_FLATNESS = 0.25
"""A hole is capped flat if no corner of its rim is farther off its plane than this part of the
rim's radius; others only …"""

SMALL_HOLE = 0.06
"""… if their rim's radius is within this part of the diagonal: 9 mm on a mug."""


def without_duplicates(surface: Surface) -> Surface:
    """Equal vertices welded; of faces with the same corners the first; faces with no area gone."""
    vertices, faces = weld(surface.vertices, surface.faces)
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return Surface(vertices, faces[np.sort(first)])


def oriented(surface: Surface) -> Surface:
    """Faces turned alike: each patch as most of its area was turned, the whole outward.

    A patch is what hangs together by edges of two faces.
    """
    import igl

    alike, patch = igl.bfs_orient(surface.faces)
    alike = np.asarray(alike)
    kept = (alike == surface.faces).all(axis=1)
    area = face_areas(surface)
    vote = np.bincount(patch, weights=np.where(kept, area, -area))
    faces = np.where((vote < 0)[patch][:, None], alike[:, ::-1], alike)
    turned = Surface(surface.vertices, faces)
    return turned if volume(turned) >= 0 else Surface(surface.vertices, faces[:, ::-1])


def unpinched(surface: Surface) -> Surface:
    """Every edge with one or two faces and every vertex with one fan, by doubling vertices.

    The doubles are drawn a little into their fans, so that no reader welds them again.
    """
    import igl

    faces, vertex = (np.asarray(a) for a in igl.split_nonmanifold(surface.faces))
    vertices = surface.vertices[vertex]
    doubled = np.bincount(vertex)[vertex] > 1
    if doubled.any():
        count = np.bincount(faces.ravel(), minlength=len(vertices))
        centres = vertices[faces].mean(axis=1)
        fan = (
            np.stack(
                [
                    np.bincount(faces.ravel(), np.repeat(centres[:, k], 3), minlength=len(vertices))
                    for k in range(3)
                ],
                axis=1,
            )
            / np.maximum(count, 1)[:, None]
        )
        vertices = np.where(doubled[:, None], vertices + PARTING * (fan - vertices), vertices)
    return Surface(vertices, faces)


def without_fragments(surface: Surface) -> Surface:
    """Without bodies that have less than 1 % of the area."""
    body = bodies(surface.faces)
    area = np.bincount(body, weights=face_areas(surface))
    keep = (area >= FRAGMENT_SHARE * area.sum())[body]
    return Surface(surface.vertices, surface.faces[keep])


def largest_body(surface: Surface) -> Surface:
    """The body with the greatest area."""
    body = bodies(surface.faces)
    area = np.bincount(body, weights=face_areas(surface))
    return Surface(surface.vertices, surface.faces[body == area.argmax()])


def rims(faces: Int) -> list[Int]:
    """The rim of each hole of an oriented manifold: vertices in the order that a cap runs."""
    start, end = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    base = int(faces.max()) + 1
    open_edge = ~np.isin(start * base + end, end * base + start)
    # the cap's faces run along the rim against those that are there
    after = dict(zip(end[open_edge].tolist(), start[open_edge].tolist(), strict=True))
    found = []
    while after:
        first, vertex = after.popitem()
        rim = [first]
        while vertex != first:
            rim.append(vertex)
            vertex = after.pop(vertex)
        found.append(np.array(rim))
    return found


def capped(surface: Surface) -> Surface | None:
    """Every hole closed by a cap with no new vertices; None where one is neither flat nor small."""
    caps = [surface.faces]
    small = SMALL_HOLE * diagonal(surface)
    for rim in rims(surface.faces):
        corners = surface.vertices[rim]
        cap = _flat_cap(corners)
        if cap is None and np.linalg.norm(corners - corners.mean(axis=0), axis=1).max() < small:
            cap = least_area_cap(corners, _joined(surface.faces, rim))
        if cap is None:
            return None
        caps.append(rim[cap])
    return Surface(surface.vertices, np.concatenate(caps))


def _joined(faces: Int, rim: Int) -> NDArray[np.bool_]:
    """(n, n): which corners of a rim have an edge between them."""
    place = np.full(int(faces.max()) + 1, -1)
    place[rim] = np.arange(len(rim))
    ends = place[faces[(place[faces] >= 0).sum(axis=1) >= 2]]
    ends = np.concatenate([ends[:, [0, 1]], ends[:, [1, 2]], ends[:, [2, 0]]])
    a, b = ends[(ends >= 0).all(axis=1)].T
    joined = np.zeros((len(rim), len(rim)), dtype=np.bool_)
    joined[a, b] = joined[b, a] = True
    return joined


def _flat_cap(rim: Float) -> Int | None:
    """Triangles (n − 2, 3) on the corners of a nearly flat polygon (n, 3), or None."""
    import manifold3d

    if len(rim) == 3:
        return np.array([[0, 1, 2]])
    centred = rim - rim.mean(axis=0)
    normal = np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0)
    if not np.linalg.norm(normal) > 0:
        return None
    normal /= np.linalg.norm(normal)
    radius = np.linalg.norm(centred, axis=1).max()
    if np.abs(centred @ normal).max() > CAP_FLATNESS * radius:
        return None
    side = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    side /= np.linalg.norm(side)
    flat = np.stack([centred @ side, centred @ np.cross(normal, side)], axis=1)
    cap = np.asarray(manifold3d.triangulate([flat])).astype(np.int64)
    if cap.shape != (len(rim) - 2, 3):
        return None
    a, b, c = flat[cap].transpose(1, 0, 2)
    signed = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    return cap if (signed > -1e-9 * radius**2).all() else None
