"""Basis fields in closed form: those of a sphere, and invented ones over a sliding plane."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from tests.exact.sample_bricks import near_sphere, sample_bricks
from tests.exact.spheres import SphereWarp, radial
from tests.warp.tables import BOX, META, turned
from touchwarp.warp.bases import AffineBases
from touchwarp.warp.bricks import Bricks
from touchwarp.warp.meta import BasisProp

RADIUS, OUTER = 0.05, 0.2
CENTRE = np.array([0.012, -0.007, 0.02])
SIZE = np.sqrt(3.0) * RADIUS


def lanes(offset: np.ndarray) -> np.ndarray:
    """(n, 4) the basis fields of a sphere at places from its centre."""
    r = np.linalg.norm(offset, axis=-1)
    between = np.clip(r, RADIUS, OUTER)
    zeroth, _, first, _ = radial(between, RADIUS, OUTER, 0.0)
    fields = np.column_stack([zeroth, first[:, None] * offset / SIZE])
    return np.where((r > OUTER)[:, None], 0.0, fields)


def sphere_of(T_scene_table: np.ndarray, goal: np.ndarray) -> SphereWarp:
    """The exact warp of an affine goal, scene frame."""
    centre = T_scene_table[:3, :3] @ (CENTRE - BOX[0]) + T_scene_table[:3, 3]
    stretch = goal[:3, :3] - np.eye(3)
    return SphereWarp(RADIUS, OUTER, centre, stretch @ centre + goal[:3, 3], stretch)


def table_frame(plain: bool = False) -> np.ndarray:
    T = np.eye(4) if plain else turned()
    T[:3, 3] += T[:3, :3] @ BOX[0]
    return T


@cache
def sphere_bases(depth: int = 2) -> AffineBases:
    """Bases of one sphere in a turned table frame; there they have any orientation."""
    T = table_frame()
    bricks = sample_bricks(
        lambda x: lanes((x - T[:3, 3]) @ T[:3, :3] + BOX[0] - CENTRE),
        *BOX,
        depth=depth,
        refine=near_sphere(CENTRE, RADIUS),
        T_scene_table=T,
    )
    meta = replace(
        META, basis={"ball": BasisProp(tuple((CENTRE - BOX[0]).tolist()), SIZE)}, goals={}
    )
    return AffineBases(bricks, meta)


def same_grid(bases: AffineBases, goal: np.ndarray) -> Bricks:
    """The closed form's table on the bricks of the bases."""
    T = bases.bricks.T_scene_table
    return sample_bricks(
        sphere_of(T, goal).displacement,
        *BOX,
        depth=2,
        refine=near_sphere(CENTRE, RADIUS),
        T_scene_table=T,
    )


@cache
def sliding_bases() -> AffineBases:
    """Two props over a sliding plane; fields without any equation, but even and odd in z."""

    def fields(x: np.ndarray) -> np.ndarray:
        phase = np.arange(8) * 0.7
        waves = np.sin(9.0 * x[:, :1] + phase) * np.cos(7.0 * x[:, 1:2] - phase)
        even = waves * np.cos(5.0 * x[:, 2:])
        odd = waves * np.sin(8.0 * x[:, 2:])
        return np.column_stack([even, odd])

    bricks = sample_bricks(
        fields,
        [0.0, 0.0, 0.0],
        [0.4, 0.4, 0.4],
        depth=1,
        refine=near_sphere([0.2, 0.2, 0.1], 0.05),
        mirror_depth=0.05,
        zero_outside=False,
    )
    meta = replace(
        META,
        prop_names=("mug", "cup"),
        basis={"mug": BasisProp((0.1, 0.2, 0.1), 0.08), "cup": BasisProp((0.3, 0.2, 0.05), 0.04)},
        goals={},
        outlines={},
    )
    return AffineBases(bricks, meta)
