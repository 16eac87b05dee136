"""The tables that the tests of this folder share, from closed forms."""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from tests.exact.sample_bricks import near_sphere, sample_bricks
from tests.exact.sources import PointSources
from tests.exact.spheres import SphereWarp
from touchwarp.scene.surface import Surface
from touchwarp.warp.bricks import CELLS, Bricks
from touchwarp.warp.meta import Outline, WarpMeta
from touchwarp.warp.table import TableWarp

SPHERE = SphereWarp(
    radius=0.05,
    outer_radius=0.2,
    shift=np.array([0.01, 0.004, -0.006]),
    stretch=np.array([[0.2, 0.1, 0.0], [0.0, -0.1, 0.05], [0.1, 0.0, 0.3]]),
    screening=100.0,
)
BOX = np.array([[-0.2, -0.2, -0.2], [0.2, 0.2, 0.2]])


def turned(axis=(0.3, -0.5, 0.8), angle=0.7, shift=(0.3, -0.2, 0.1)):
    """A rigid (4, 4) matrix."""
    a = np.asarray(axis) / np.linalg.norm(axis)
    K = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    T = np.eye(4)
    T[:3, :3] += np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
    T[:3, 3] = shift
    return T


@cache
def sphere_bricks(depth: int = 2, **options) -> Bricks:
    return sample_bricks(
        SPHERE.displacement, *BOX, depth=depth, refine=near_sphere(0.0, 0.05), **options
    )


@cache
def turned_bricks() -> Bricks:
    """Oblong cells in a turned frame."""
    T = turned()
    # the field is made in the table's own frame, then carried along
    carried = SPHERE.at(T)
    T_table = T.copy()
    T_table[:3, 3] += T[:3, :3] @ BOX[0]
    return sample_bricks(
        carried.displacement,
        *BOX,
        root_shape=(3, 2, 2),
        depth=2,
        refine=near_sphere(0.0, 0.05),
        T_scene_table=T_table,
    )


MIRROR_DEPTH = 0.06
SOURCES = PointSources(
    np.array([[0.02, -0.01, 0.03]]), np.array([[8e-4, -4e-4, 6e-4]]), mirrored=True
)


@cache
def sliding_bricks() -> Bricks:
    """A field over a sliding plane z = 0."""
    return sample_bricks(
        SOURCES.displacement,
        [-0.2, -0.2, 0.0],
        [0.2, 0.2, 0.4],
        refine=near_sphere([0.02, -0.01, 0.03], 0.03),
        depth=3,
        mirror_depth=MIRROR_DEPTH,
        zero_outside=False,
    )


@cache
def fold_bricks(depth: int = 3) -> Bricks:
    """A sphere shown twice as big: f folds around it."""
    return sample_bricks(
        FOLDING.displacement, *BOX, depth=depth, refine=near_sphere(0.0, 0.05, reach=1.5)
    )


FOLDING = SphereWarp(stretch=np.eye(3))

META = WarpMeta(
    scene_text='# Größe 1.2 ×\n[[prop]]\nname = "ball"\n',
    mesh_digests={"ball": "ab" * 32},
    outlines={
        "ball": Outline(
            Surface(np.eye(3), np.array([[0, 1, 2]])), Surface(2 * np.eye(3), np.array([[0, 1, 2]]))
        )
    },
    outer_box=BOX,
    outer_surface=Surface(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]]), np.array([[0, 1, 2]])),
    screening=100.0,
    tolerance_mm=0.2,
    edge_radius_mm=3.0,
    estimated_error_max_mm=0.05,
    estimated_error_rms_mm=0.01,
    prop_names=("ball",),
    goals={"ball": np.diag([1.2, 1.0, 1.0, 1.0])},
    notes={"cycles": 3},
)


def sphere_table(depth: int = 2) -> TableWarp:
    return TableWarp(sphere_bricks(depth), META)


def environment() -> dict[str, str]:
    """The environment in which another process finds these tests."""
    checkout = str(Path(__file__).resolve().parents[2])
    return os.environ | {"PYTHONPATH": os.pathsep.join([checkout, *sys.path])}


def points_in(bricks: Bricks, count: int, seed: int = 0, margin: float = 0.1) -> np.ndarray:
    """Points of the scene in and around the root grid (and under it)."""
    size = np.array(bricks.root.shape) * CELLS * bricks.spacing
    local = np.random.default_rng(seed).uniform(-margin * size, (1 + margin) * size, (count, 3))
    T = bricks.T_scene_table
    return local @ T[:3, :3].T + T[:3, 3]


def with_values(bricks: Bricks, values) -> Bricks:
    return replace(bricks, values=np.ascontiguousarray(values, dtype=bricks.values.dtype))
