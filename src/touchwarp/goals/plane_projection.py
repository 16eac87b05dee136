"""The goal of height fields: points keep their projected position over a plane (Figure 7a)."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.goal import Goal
from touchwarp.goals.height_field import HeightFields
from touchwarp.goals.places import spell_point
from touchwarp.goals.star_centre import outward_normals
from touchwarp.goals.subdivision import ImageOf, subdivide
from touchwarp.goals.surface_tree import SurfaceTree
from touchwarp.scene.plane_cut import ON_PLANE, cut_by_plane
from touchwarp.scene.projection_goals import Patch, PlaneProjectionGoal
from touchwarp.scene.scene import Prop
from touchwarp.scene.surface import Surface

# The cosine of the angle to its patch's normal at which a face is a wall.
NO_FACING = 1e-6

Float = NDArray[np.float64]
Int = NDArray[np.int64]


def plane_projection_goal(prop: Prop, spec: PlaneProjectionGoal) -> Goal:
    """Points show where the line along the plane's normal crosses the virtual surface.

    With patches, each is carried along its own normal; what is behind all planes must lie on the
    virtual surface as it is. See `HeightFields` for walls and for bodies with two sides.

    Raises:
        GoalError: a point has no partner, a surface lies over itself, or patches leave a gap. The
            message says where.
    """
    surface, gap = prop.surface, spec.gap_mm * 1e-3
    maps: list[Callable[[Float], Float]]
    if spec.normal is not None:
        label = np.zeros(len(surface.faces), dtype=np.int64)
        maps = [HeightFields(surface, spec.virtual, np.array(spec.normal), "body", gap).images]
    elif all(patch.point is None for patch in spec.patches):
        label = _patch_faced(surface, spec.patches)
        maps = [_front_map(surface, spec.virtual, patch, gap) for patch in spec.patches]
    else:
        for patch in spec.patches:
            surface = cut_by_plane(surface, np.array(patch.point), np.array(patch.normal))
        label = _patch_before(surface, spec.patches)
        maps = [_plane_map(surface, spec.virtual, patch, gap) for patch in spec.patches]
        maps.append(_staying(spec.virtual, gap))

    def image_of(faces: Int, places: Float) -> Float:
        points = np.einsum("kc,kcd->kd", places, surface.vertices[surface.faces[faces]])
        images: Float = np.empty_like(points)
        for n in np.unique(label[faces]):
            here = label[faces] == n
            images[here] = maps[n](points[here])
        return images

    widest = _widest_gap(surface, label, len(spec.patches), image_of, gap)
    fine = subdivide(
        surface.vertices, surface.faces, image_of, spec.virtual, spec.tolerance_mm * 1e-3
    )
    return Goal(
        fine.points,
        fine.virtual_points,
        fine.faces,
        kind=spec.kind,
        report={**fine.report, "gap_max": widest},
        virtual_surface=spec.virtual,
    )


def _plane_map(
    surface: Surface, virtual: Surface, patch: Patch, gap: float
) -> Callable[[Float], Float]:
    normal = np.array(patch.normal)
    level = float(np.array(patch.point) @ normal)
    return HeightFields(surface, virtual, normal, level, gap).images


def _front_map(
    surface: Surface, virtual: Surface, patch: Patch, gap: float
) -> Callable[[Float], Float]:
    return HeightFields(surface, virtual, np.array(patch.normal), "front", gap).images


def _staying(virtual: Surface, gap: float) -> Callable[[Float], Float]:
    """The map of what no patch holds: it stays, if the virtual surface is there."""
    tree = SurfaceTree(virtual.vertices, virtual.faces)

    def images(points: Float) -> Float:
        nearest = tree.nearest(points)
        worst = int(nearest.distance.argmax())
        if nearest.distance[worst] > gap:
            raise GoalError(
                f"no patch holds the point {spell_point(points[worst])}, so it would stay, but the "
                f"virtual surface is {nearest.distance[worst] * 1e3:.3g} mm away from it; add a "
                "patch that has it in front of its plane, or make gap_mm larger."
            )
        return nearest.points

    return images


def _patch_before(surface: Surface, patches: Sequence[Patch]) -> Int:
    """(m,) the first patch that has each face in front, or len(patches); faces cross no plane."""
    label = np.full(len(surface.faces), len(patches))
    for n in reversed(range(len(patches))):
        height = (surface.vertices - np.array(patches[n].point)) @ np.array(patches[n].normal)
        label[height[surface.faces].max(axis=1) > ON_PLANE] = n
    return label


def _patch_faced(surface: Surface, patches: Sequence[Patch]) -> Int:
    """(m,) the patch whose normal is nearest to each face's."""
    normals = outward_normals(surface)
    facing = normals @ np.array([patch.normal for patch in patches]).T
    best = np.where(np.abs(normals).max(axis=1) > 0, facing.max(axis=1), 1.0)
    if best.min() <= NO_FACING:
        middle = surface.vertices[surface.faces[best.argmin()]].mean(axis=0)
        raise GoalError(
            f"the face at {spell_point(middle)} faces away from every patch's normal; add a patch "
            "with a normal on its side."
        )
    return np.asarray(facing.argmax(axis=1), dtype=np.int64)


def _widest_gap(surface: Surface, label: Int, patches: int, image_of: ImageOf, gap: float) -> float:
    """The greatest distance, m, between images of a vertex that several patches share."""
    pairs = np.stack([surface.faces.ravel(), np.repeat(label, 3)], axis=1)
    pairs, corner = np.unique(pairs, axis=0, return_index=True)
    images = image_of(corner // 3, np.eye(3)[corner % 3])
    # Rows of one vertex follow one another.
    same = pairs[1:, 0] == pairs[:-1, 0]
    widths = np.where(same, np.linalg.norm(images[1:] - images[:-1], axis=1), 0.0)
    if len(widths) == 0 or widths.max() <= gap:
        return float(widths.max(initial=0.0))
    n = int(widths.argmax())
    names = [f"patch {k + 1}" if k < patches else "what stays" for k in pairs[n : n + 2, 1]]
    raise GoalError(
        f"{names[0]} and {names[1]} do not meet: the point "
        f"{spell_point(surface.vertices[pairs[n, 0]])} of both would show at two places "
        f"{widths[n] * 1e3:.3g} mm apart. Choose planes whose patches agree along their "
        "border, or make gap_mm larger."
    )
