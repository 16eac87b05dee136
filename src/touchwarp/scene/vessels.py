"""A coffee mug and a tea cup with handles: closed surfaces of genus 1, standing on z = 0.

| in mm                     | mug           | tea cup        |
|---------------------------|---------------|----------------|
| diameter at the lip       | 80            | 104            |
| diameter at the foot      | 80            | 52             |
| height                    | 95            | 58             |
| wall, floor               | 4, 6          | 3, 4           |
| lip, outer foot: rounding | 1.8, 3        | 1.3, 2         |
| handle, in +x, reaches to | x = 74.5      | x = 71         |
| handle's section          | 9 × 13        | 6.4 × 9        |

Curved faces are inscribed to 0.02 mm.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.scene.shapes import FACET_MM, circle_segments
from touchwarp.scene.surface import Surface

# A corner of a profile: (distance from the axis, height, radius of its rounding), mm.
Corner = tuple[float, float, float]


def mug() -> Surface:
    """A straight coffee mug, 80 mm wide and 95 mm tall, its handle in +x."""
    outside: list[Corner] = [(0, 0, 0), (40, 0, 3), (40, 95, 1.8)]
    cavity: list[Corner] = [(36, 95, 1.8), (36, 6, 5), (0, 6, 0)]
    handle = _ring(centre=(46.0, 48.5), reach=(24.0, 32.0), section=(4.5, 6.5))
    return _vessel(outside, cavity, wall=4.0, handle=handle)


def tea_cup() -> Surface:
    """A wide, low tea cup with a sloped wall, 104 mm wide and 58 mm tall, its handle in +x."""
    outside: list[Corner] = [(0, 0, 0), (26, 0, 2), (42, 17, 30), (52.36, 58, 1.3)]
    cavity: list[Corner] = [(49.36, 58, 1.3), (39.3, 18.2, 27), (25, 4, 3), (0, 4, 0)]
    handle = _ring(centre=(53.5, 34.0), reach=(14.3, 16.0), section=(3.2, 4.5))
    return _vessel(outside, cavity, wall=3.0, handle=handle)


def _vessel(outside: list[Corner], cavity: list[Corner], wall: float, handle: Any) -> Surface:
    """Revolve the profile and add the handle; what of it is inside the cavity is cut away."""
    import manifold3d

    n = circle_segments(max(r for r, _, _ in outside) * 1e-3, FACET_MM)
    body = manifold3d.CrossSection([_rounded(outside + cavity)])
    # The cut runs in the middle of the wall, so that no two faces coincide in the union.
    inner = [(r, z, 0.0) for r, z, _ in cavity]
    top = inner[0]
    room = [(0.0, top[1] + 50, 0.0), (top[0], top[1] + 50, 0.0), *inner]
    hollow = manifold3d.CrossSection([_rounded(room)[::-1]]).offset(
        wall / 2, manifold3d.JoinType.Round, 2.0, 32
    )
    solid = body.revolve(n) + (handle - hollow.revolve(n))
    mesh = solid.to_mesh64()
    return Surface(
        np.asarray(mesh.vert_properties)[:, :3] * 1e-3,
        np.asarray(mesh.tri_verts).astype(np.int64),
    )


def _rounded(corners: list[Corner]) -> NDArray[np.float64]:
    """A polygon (n, 2) mm with every corner rounded by its own radius."""
    plane = np.array([(r, z) for r, z, _ in corners])
    points: list[NDArray[np.float64]] = []
    for i, (_, _, radius) in enumerate(corners):
        corner = plane[i]
        if radius == 0:
            points.append(corner)
            continue
        back, ahead = (_unit(plane[(i + k) % len(plane)] - corner) for k in (-1, 1))
        opening = math.acos(float(np.clip(back @ ahead, -1, 1)))
        centre = corner + _unit(back + ahead) * radius / math.sin(opening / 2)
        start = corner + back * radius / math.tan(opening / 2) - centre
        turn = (math.pi - opening) * math.copysign(1, back[1] * ahead[0] - back[0] * ahead[1])
        steps = max(2, math.ceil(abs(turn) * circle_segments(radius * 1e-3, FACET_MM) / math.tau))
        for k in range(steps + 1):
            c, s = math.cos(turn * k / steps), math.sin(turn * k / steps)
            points.append(centre + np.array([[c, -s], [s, c]]) @ start)
    return np.array(points)


def _ring(
    centre: tuple[float, float], reach: tuple[float, float], section: tuple[float, float]
) -> Any:
    """A closed elliptic tube in the plane y = 0, of elliptic section, mm.

    Args:
        centre: x and z of the ring's centre.
        reach: half-axes of the section's path, in x and z.
        section: half-axes of the section, in the plane and along y.
    """
    import manifold3d

    n = circle_segments((max(reach) + section[0]) * 1e-3, FACET_MM)
    m = circle_segments(max(section) * 1e-3, FACET_MM)
    along = math.tau * np.arange(n)[:, None] / n
    around = math.tau * np.arange(m) / m
    normal = np.stack([np.cos(along) * reach[1], np.sin(along) * reach[0]])
    normal /= np.linalg.norm(normal, axis=0)
    out = section[0] * np.cos(around)
    x = centre[0] + reach[0] * np.cos(along) + normal[0] * out
    z = centre[1] + reach[1] * np.sin(along) + normal[1] * out
    y = np.broadcast_to(section[1] * np.sin(around), x.shape)
    i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    a, b = i * m + j, (i + 1) % n * m + j
    c, d = (i + 1) % n * m + (j + 1) % m, i * m + (j + 1) % m
    faces = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    vertices = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    volume = (vertices[faces[:, 0]] * np.cross(vertices[faces[:, 1]], vertices[faces[:, 2]])).sum()
    if volume < 0:
        faces = faces[:, ::-1]
    return manifold3d.Manifold(
        manifold3d.Mesh64(vertices, np.ascontiguousarray(faces, dtype=np.uint64))
    )


def _unit(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(vector / np.linalg.norm(vector), dtype=np.float64)
