"""The common overlay of two layouts: the coarsest triangles on which their map is linear.

Laid over one another on the domain, the triangles of the prop and of the virtual object cut each
other into cells. A cell lies in one triangle of each, so the map sends it onto a piece of a face of
the virtual object by one affine map (on the sphere, by one projective map, whose affine
interpolant on a triangulated cell has the same image). Where neither layout turns a triangle over,
nothing of the map does; its image is the virtual surface itself, all of it, once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.maps.cell import CROSSING, MOST_CORNERS, PROP_CORNER, VIRTUAL_CORNER, Cells
from touchwarp.goals.maps.closed_mesh import ClosedMesh
from touchwarp.goals.maps.lattice import LatticeLayout, on_lattice
from touchwarp.goals.maps.layout import Layout
from touchwarp.goals.maps.locate import Locator
from touchwarp.goals.maps.meeting import Meetings, cut_cells, find_meetings

Float = NDArray[np.float64]
Int = NDArray[np.int64]

JITTER = 64
"""Units of the lattice by which points are moved where a corner lies on an edge."""
TRIES = 12
PERIODS = 64
"""More than edges of the two layouts are apart."""


@dataclass(frozen=True, eq=False)
class Overlay:
    """A map on the triangles of the overlay.

    Attributes:
        points, images: (n, 3) m, scene frame: on the prop, and on the virtual surface.
        faces: (m, 3).
        prop_face, virtual_face: (m,) the triangles of both meshes that each lies in.
    """

    points: Float
    images: Float
    faces: Int
    prop_face: Int
    virtual_face: Int


def overlay(prop: Layout, virtual: Layout) -> Overlay:
    """The overlay of two layouts on the same domain.

    Raises:
        GoalError: a triangle is too thin.
    """
    locator = Locator(virtual)
    start = locator.find(np.ascontiguousarray(prop.corners[:, 0]))
    other = on_lattice(virtual)
    rng = np.random.default_rng(0)
    jitter: Int | None = None
    for _ in range(TRIES):
        own = on_lattice(prop, jitter)
        meetings = find_meetings(own, other, start)
        if meetings.exact:
            cells = cut_cells(own, other, meetings)
            assert cells.closed, "exact signs close every outline"
            keys = _keys(own, other, meetings, cells)
            return assembled(
                prop.mesh, virtual.mesh, (meetings.prop, meetings.virtual), cells, keys
            )
        jitter = rng.integers(-JITTER, JITTER + 1, size=prop.points.shape)
        if prop.flat:
            jitter[:, 2] = 0
    raise GoalError(
        "the prop and the virtual object cannot be laid over one another without corners on edges; "
        "turn or move the virtual object a little, or remesh one of both."
    )


def assembled(
    prop: ClosedMesh, virtual: ClosedMesh, met: tuple[Int, Int], cells: Cells, keys: Int
) -> Overlay:
    """The overlay from its cells.

    Args:
        prop, virtual: the meshes.
        met: (q,) and (q,) the triangles of each cell.
        cells: the cells (q).
        keys: (k,) one number for each corner that is there, the same for one corner of many cells.
    """
    there = cells.there
    row, _ = np.nonzero(there)
    _, chosen, number = np.unique(keys, return_index=True, return_inverse=True)
    f, t = met[0][row[chosen]], met[1][row[chosen]]
    kind, place, part = (each[there][chosen] for each in (cells.kind, cells.place, cells.part))
    corners = prop.vertices[prop.faces[f]], virtual.vertices[virtual.faces[t]]
    points, images = (np.empty((len(chosen), 3)) for _ in range(2))
    for what, (given, found), (home, away) in (
        (PROP_CORNER, corners, (points, images)),
        (VIRTUAL_CORNER, corners[::-1], (images, points)),
    ):
        some = kind == what
        home[some] = given[some, place[some, 0]]
        away[some] = np.einsum("nk,nkd->nd", part[some], found[some])
    some = np.flatnonzero(kind == CROSSING)
    for side, on in ((0, points), (1, images)):
        edge = place[some, side]
        a, b = corners[side][some, edge], corners[side][some, (edge + 1) % 3]
        on[some] = a + part[some, side, None] * (b - a)
    outline = np.zeros(there.shape, np.int64)
    outline[there] = number.reshape(-1)
    fans = [np.flatnonzero(cells.corners > k + 1) for k in range(1, MOST_CORNERS - 1)]
    return Overlay(
        points,
        images,
        np.concatenate([outline[fan][:, [0, k + 1, k + 2]] for k, fan in enumerate(fans)]),
        np.concatenate([met[0][fan] for fan in fans]),
        np.concatenate([met[1][fan] for fan in fans]),
    )


def _keys(own: LatticeLayout, other: LatticeLayout, meetings: Meetings, cells: Cells) -> Int:
    """(k,): one number for each corner of cells, the same for the same corner of other cells.

    Two edges on a torus may cross more than once; the periods between their frames tell which.
    """
    prop, virtual = own.layout.mesh, other.layout.mesh
    there = cells.there
    row, _ = np.nonzero(there)
    f, t, offset = meetings.prop[row], meetings.virtual[row], meetings.offset[row]
    kind, place = cells.kind[there], cells.place[there]
    keys = np.empty(len(f), np.int64)
    some = kind == PROP_CORNER
    keys[some] = prop.faces[f[some], place[some, 0]]
    some = kind == VIRTUAL_CORNER
    keys[some] = len(prop.vertices) + virtual.faces[t[some], place[some, 0]]
    some = kind == CROSSING
    f, t = f[some], t[some]
    one, low = numbered_edges(prop.faces)
    two, under = numbered_edges(virtual.faces)
    e, k = place[some].T
    between = other.shift[t, under[t, k]] + offset[some] - own.shift[f, low[f, e]]
    assert np.abs(between).max(initial=0) < PERIODS // 2, "edges are shorter than that"
    pair = one[f, e] * (int(two.max()) + 1) + two[t, k]
    apart = (between + PERIODS // 2) @ np.array([PERIODS, 1])
    keys[some] = len(prop.vertices) + len(virtual.vertices) + pair * PERIODS**2 + apart
    return keys


def numbered_edges(faces: Int) -> tuple[Int, Int]:
    """(m, 3), (m, 3): the number of edge k, and which of its two corners has the lower vertex."""
    ahead = faces[:, [1, 2, 0]]
    low, high = np.minimum(faces, ahead), np.maximum(faces, ahead)
    _, number = np.unique(low * (int(faces.max()) + 1) + high, return_inverse=True)
    lower = np.where(faces < ahead, [0, 1, 2], [1, 2, 0])
    return number.reshape(-1, 3), lower
