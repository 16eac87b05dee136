"""A goal as a displacement texture: the paper's Shape Changing Texture Map."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.export.atlas import unwrap
from touchwarp.goals.goal import Goal
from touchwarp.goals.texture import sample_texture, texel_weights
from touchwarp.scene.uv_mesh import UvMesh

Float = NDArray[np.float64]
Int = NDArray[np.int64]

TEXELS_PER_POINT = 96
LEAST_SIZE, MOST_SIZE = 256, 2048
SIZE_LIMIT = 8192
# What keeps points that are within a texel of each other from moving it without bound.
CROWDED, ALONE = 3e-2, 1e-6
# Where a face is read to see how far it is off: in its middle and on its sides, barycentric.
_ON_FACES = np.array([[1, 1, 1], [0, 1, 1], [1, 0, 1], [1, 1, 0]]) / [[3], [2], [2], [2]]
# How far beyond its border, in texels, a triangle's displacement is carried on.
BEYOND = 2.0


@dataclass(frozen=True, eq=False)
class ShapeTexture:
    """A prop's surface laid flat, with the displacement of each place.

    Attributes:
        atlas: the goal's faces with texture coordinates, m, scene frame.
        displacement: (h, w, 3) float32 m, scene axes, the top row first.
        at_vertices: (k, 3) m, scene axes: the goal's own displacement of the atlas's vertices.
        error: m: the greatest difference from the goal at its points, read back bilinearly.
        error_between: m: the same on its faces, which are flat where a texture is bilinear.
    """

    atlas: UvMesh
    displacement: NDArray[np.float32]
    at_vertices: Float
    error: float
    error_between: float


def paint_texture(goal: Goal, size: int | None = None) -> ShapeTexture:
    """Lay the goal's faces flat and paint the displacement g − x on them.

    Inside a triangle the texture is the goal's own linear interpolation; at the corners, texels are
    then moved by the least that makes bilinear sampling give the goal's values.

    Args:
        goal: in space.
        size: about how many texels wide and high; by default as the goal's points need.

    Raises:
        GoalError: the goal is of a plane scene, or the size is out of range.
    """
    if goal.prop_points.shape[1] != 3:
        raise GoalError("a texture lays surfaces flat, but the goal is of a plane scene.")
    if size is None:
        wanted = np.sqrt(TEXELS_PER_POINT * len(goal.prop_points))
        size = int(np.clip(2 ** np.ceil(np.log2(wanted)), LEAST_SIZE, MOST_SIZE))
    if not 16 <= size <= SIZE_LIMIT:
        raise GoalError(f"the texture's size is {size} texels; 16 to {SIZE_LIMIT} is needed.")
    atlas, rows, shape = unwrap(goal.prop_points, goal.faces, size)
    displacement = goal.displacement[rows]
    x, y = atlas.uv[:, 0] * shape[1] - 0.5, (1 - atlas.uv[:, 1]) * shape[0] - 0.5
    image = np.zeros((*shape, 3))
    depth = np.full(shape, -np.inf)
    _paint(np.stack([x, y], axis=1), atlas.faces, displacement, image, depth)
    _fill_far(image, depth)
    _fit(image, atlas.uv, displacement)
    single = image.astype(np.float32)
    stored = single.astype(np.float64)
    error = _greatest_difference(stored, atlas.uv, displacement)
    between = 0.0
    for place in _ON_FACES:
        uv = np.einsum("k,fkc->fc", place, atlas.uv[atlas.faces])
        wanted = np.einsum("k,fkc->fc", place, displacement[atlas.faces])
        between = max(between, _greatest_difference(stored, uv, wanted))
    return ShapeTexture(atlas, single, displacement, error, between)


def _greatest_difference(image: Float, uv: Float, wanted: Float) -> float:
    return float(np.linalg.norm(sample_texture(image, uv) - wanted, axis=1).max())


@njit(cache=True)
def _paint(places, faces, values, image, depth):
    """Each triangle's linear interpolation on the texels in it, and a little beyond.

    depth: how deep a texel lies in the triangle that painted it, in texels; negative beyond.
    """
    height, width = depth.shape
    for f in range(len(faces)):
        a, b, c = places[faces[f, 0]], places[faces[f, 1]], places[faces[f, 2]]
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if area == 0.0:
            continue
        # Distances from the sides are barycentric coordinates times heights.
        high_a = abs(area) / np.hypot(c[0] - b[0], c[1] - b[1])
        high_b = abs(area) / np.hypot(a[0] - c[0], a[1] - c[1])
        high_c = abs(area) / np.hypot(b[0] - a[0], b[1] - a[1])
        low_x = max(0, int(np.ceil(min(a[0], b[0], c[0]) - BEYOND)))
        high_x = min(width - 1, int(np.floor(max(a[0], b[0], c[0]) + BEYOND)))
        low_y = max(0, int(np.ceil(min(a[1], b[1], c[1]) - BEYOND)))
        high_y = min(height - 1, int(np.floor(max(a[1], b[1], c[1]) + BEYOND)))
        for y in range(low_y, high_y + 1):
            for x in range(low_x, high_x + 1):
                v = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area
                w = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area
                u = 1.0 - v - w
                inside = min(u * high_a, v * high_b, w * high_c)
                if inside < -BEYOND or inside <= depth[y, x]:
                    continue
                depth[y, x] = inside
                # far beyond a needle, its slope across would carry values out of all bounds
                steepest = min(u, v, w)
                if steepest < -BEYOND:
                    kept = (1 / 3 + BEYOND) / (1 / 3 - steepest)
                    u, v = 1 / 3 + kept * (u - 1 / 3), 1 / 3 + kept * (v - 1 / 3)
                    w = 1.0 - u - v
                for i in range(3):
                    image[y, x, i] = (
                        u * values[faces[f, 0], i]
                        + v * values[faces[f, 1], i]
                        + w * values[faces[f, 2], i]
                    )


def _fill_far(image: Float, depth: Float) -> None:
    """Give texels that no triangle has painted the value of the nearest that one has."""
    from scipy.ndimage import distance_transform_edt

    bare = np.isneginf(depth)
    if bare.any() and not bare.all():
        nearest = distance_transform_edt(bare, return_distances=False, return_indices=True)
        image[bare] = image[nearest[0][bare], nearest[1][bare]]


def _fit(image: Float, uv: Float, values: Float) -> None:
    """Move texels by the least (in square mean) that makes bilinear samples at uv the values.

    With S the sampling and r what is missing, the least change is Sᵀ(S Sᵀ + ε)⁻¹ r. S Sᵀ joins
    only points within a texel of each other. Of those that crowd one no values of texels are right
    for all, as the texture bends where faces meet: exact at each, it would be off by millimetres
    between them.
    """
    from scipy.sparse import csr_matrix, diags
    from scipy.sparse.linalg import splu
    from scipy.spatial import KDTree

    rows, columns, weights = texel_weights(image.shape[:2], uv)
    texel, index = np.unique(rows * image.shape[1] + columns, return_inverse=True)
    sampling = csr_matrix(
        (weights.ravel(), (np.repeat(np.arange(len(uv)), 4), index.ravel())),
        shape=(len(uv), len(texel)),
    )
    places = uv * [image.shape[1], image.shape[0]]
    crowded = KDTree(places).query(places, k=2)[0][:, 1] < 1.0
    flat = image.reshape(-1, 3)
    solver = splu((sampling @ sampling.T + diags(np.where(crowded, CROWDED, ALONE))).tocsc())
    for _ in range(3):  # each pass takes away most of what ε left
        flat[texel] += sampling.T @ solver.solve(values - sampling @ flat[texel])
