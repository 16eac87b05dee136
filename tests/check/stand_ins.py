"""A ball felt as a bigger ball beside it: scene, exact warp, table, and ways to spoil them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tests.exact.sample_bricks import near_sphere, sample_bricks
from tests.exact.spheres import SphereWarp
from touchwarp.check.case import Case, open_case
from touchwarp.goals import Goal, goals, outer_box
from touchwarp.scene import Fixed, Interaction, Outer, Prop, Scene, Surface, TransformGoal
from touchwarp.scene.shapes import box, sphere
from touchwarp.warp.bricks import Bricks
from touchwarp.warp.inverse import find_inverse
from touchwarp.warp.meta import WarpMeta
from touchwarp.warp.posed import PosedWarp
from touchwarp.warp.protocol import Inverse, Warp
from touchwarp.warp.table import TableWarp

Float = NDArray[np.float64]

RADIUS, OUTER = 0.05, 0.2
SHIFT = (0.01, 0.0, 0.0)
BOX = np.array([[-OUTER] * 3, [OUTER] * 3])


def translation(*shift: float) -> Float:
    T = np.eye(4)
    T[:3, 3] = shift
    return T


@cache
def ball(facet_mm: float = 0.2) -> Surface:
    return sphere(RADIUS, facet_mm)


def ball_scene(scale: float = 1.2, shift: Any = SHIFT, mode: str = "slide", **more: Any) -> Scene:
    goal = TransformGoal(pivot="centre", scale=scale, translation=shift)
    more = {"outer": Outer(box=BOX), "interaction": Interaction(mode)} | more
    return Scene(props=[Prop("ball", ball(), goal)], **more)


def ball_warp(scale: float = 1.2, shift: Any = SHIFT, screening: float = 0.0) -> SphereWarp:
    """Exact on the inscribed facets too, as the closed form goes on inside the sphere."""
    return SphereWarp(
        radius=RADIUS,
        outer_radius=OUTER,
        shift=np.asarray(shift, float),
        stretch=(scale - 1.0) * np.eye(3),
        screening=screening,
    )


@cache
def ball_bricks(depth: int = 2) -> Bricks:
    return sample_bricks(
        ball_warp().displacement, *BOX, depth=depth, refine=near_sphere(0.0, RADIUS)
    )


def ball_table(scene: Scene, bricks: Bricks | None = None, **more: Any) -> TableWarp:
    goal = goals(scene)["ball"]
    assert goal.matrix is not None
    told = {
        "scene_text": scene.text,
        "mesh_digests": scene.digests,
        "outer_box": BOX,
        "prop_names": ("ball",),
        "goals": {"ball": goal.matrix},
        "estimated_error_max_mm": 0.05,
    }
    return TableWarp(bricks or ball_bricks(), WarpMeta(**(told | more)))


def block_scene(
    size: Any = (0.06, 0.04, 0.1), goal: TransformGoal | None = None, **more: Any
) -> Scene:
    """A block standing on a table."""
    surface = box(size).transformed(translation(0, 0, size[2] / 2))
    table = Fixed("table", plane=([0, 0, 0], [0, 0, 1]))
    return Scene(props=[Prop("block", surface, goal or TransformGoal())], fixed=[table], **more)


def map_scene(goal: Goal, mode: str = "slide") -> Scene:
    """One prop, the "ball", with a goal given as arrays."""
    prop = Prop("ball", Surface(goal.prop_points, goal.faces), goal)
    return Scene(props=[prop], outer=Outer(box=BOX), interaction=Interaction(mode))


def case_of(scene: Scene, warp: Warp, samples: int = 20_000) -> Case:
    own = goals(scene)
    meta = getattr(warp, "meta", None)
    return open_case(scene, warp, own, outer_box(scene, own), meta, samples=samples, seed=0)


class Spoiled:
    """A warp with something added to u.

    Args:
        warp: what is spoiled.
        added: (n, d) m to (n, d) m.
    """

    def __init__(self, warp: Warp, added: Callable[[Float], Float]) -> None:
        self._warp, self._added = warp, added
        self.dimension = warp.dimension

    def displacement(self, x: ArrayLike) -> Float:
        points = np.asarray(x, float)
        flat = np.broadcast_to(
            self._added(points.reshape(-1, self.dimension)),
            (points.size // self.dimension, self.dimension),
        )
        return self._warp.displacement(points) + flat.reshape(points.shape)

    def __call__(self, x: ArrayLike) -> Float:
        return np.asarray(x, float) + self.displacement(x)

    def jacobian(self, x: ArrayLike) -> Float:
        points, step = np.asarray(x, float), 1e-6
        slopes = np.empty((*points.shape, self.dimension))
        for axis in range(self.dimension):
            by = step * np.eye(self.dimension)[axis]
            slopes[..., axis] = (self(points + by) - self(points - by)) / (2 * step)
        return slopes

    def inverse(self, x: ArrayLike) -> Inverse:
        return find_inverse(self, x)

    def at(self, T_room_scene: ArrayLike) -> PosedWarp:
        return PosedWarp(self, T_room_scene)


class Still(Spoiled):
    """The warp that displaces nothing."""

    def __init__(self, dimension: int = 3) -> None:
        self.dimension = dimension

    def displacement(self, x: ArrayLike) -> Float:
        return 0.0 * np.asarray(x, float)


def shifted(warp: Warp, millimetres: float) -> Spoiled:
    """u is off by as much everywhere."""
    return Spoiled(warp, lambda x: np.full_like(x, 1e-3 * millimetres / np.sqrt(x.shape[1])))


def with_values(bricks: Bricks, change: Callable[[Float], Any]) -> Bricks:
    """A copy whose values have been changed in place by `change`."""
    values = bricks.values.copy()
    change(values)
    return replace(bricks, values=values)
