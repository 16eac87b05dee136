"""The foot of a thing that stands on a table: closed flat, where the table is.

A scan from a table shows nothing of what stood on it, so its foot is capped flat. The model of a
cup has a ring there, around a hollow. No map sends one to the other and leaves the table in place;
but no hand reaches that hollow while the cup stands. So what is lowest is drawn straight down to
the table, and what it encloses is left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.scan.cleaning import capped, rims
from touchwarp.scan.deviation import area_vectors, diagonal, face_areas
from touchwarp.scan.soundness import inspect
from touchwarp.scene.plane_cut import ON_PLANE, cut_by_plane
from touchwarp.scene.surface import Surface
from touchwarp.scene.topology import bodies

Float = NDArray[np.float64]

HIGHEST = 0.015
"""Of the diagonal: how much of a thing may be drawn down at most; 2 mm of a cup."""
HEIGHTS = 16
"""Heights up to there that are tried, the lowest first."""
ENOUGH = 0.7
"""Of the area at the best of these heights: a lower one does if its outline has so much."""
FLAT = 5e-6
"""m: what is nearer than this to the table is on it."""
ALL = 0.9
"""Of the area of its outline: a foot with so much of it on the table is flat already."""
CAP_POINTS = 400
"""About so many vertices are put inside the flat cap of an outline."""


@dataclass(frozen=True, eq=False)
class Foot:
    """A thing whose foot is flat on the table.

    Attributes:
        surface: m, the foot at the table's height.
        drawn: m: what was lower than this above the table now stands straight on it; 0 where the
            foot was flat.
        hollow: m: how far above the table the highest hollow reached that was closed; 0 for none.
        pieces: flat faces that it stands on: one for a cup, three for a tripod.
    """

    surface: Surface
    drawn: float
    hollow: float
    pieces: int

    def __str__(self) -> str:
        if self.drawn == 0:
            return "its foot is flat"
        drawn = f"the lowest {self.drawn * 1e3:.2g} mm are drawn straight down to the table"
        closed = f", a hollow {self.hollow * 1e3:.2g} mm deep below it is closed"
        return drawn + (closed if self.hollow > 0 else "")


@dataclass(frozen=True, eq=False)
class _Cut:
    """What is left above a height, and how it is bounded there."""

    body: Surface
    height: float
    outlines: list[NDArray[np.int64]]
    area: float
    hollow: float


def with_flat_foot(surface: Surface, height: float = 0.0) -> Foot | None:
    """The same thing with its foot closed flat on a level table, or None where that cannot be.

    The lowest height is taken at which the outline of the foot is whole: lower, a plane would meet
    only parts of an uneven ring. A hollow that opens to a side stays open. None where the hollow
    goes on into the thing, as in a tube; where nothing is near the table; or where the surface is
    not closed.

    Args:
        surface: one closed manifold; m, z up.
        height: m, of the table.
    """
    before = inspect(surface)
    if not before.sound:
        return None
    highest = HIGHEST * diagonal(surface)
    tried = [_cut(surface, height, highest * (k + 1) / HEIGHTS) for k in range(HEIGHTS)]
    cuts = [cut for cut in tried if cut is not None]
    if not cuts:
        return None
    most = max(cut.area for cut in cuts)
    cuts = [cut for cut in cuts if cut.area >= ENOUGH * most]
    pieces = min(len(cut.outlines) for cut in cuts)
    best = next(cut for cut in cuts if len(cut.outlines) == pieces)
    if surface.bounds[0, 2] > height - FLAT and _flat_area(surface, height) > ALL * best.area:
        return Foot(surface, 0.0, 0.0, pieces)
    for closed in (_evenly_closed(best, height), capped(_drawn(best, height))):
        if closed is not None:
            after = inspect(closed)
            if after.sound and after.genus == before.genus:
                return Foot(closed, best.height, best.hollow, pieces)
    return None


def _cut(surface: Surface, table: float, height: float) -> _Cut | None:
    """What is above a height over the table; None where that is not bounded by outlines alone."""
    level = table + height
    if (np.abs(surface.vertices[:, 2] - level) <= ON_PLANE).any():
        return None  # outlines could touch there
    cut = cut_by_plane(surface, np.array([0.0, 0.0, level]), np.array([0.0, 0.0, 1.0]))
    above = cut.vertices[cut.faces][:, :, 2].mean(axis=1) > level
    if not above.any() or above.all():
        return None
    over = Surface(cut.vertices, cut.faces[above])
    part = bodies(over.faces)
    whole = np.bincount(part, weights=face_areas(over)).argmax()
    hollow = 0.0
    for k in range(int(part.max()) + 1):
        piece = over.faces[part == k]
        outlines = rims(piece)
        areas = [_enclosed(over.vertices[rim]) for rim in outlines]
        # seen from below, an outline runs one way, and the rim of a hollow the other
        if k == whole:
            if not outlines or min(areas) <= 0:
                return None
            body, around, area = Surface(over.vertices, piece), outlines, float(sum(areas))
        elif max(areas) > 0:
            return None  # no hollow, but a part that stands by itself
        else:
            hollow = max(hollow, float(over.vertices[piece][:, :, 2].max()) - table)
    return _Cut(body, height, around, area, hollow)


def _drawn(cut: _Cut, table: float) -> Surface:
    """What is left, its outlines drawn down to the table; still open there."""
    vertices = cut.body.vertices.copy()
    for outline in cut.outlines:
        vertices[outline, 2] = table
    return Surface(vertices, cut.body.faces)


def _evenly_closed(cut: _Cut, table: float) -> Surface:
    """What is left, closed on the table by faces that are about even.

    Caps without vertices inside are fans, which layouts of surfaces do not bear. Where an outline
    is too crooked for Delaunay's triangles to keep its edges, the result is not closed.
    """
    from matplotlib.path import Path
    from scipy.spatial import Delaunay, cKDTree

    drawn = _drawn(cut, table)
    vertices, faces = [drawn.vertices], [drawn.faces]
    count = len(drawn.vertices)
    for outline in cut.outlines:
        rim = drawn.vertices[outline, :2]
        edge = float(np.linalg.norm(rim - np.roll(rim, 1, axis=0), axis=1).mean())
        spacing = max(edge, float(np.sqrt(_enclosed(rim) / CAP_POINTS)))
        low, high = rim.min(axis=0), rim.max(axis=0)
        x, y = (np.arange(a, b, spacing) for a, b in zip(low, high, strict=True))
        grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
        grid[::2, :, 1] += spacing / 2
        grid = grid.reshape(-1, 2)
        inner = grid[Path(rim).contains_points(grid) & (cKDTree(rim).query(grid)[0] > spacing / 2)]
        flat = np.concatenate([rim, inner])
        number = np.concatenate([outline, count + np.arange(len(inner))])
        triangles = Delaunay(flat).simplices
        # they run leftward and the outline rightward: one of its own corners alone lies outside it
        # where it meets them in their order
        ahead = (triangles < np.roll(triangles, -1, axis=1)).sum(axis=1) == 2
        triangles = triangles[~(ahead & (triangles < len(rim)).all(axis=1))]
        vertices.append(np.column_stack([inner, np.full(len(inner), table)]))
        faces.append(number[triangles[:, ::-1]])  # they shall look down
        count += len(inner)
    used, compact = np.unique(np.concatenate(faces), return_inverse=True)
    return Surface(np.concatenate(vertices)[used], compact.reshape(-1, 3).astype(np.int64))


def _enclosed(rim: Float) -> float:
    """m²: the area that a rim (n, 3) encloses seen from below, positive where it runs leftward."""
    x, y = rim[:, 0], rim[:, 1]
    return -0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def _flat_area(surface: Surface, height: float) -> float:
    """m² of the faces that lie on the table and look down."""
    on = (np.abs(surface.vertices[surface.faces][:, :, 2] - height) < FLAT).all(axis=1)
    return -float(area_vectors(surface)[on, 2].sum())
