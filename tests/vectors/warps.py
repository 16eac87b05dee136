"""Small warps, in closed form, of every kind that a warp file can hold."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.exact.sample_bricks import sample_bricks
from tests.exact.sources import PointSources
from tests.exact.spheres import SphereWarp, radial
from tests.warp.tables import META, turned
from touchwarp.warp.bases import AffineBases
from touchwarp.warp.file import write_warp
from touchwarp.warp.meta import BasisProp
from touchwarp.warp.plane_table import PlaneTableWarp
from touchwarp.warp.plane_values import PlaneTable
from touchwarp.warp.table import TableWarp

Float = NDArray[np.float64]

HALF = 0.25
"""m, half a box's side: a power of two, so that borders of cells are exact numbers."""
LOW, HIGH = np.full(3, -HALF), np.full(3, HALF)
RADIUS = 0.05
NEAR = np.array([0.03, 0.035, 0.02])
"""On the sphere, up to rounding; bricks are refined around it."""

POSE = turned((0.2, 1.0, -0.4), 1.1, (0.4, 1.2, -0.3))
GOALS = {
    "bases": {"ball": turned((1, 2, 3), 0.15, (0.01, -0.02, 0.015)) * [1.2, 1, 1, 1]},
    "sliding_bases": {"mug": np.diag([1.1, 0.9, 1.2, 1.0])},
}


def around(point: Any, reach: float = 1.2) -> Callable[[Float, Float], NDArray[np.bool_]]:
    """Refine what comes close to a point."""

    def near(centres: Float, halves: Float) -> NDArray[np.bool_]:
        return np.asarray((np.abs(centres - point) < reach * halves).all(axis=-1))

    return near


def levels() -> TableWarp:
    """Four levels in float32 around one point of a sphere."""
    sphere = SphereWarp(
        radius=RADIUS,
        outer_radius=HALF,
        shift=np.array([0.02, 0.004, -0.006]),
        stretch=np.array([[0.2, 0.1, 0.0], [0.0, -0.1, 0.05], [0.1, 0.0, 0.3]]),
    )
    grid = {"root_shape": (1, 1, 1), "depth": 3, "refine": around(NEAR)}
    return TableWarp(sample_bricks(sphere.displacement, LOW, HIGH, **grid), META)


def half() -> TableWarp:
    """Three levels in a turned frame over a sliding plane, to be stored as float16.

    The coarsest brick leaves all to its children.
    """
    sources = PointSources(
        np.array([[0.02, -0.01, 0.08]]), np.array([[8e-4, -4e-4, 6e-4]]), mirrored=True
    )
    T = turned(shift=(0.1, 0.2, -0.1))

    def displacement(x: Float) -> Float:
        return sources.displacement((x - T[:3, 3]) @ T[:3, :3] - [HALF, HALF, 0.0]) @ T[:3, :3].T

    def refine(centres: Float, halves: Float) -> NDArray[np.bool_]:
        return around([0.3, 0.2, 0.05], 0.9)(centres, halves) | (halves[:, 0] > 0.1)

    bricks = sample_bricks(
        displacement,
        [0.0, 0.0, 0.0],
        [2 * HALF, 2 * HALF, HALF],
        root_shape=(1, 1, 1),
        depth=2,
        refine=refine,
        T_scene_table=T,
        mirror_depth=0.06,
        zero_outside=False,
    )
    return TableWarp(bricks, replace(META, outer_box=None))


def bases() -> AffineBases:
    """The four basis fields of a sphere in a turned frame."""
    T = turned()
    size, centre = np.sqrt(3.0) * RADIUS, np.full(3, HALF)

    def lanes(x: Float) -> Float:
        offset = (x - T[:3, 3]) @ T[:3, :3] - centre
        r = np.linalg.norm(offset, axis=-1)
        zeroth, _, first, _ = radial(np.clip(r, RADIUS, HALF), RADIUS, HALF, 0.0)
        fields = np.column_stack([zeroth, first[:, None] * offset / size])
        return np.where((r > HALF)[:, None], 0.0, fields)

    bricks = sample_bricks(
        lanes,
        [0.0] * 3,
        [2 * HALF] * 3,
        root_shape=(1, 1, 1),
        depth=1,
        refine=around(centre + NEAR),
        T_scene_table=T,
    )
    basis = {"ball": BasisProp((HALF, HALF, HALF), float(size))}
    return AffineBases(bricks, replace(META, basis=basis, goals={}))


def sliding_bases() -> AffineBases:
    """Invented basis fields over a sliding plane: even and odd in z, in one brick."""

    def fields(x: Float) -> Float:
        waves = np.sin(9.0 * x[:, :1] + 0.7 * np.arange(4)) * np.cos(7.0 * x[:, 1:2])
        return np.column_stack([waves * np.cos(5.0 * x[:, 2:]), waves * np.sin(8.0 * x[:, 2:])])

    bricks = sample_bricks(
        fields,
        [0.0] * 3,
        [2 * HALF] * 3,
        root_shape=(1, 1, 1),
        depth=0,
        refine=around(NEAR),
        mirror_depth=0.05,
        zero_outside=False,
    )
    basis = {"mug": BasisProp((0.1, 0.2, 0.1), 0.08)}
    meta = replace(META, prop_names=("mug",), basis=basis, goals={}, outlines={})
    return AffineBases(bricks, meta)


def plane() -> PlaneTableWarp:
    """A polygon over a sliding line, turned, to be stored as float16."""
    x_lines = np.linspace(-HALF, HALF, 9)
    y_lines = np.array([0.0, 0.02, 0.05, 0.1, 0.2, 0.3])
    x, y = np.meshgrid(x_lines, y_lines, indexing="ij")
    u = np.stack([0.04 * np.cos(6 * x) * (0.3 - y), 0.3 * np.sin(5 * x) * y * (0.3 - y)], axis=-1)
    corners = np.array([[-0.2, -0.1], [0.2, -0.1], [0.23, 0.2], [0.0, 0.28], [-0.22, 0.15]])
    outer = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    T = np.eye(3)
    T[:2, :2] = turned((0, 0, 1), 0.4)[:2, :2]
    T[:2, 2] = [0.1, -0.05]
    meta = replace(META, outlines={}, outer_box=None, outer_surface=None, goals={})
    meta = replace(meta, T_room_scene=np.eye(3))
    return PlaneTableWarp(PlaneTable(T, x_lines, y_lines, u.astype(np.float32), outer, 0.08), meta)


def write_warps(folder: Path) -> None:
    """Every warp file of the vectors."""
    levels().save(folder / "levels.warp")
    half().save(folder / "half.warp", "float16")
    for name, fields in (("bases", bases()), ("sliding_bases", sliding_bases())):
        write_warp(folder / f"{name}.warp", fields.bricks, fields.meta, "float16")
    plane().save(folder / "plane.warp", "float16")
