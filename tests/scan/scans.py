"""Scans with known truth: a mug that was measured badly."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.scan.remesh import remesh
from touchwarp.scene.shapes import make_shape
from touchwarp.scene.surface import Surface
from touchwarp.scene.topology import bodies

Float = NDArray[np.float64]


def fine_mug(edge_length: float = 2e-3) -> Surface:
    """The library's mug in even triangles: genus 1, standing on z = 0, handle in +x."""
    return remesh(make_shape("mug", {}), edge_length)


def noisy(surface: Surface, noise: float, seed: int = 0) -> Surface:
    """Every vertex moved at random, standard deviation `noise` m a coordinate."""
    random = np.random.default_rng(seed)
    return Surface(
        surface.vertices + random.normal(0, noise, surface.vertices.shape), surface.faces
    )


def holed(surface: Surface, centres: Float, radius: float) -> Surface:
    """Without the faces near any of the centres (k, 3)."""
    middles = surface.vertices[surface.faces].mean(axis=1)
    gap = np.linalg.norm(middles[:, None] - centres, axis=2).min(axis=1)
    return Surface(surface.vertices, surface.faces[gap > radius])


def with_turned_faces(surface: Surface, share: float, seed: int = 0) -> Surface:
    """Some faces, at random, turned round."""
    turned = np.random.default_rng(seed).random(len(surface.faces)) < share
    faces = np.where(turned[:, None], surface.faces[:, ::-1], surface.faces)
    return Surface(surface.vertices, faces)


def with_duplicates(surface: Surface, count: int) -> Surface:
    """The first `count` faces twice."""
    return Surface(surface.vertices, np.concatenate([surface.faces, surface.faces[:count]]))


def with_speck(surface: Surface) -> Surface:
    """A tiny tetrahedron floating 1 cm beside it."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * 1e-3
    corners += surface.bounds[1] + 0.01
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]) + len(surface.vertices)
    return Surface(
        np.concatenate([surface.vertices, corners]), np.concatenate([surface.faces, faces])
    )


def with_tunnel(surface: Surface, at: list[float]) -> Surface:
    """A narrow tunnel through a wall: two faces that lie opposite are joined by a prism.

    The face nearest to `at` goes, and so does the one behind it whose middle is nearest.
    """
    middles = surface.vertices[surface.faces].mean(axis=1)
    near = int(np.linalg.norm(middles - at, axis=1).argmin())
    a, b, c = surface.vertices[surface.faces[near]]
    normal = np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a))
    way = middles - middles[near]
    depth = -way @ normal
    aside = np.linalg.norm(way + depth[:, None] * normal, axis=1)
    opposite = (
        np.cross(
            *(
                surface.vertices[surface.faces[:, k]] - surface.vertices[surface.faces[:, 0]]
                for k in (1, 2)
            )
        )
        @ normal
        < 0
    )
    behind = int(np.where(opposite & (depth > 1e-3) & (depth < 0.01), aside, np.inf).argmin())
    near_rim, far_rim = surface.faces[near], surface.faces[behind][::-1]
    # the turn that twists the prism least
    turns = [np.roll(far_rim, k) for k in range(3)]
    gaps = [
        np.linalg.norm(surface.vertices[t] - surface.vertices[near_rim], axis=1).sum()
        for t in turns
    ]
    far_rim = turns[int(np.argmin(gaps))]
    ahead, beyond = np.roll(near_rim, -1), np.roll(far_rim, -1)
    walls = [np.stack(t, axis=1) for t in ((near_rim, ahead, beyond), (near_rim, beyond, far_rim))]
    kept = np.delete(surface.faces, [near, behind], axis=0)
    return Surface(surface.vertices, np.concatenate([kept, *walls]))


def on_table(surface: Surface, side: float = 0.3, spacing: float = 4e-3) -> Surface:
    """A square of table at z = 0 around it; nothing is seen below the foot.

    The object's own faces at z = 0 go, and the table ends at a distance of half a spacing from it.
    """
    heights = surface.vertices[surface.faces][:, :, 2]
    own = Surface(surface.vertices, surface.faces[(heights > 1e-9).any(axis=1)])
    n = round(side / spacing)
    x, y = np.meshgrid(*(np.linspace(-side / 2, side / 2, n + 1),) * 2, indexing="ij")
    table = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    a, b, c, d = ((i + k) * (n + 1) + j + m for k, m in ((0, 0), (1, 0), (1, 1), (0, 1)))
    faces = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    foot = surface.vertices[surface.vertices[:, 2] < 1e-3]
    radius = np.linalg.norm(foot[:, :2], axis=1).max()
    clear = np.linalg.norm(table[:, :2], axis=1) > radius + spacing / 2
    faces = faces[clear[faces].all(axis=1)]
    return Surface(
        np.concatenate([own.vertices, table]),
        np.concatenate([own.faces, faces + len(own.vertices)]),
    )


BEAKER_RADIUS, BEAKER_HEIGHT, HOLLOW = 0.035, 0.08, 0.004
SEGMENTS = 96


def surface_of(solid: Any) -> Surface:
    """The surface of a solid of manifold3d."""
    mesh = solid.to_mesh64()
    return Surface(np.asarray(mesh.vert_properties), np.asarray(mesh.tri_verts).astype(np.int64))


def disc(height: float, radius: float, top: float | None = None) -> Any:
    """A solid cylinder or cone standing on z = 0."""
    from manifold3d import Manifold

    return Manifold.cylinder(height, radius, radius if top is None else top, SEGMENTS)


def ringed() -> Any:
    """A solid cup on a ring 4 mm wide around a hollow 4 mm deep."""
    inside = disc(BEAKER_HEIGHT, BEAKER_RADIUS - 0.004).translate([0, 0, 0.01])
    below = disc(2 * HOLLOW, BEAKER_RADIUS - 0.004).translate([0, 0, -HOLLOW])
    return disc(BEAKER_HEIGHT, BEAKER_RADIUS) - inside - below


def beaker() -> Surface:
    """That cup's surface."""
    return surface_of(ringed())


def stool() -> Surface:
    """A seat on three legs, half a millimetre above the table, as an aligned thing may be."""
    whole = disc(0.02, 0.045).translate([0, 0, 0.04])
    for angle in 2 * np.pi * np.arange(3) / 3:
        at = [0.03 * np.cos(angle), 0.03 * np.sin(angle), 0]
        whole = whole + disc(0.05, 0.008, 0.01).translate(at)
    return surface_of(whole.translate([0, 0, 5e-4]))


def body_count(surface: Surface) -> int:
    """Pieces that share no vertex."""
    return int(bodies(surface.faces).max()) + 1
