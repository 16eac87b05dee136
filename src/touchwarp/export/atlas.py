"""A surface laid flat: texture coordinates for a mesh that has none."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.scene.uv_mesh import UvMesh

Float = NDArray[np.float64]
Int = NDArray[np.int64]

# A face with less than this part of the usual texels for its size is placed beside another.
LEAST_ROOM = 0.1
# So is one that is thinner than this, in texels: a chart of such a face alone has no texel in it,
# and packing sets others upon it.
LEAST_HEIGHT = 1e-3
# Texels between charts, so that no bilinear sample mixes two.
PADDING = 4


def unwrap(points: Float, faces: Int, size: int) -> tuple[UvMesh, Int, tuple[int, int]]:
    """Lay a surface flat in charts that do not overlap.

    Args:
        points: (n, 3) m.
        faces: (m, 3).
        size: about how many texels wide and high.

    Returns:
        The atlas, its faces in the order given; the point of each of its vertices, (k,); the
        texture's height and width in texels.
    """
    import xatlas

    atlas = xatlas.Atlas()
    # xatlas drops triangles by an absolute area; in tenths of a percent of the prop few are small.
    extent = float(np.ptp(points, axis=0).max())
    positions = (points - points.mean(axis=0)) * (1000 / extent)
    atlas.add_mesh(positions.astype(np.float32), faces.astype(np.uint32))
    packing = xatlas.PackOptions()
    packing.resolution = size
    packing.padding = PADDING
    packing.bilinear = True
    atlas.generate(pack_options=packing)
    rows, placed, uv = (np.asarray(a) for a in atlas.get_mesh(0))
    # what xatlas has dropped lies in the corner, where padding lets nothing else be
    dropped = (uv[placed] == 0).all(axis=2).any(axis=1)
    dropped |= _collapsed(positions[rows[placed]], uv[placed] * [atlas.width, atlas.height])
    rows, placed, uv = with_needles(
        points, rows.astype(np.int64), placed.astype(np.int64), uv.astype(np.float64), dropped
    )
    # xatlas counts v from the image's first row; texture coordinates here have v up.
    flipped = np.stack([uv[:, 0], 1 - uv[:, 1]], axis=1)
    shape = (int(atlas.height), int(atlas.width))
    return UvMesh(points[rows], placed, flipped), rows, shape


def _collapsed(corners: Float, places: Float) -> NDArray[np.bool_]:
    """(m,): which faces have next to no room for their size, as charts of one tiny face have.

    All its corners then share a texel, which cannot hold what each of them is displaced by; or it
    lies on a line, with no texel in it.
    """
    around, room = (
        np.linalg.norm(at - np.roll(at, 1, axis=1), axis=2).sum(axis=1) for at in (corners, places)
    )
    usual = np.median(room[around > 0] / around[around > 0])
    (x1, y1), (x2, y2) = (places[:, 1:] - places[:, :1]).transpose(1, 2, 0)
    shrunk: NDArray[np.bool_] = room < LEAST_ROOM * usual * around
    shrunk |= np.abs(x1 * y2 - y1 * x2) < 0.5 * LEAST_HEIGHT * room
    return shrunk


def with_needles(
    points: Float, rows: Int, faces: Int, uv: Float, dropped: NDArray[np.bool_]
) -> tuple[Int, Int, Float]:
    """The atlas with faces of next to no area put back, flat on an edge that they share.

    Args:
        points: (n, 3) m.
        rows: (k,) the point of each vertex of the atlas.
        faces: (m, 3) of the atlas's vertices.
        uv: (k, 2).
        dropped: (m,) which faces have no place; each gets vertices of its own, in the chart of a
            neighbour, the third corner between the other two.
    """
    faces, new_rows, new_uv = faces.copy(), [rows], [uv]
    count = len(rows)
    # of each edge of the surface, by its points, where its ends are in a face that has a place
    ends: dict[tuple[int, int], tuple[Float, Float]] = {}

    def add_edges(of_rows: Int, at: Float) -> None:
        for i in range(3):
            j = (i + 1) % 3
            ends.setdefault((int(of_rows[i]), int(of_rows[j])), (at[i], at[j]))

    waiting: list[int] = np.flatnonzero(dropped).tolist()
    beside = np.isin(rows[faces], rows[faces[dropped]]).sum(axis=1) >= 2
    for face in faces[beside & ~dropped]:
        add_edges(rows[face], uv[face])
    while waiting:
        left = []
        for f in waiting:
            corners = rows[faces[f]]
            at = _flat_on_an_edge(points[corners], corners, ends)
            if at is None:
                left.append(f)
                continue
            add_edges(corners, at)
            new_rows.append(corners)
            new_uv.append(at)
            faces[f] = count + np.arange(3)
            count += 3
        if len(left) == len(waiting):
            break  # a body of nothing but such faces: it has no place
        waiting = left
    all_rows, all_uv = np.concatenate(new_rows), np.concatenate(new_uv)
    used, index = np.unique(faces, return_inverse=True)
    return all_rows[used], index.reshape(-1, 3), all_uv[used]


def _flat_on_an_edge(
    at: Float, corners: Int, ends: dict[tuple[int, int], tuple[Float, Float]]
) -> Float | None:
    """(3, 2) texture coordinates of a needle's corners on its longest edge that has a place."""
    best, longest = None, -1.0
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        # the face across runs along the edge the other way
        there = ends.get((int(corners[j]), int(corners[i])))
        along = at[j] - at[i]
        square = float(along @ along)
        if there is None or square <= longest:
            continue
        part = float(np.clip((at[k] - at[i]) @ along / square, 0, 1)) if square > 0 else 0.5
        best, longest = np.empty((3, 2)), square
        best[j], best[i] = there
        best[k] = (1 - part) * best[i] + part * best[j]
    return best
