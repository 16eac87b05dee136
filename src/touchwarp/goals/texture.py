"""The goal of a displacement texture (the paper's Shape Changing Texture Map)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.goal import Goal
from touchwarp.goals.places import spell_point
from touchwarp.goals.subdivision import subdivide
from touchwarp.goals.surface_tree import SurfaceTree
from touchwarp.scene.scene import Prop
from touchwarp.scene.texture_goal import TextureGoal
from touchwarp.scene.uv_mesh import UvMesh

Float = NDArray[np.float64]
Int = NDArray[np.int64]

# How far a vertex of the atlas may lie off the prop: the noise of single precision, and of saving
# a mesh in another tool.
OFF_PROP = 1e-4
# Copies of a vertex on the two sides of a seam may differ by this much before it counts as torn.
SEAM = 1e-3


def texture_goal(prop: Prop, spec: TextureGoal) -> Goal:
    """Points of the atlas show where the texture at their coordinates displaces them to.

    The texture is read bilinearly at the atlas's vertices, and between them where it is not linear.
    On seams, where a point has several coordinates, the mean counts.

    Raises:
        GoalError: the atlas is not on the prop, or covers another part of it; the texture tears
            the surface open along a seam.
    """
    atlas = spec.atlas
    _check_on_prop(prop, atlas)
    # One vertex for all its copies on seams.
    points, joined = np.unique(atlas.vertices[atlas.faces.ravel()], axis=0, return_inverse=True)
    faces = joined.reshape(-1, 3)
    shift = sample_texture(spec.displacement, atlas.uv)[atlas.faces.ravel()]
    count = np.bincount(joined.ravel())
    mean = np.stack([np.bincount(joined.ravel(), column) / count for column in shift.T], axis=1)
    apart = np.linalg.norm(shift - mean[joined.ravel()], axis=1)
    if apart.max() > SEAM:
        n = int(apart.argmax())
        raise GoalError(
            f"the texture tears the surface open: at {spell_point(points[joined.ravel()[n]])} the "
            f"sides of a seam are displaced to places {2e3 * apart[n]:.3g} mm apart; paint both "
            "sides alike, or use a larger texture."
        )

    # What joins the sides of a seam at its corners is faded out linearly over each triangle, so
    # that they also meet in between.
    joining = (mean[joined.ravel()] - shift).reshape(-1, 3, 3)

    def image_of(of_faces: Int, places: Float) -> Float:
        corners = (points[faces], joining, atlas.uv[atlas.faces])
        at, joined_by, uv = (np.einsum("kc,kcd->kd", places, c[of_faces]) for c in corners)
        return np.asarray(at + joined_by + sample_texture(spec.displacement, uv))

    fine = subdivide(points, faces, image_of, None, spec.tolerance_mm * 1e-3)
    report = {**fine.report, "seam_max": 2 * float(apart.max())}
    return Goal(fine.points, fine.virtual_points, fine.faces, kind=spec.kind, report=report)


def _check_on_prop(prop: Prop, atlas: UvMesh) -> None:
    for points, other, how in (
        (atlas.vertices[np.unique(atlas.faces)], prop.surface, "the atlas lies off the prop"),
        (prop.surface.used_vertices, atlas, "the atlas does not cover the prop"),
    ):
        distance = SurfaceTree(other.vertices, other.faces).nearest(points).distance
        n = int(distance.argmax())
        if distance[n] > OFF_PROP:
            raise GoalError(
                f"{how}: the point {spell_point(points[n])} is {distance[n] * 1e3:.3g} mm away. "
                "uv_mesh must be the prop's own surface: check its unit, up and pose."
            )


def sample_texture(image: Float, uv: Float) -> Float:
    """The image (h, w, c) at texture coordinates (n, 2), bilinearly, clamped at its border."""
    rows, columns, weights = texel_weights(image.shape[:2], uv)
    return np.asarray(np.einsum("nk,nkc->nc", weights, image[rows, columns]))


def texel_weights(shape: tuple[int, ...], uv: Float) -> tuple[Int, Int, Float]:
    """The four texels around texture coordinates (n, 2): rows, columns and weights, (n, 4) each.

    Texel centres are at half-integers; v = 0 is the lower border of the last row.
    """
    height, width = shape
    x = np.clip(uv[:, 0] * width - 0.5, 0, width - 1)
    y = np.clip((1 - uv[:, 1]) * height - 0.5, 0, height - 1)
    column = np.minimum(x.astype(np.int64), max(width - 2, 0))
    row = np.minimum(y.astype(np.int64), max(height - 2, 0))
    right, down = x - column, y - row
    rows = np.stack([row, row, row + 1, row + 1], axis=1)
    columns = np.stack([column, column + 1, column, column + 1], axis=1)
    weights = np.stack(
        [(1 - right) * (1 - down), right * (1 - down), (1 - right) * down, right * down], axis=1
    )
    return np.minimum(rows, height - 1), np.minimum(columns, width - 1), weights
