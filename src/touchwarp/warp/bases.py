"""Instant goals: the warp of any affine goal as a sum of basis fields solved once (eq. 1, 2).

An affine goal x ↦ A x + t displaces a prop's surface by u = d + s B ξ, with ξ = (x − c) / s the
place from the prop's centre c over half its diagonal s, B = A − I and d = B c + t, all in the table
frame. Each component of u is linear in 1, ξ0, ξ1, ξ2, so the warp is the sum over props p and
j = 0…3 of scalar basis fields (boundary data 1 or ξ_{j-1} on p, 0 on all other props and on ∂Ω1)
times coefficients: u_k(x) = Σ_p Σ_j basis_{p,j}(x) coefficient_{p,j,k}. So is the error.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Literal

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from touchwarp.errors import GoalError
from touchwarp.solve.threads import pool, threads
from touchwarp.warp.bricks import Bricks
from touchwarp.warp.lookup import Lookup, frame_of
from touchwarp.warp.meta import Outline, WarpMeta
from touchwarp.warp.posed import rigid
from touchwarp.warp.protocol import Inverse
from touchwarp.warp.quantise import Conformer
from touchwarp.warp.table import TableWarp

Float = NDArray[np.float64]

LANES = 4
"""Basis fields of one prop: the boundary data 1 and three coordinates."""


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def _combine(values, mix, out):
    """out = values · mixᵀ, (n, C) float32 times (3, C), in float64 whatever values are."""
    for n in range(len(values)):
        a = b = c = 0.0
        for m in range(mix.shape[1]):
            v = np.float64(values[n, m])
            a += v * mix[0, m]
            b += v * mix[1, m]
            c += v * mix[2, m]
        out[n, 0], out[n, 1], out[n, 2] = a, b, c


def combined_error(lost: Float, meta: WarpMeta) -> float:
    """A bound, in m, on what errors of the basis fields add to u for goals in the stated range.

    Args:
        lost: (..., C) error of each channel.
        meta: of the bases.
    """
    props = [meta.basis[name] for name in meta.prop_names]
    lanes = np.abs(lost).reshape(-1, lost.shape[-1] // (LANES * len(props)), len(props), LANES)
    stretch = meta.range_stretch * np.array([prop.half_diagonal for prop in props])
    each = meta.range_shift * lanes[..., 0] + stretch * np.linalg.norm(lanes[..., 1:], axis=-1)
    # The two sets of a sliding plane act on components at right angles.
    return float(np.linalg.norm(each.sum(axis=-1), axis=-1).max(initial=0.0))


class AffineBases:
    """Basis fields of a scene, from which the warp of any affine goals follows with no solve.

    Args:
        bricks: the basis fields as channels: lanes 4p … 4p + 3 are those of prop p of
            `meta.prop_names`, boundary data 1, ξ0, ξ1, ξ2. With a sliding plane there are twice as
            many: first all props' lanes with no normal derivative on the plane, for the tangential
            components, then all props' lanes that vanish on it, for the normal one.
        meta: what the file says of itself; `meta.basis` scales the boundary data.

    Raises:
        ValueError: the channels are not as many as the props ask for.
    """

    def __init__(self, bricks: Bricks, meta: WarpMeta) -> None:
        channels = bricks.values.shape[-1]
        sets = 1 if bricks.mirror_depth is None else 2
        if set(meta.basis) != set(meta.prop_names) or not meta.prop_names:
            raise ValueError(
                f"Bases of the props {list(meta.prop_names)} have scalings for "
                f"{list(meta.basis)}; one for each prop is needed."
            )
        if channels != sets * LANES * len(meta.prop_names):
            raise ValueError(
                f"Bases of {len(meta.prop_names)} props have {channels} channels; "
                f"{sets * LANES} a prop are needed."
            )
        self._bricks = bricks
        self._meta = replace(meta, kind="bases")
        self._lookup = Lookup.of(bricks, np.zeros((channels, 3)))

    @property
    def bricks(self) -> Bricks:
        """The basis fields."""
        return self._bricks

    @property
    def meta(self) -> WarpMeta:
        """What the bases say of themselves."""
        return self._meta

    @property
    def prop_names(self) -> tuple[str, ...]:
        """The props that goals may be given for."""
        return self._meta.prop_names

    def warp(self, goals: Mapping[str, ArrayLike]) -> AffineWarp:
        """The warp of affine goals, summed at each lookup: ready at once.

        Args:
            goals: (4, 4) scene to scene by prop; a prop not named stays where it is.

        Raises:
            GoalError: an unknown prop, or no finite affine matrix.
        """
        matrices = self._checked(goals)
        return AffineWarp(self, self._mix(matrices), matrices)

    def table(self, goals: Mapping[str, ArrayLike]) -> TableWarp:
        """The same warp as a table of its own: quicker to look up, can be saved.

        Raises:
            GoalError: as for `warp`.
        """
        matrices = self._checked(goals)
        bricks = self._bricks
        values = np.empty((*bricks.values.shape[:-1], 3))
        source = self._lookup.values.reshape(-1, bricks.values.shape[-1])
        mix = np.ascontiguousarray(self._mix(matrices).T)
        flat = values.reshape(-1, 3)
        bounds = np.linspace(0, len(flat), threads() + 1).astype(int)
        tasks = [pool().submit(_combine, source[a:b], mix, flat[a:b]) for a, b in pairwise(bounds)]
        for task in tasks:
            task.result()
        # the basis fields are 0 on the border already, and so are their sums
        rounded, _ = self._conformer.round(values, zero_outside=False)
        return TableWarp(replace(bricks, values=rounded), self._meta_of(matrices))

    def error_bound_mm(self, goals: Mapping[str, ArrayLike]) -> float | None:
        """The estimated error of a combination, grown in proportion outside the stated range.

        Raises:
            GoalError: as for `warp`.
        """
        estimate = self._meta.estimated_error_max_mm
        if estimate is None:
            return None
        return estimate * max(1.0, self._excess(self._checked(goals)))

    def save(self, path: str | Path, dtype: Literal["float32", "float16"] = "float32") -> None:
        """Write the bases as a warp file; see docs/warp-file.md.

        Args:
            dtype: "float16" halves the file; what that costs is told in `meta` on loading.

        Raises:
            OutputError: the file cannot be written; nothing is left behind.
            ValueError: dtype is another.
        """
        from touchwarp.warp.file import write_warp

        write_warp(path, self._bricks, self._meta, dtype)

    @cached_property
    def _conformer(self) -> Conformer:
        b = self._bricks
        return Conformer(b.root, b.child, b.slot, b.mirror_depth is not None)

    def _checked(self, goals: Mapping[str, ArrayLike]) -> dict[str, Float]:
        matrices = {}
        for name, goal in goals.items():
            if name not in self.prop_names:
                raise GoalError(
                    f"There is no prop '{name}' in these bases; they have "
                    f"{', '.join(repr(n) for n in self.prop_names)}."
                )
            matrix = np.array(goal, dtype=np.float64)
            if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
                raise GoalError(
                    f"The goal of '{name}' has shape {matrix.shape}"
                    f"{'' if np.isfinite(matrix).all() else ' and is not finite'}; "
                    "a finite (4, 4) matrix from scene to scene is needed."
                )
            if not np.allclose(matrix[3], [0.0, 0.0, 0.0, 1.0], rtol=0.0, atol=1e-9):
                raise GoalError(
                    f"The goal of '{name}' has the last row {matrix[3].tolist()}; an affine one, "
                    "[0, 0, 0, 1], is needed: other goals take a solve of their own."
                )
            matrices[name] = matrix
        return matrices

    def _linear(self, name: str, matrix: Float) -> tuple[Float, Float]:
        """d (3,) m and B (3, 3) of the module's formula."""
        T = self._bricks.T_scene_table
        rotation, origin = T[:3, :3], T[:3, 3]
        stretch = matrix[:3, :3] - np.eye(3)
        B = rotation.T @ stretch @ rotation
        shift = rotation.T @ (stretch @ origin + matrix[:3, 3])
        return B @ np.asarray(self._meta.basis[name].centre) + shift, B

    def _mix(self, matrices: Mapping[str, Float]) -> Float:
        """(C, 3) the coefficients of every channel."""
        props = len(self.prop_names)
        mix = np.zeros((self._bricks.values.shape[-1], 3))
        for p, name in enumerate(self.prop_names):
            if name in matrices:
                d, B = self._linear(name, matrices[name])
                lanes = slice(LANES * p, LANES * (p + 1))
                mix[lanes] = np.vstack([d, B.T * self._meta.basis[name].half_diagonal])
        if self._bricks.mirror_depth is not None:
            half = LANES * props
            mix[half:, 2] = mix[:half, 2]
            mix[:half, 2] = 0.0
        return mix

    def _excess(self, matrices: Mapping[str, Float]) -> float:
        """How far goals go beyond the stated range, as a factor; up to 1 inside it."""
        excess = 0.0
        for name, matrix in matrices.items():
            d, B = self._linear(name, matrix)
            shift = float(np.linalg.norm(d)) / self._meta.range_shift
            stretch = float(np.linalg.norm(B, ord=2)) / self._meta.range_stretch
            excess = max(excess, shift, stretch)
        return excess

    def _meta_of(self, matrices: Mapping[str, Float]) -> WarpMeta:
        """The meta of the warp of these goals, prop by prop."""
        goals = {name: matrices.get(name, np.eye(4)) for name in self.prop_names}
        outlines = {
            name: Outline(outline.prop, outline.prop.transformed(goals[name]))
            for name, outline in self._meta.outlines.items()
        }
        estimate = self._meta.estimated_error_max_mm
        rms = self._meta.estimated_error_rms_mm
        scale = max(1.0, self._excess(matrices))
        return replace(
            self._meta,
            kind="warp",
            goals=goals,
            outlines=outlines,
            basis={},
            estimated_error_max_mm=None if estimate is None else estimate * scale,
            estimated_error_rms_mm=None if rms is None else rms * scale,
        )


class AffineWarp:
    """A warp of affine goals, summed from basis fields at each lookup; see `AffineBases.warp`.

    It fulfils the `Warp` protocol.

    Attributes:
        error_bound_mm: the estimated error, grown in proportion outside the bases' stated range;
            None where the bases have no estimate.
        within_range: whether the goals lie in the stated range.
    """

    dimension = 3

    def __init__(self, bases: AffineBases, mix: Float, goals: dict[str, Float]) -> None:
        self._bases = bases
        self._goals = goals
        self._lookup = replace(bases._lookup, mix=mix)
        self._T = np.eye(4)
        self._tables: list[TableWarp] = []
        excess = bases._excess(goals)
        estimate = bases.meta.estimated_error_max_mm
        self.within_range = excess <= 1.0
        self.error_bound_mm = None if estimate is None else estimate * max(1.0, excess)

    @property
    def goals(self) -> dict[str, Float]:
        """(4, 4) scene to scene by prop, as given."""
        return {name: matrix.copy() for name, matrix in self._goals.items()}

    @property
    def max_displacement(self) -> float:
        """The greatest |u| of the combined table, in m."""
        return self.table().max_displacement

    def __call__(self, x: ArrayLike) -> Float:
        """Displayed positions f(x): (..., 3) m for x (..., 3) m."""
        return self._lookup.displacement(x, displayed=True)

    def displacement(self, x: ArrayLike) -> Float:
        """u(x): (..., 3) m for x (..., 3) m."""
        return self._lookup.displacement(x)

    def jacobian(self, x: ArrayLike) -> Float:
        """∂f/∂x: (..., 3, 3) for x (..., 3) m; one-sided on faces of cells, as for `TableWarp`."""
        return self._lookup.jacobian(x)

    def inverse(self, x: ArrayLike) -> Inverse:
        """As `TableWarp.inverse`, on the combined table, which the first call makes."""
        return self.table().inverse(x)

    def table(self) -> TableWarp:
        """The combined table, made at the first call and kept."""
        if not self._tables:
            self._tables.append(self._bases.table(self._goals))
        return self._tables[0].at(self._T)

    def at(self, T_room_scene: ArrayLike) -> AffineWarp:
        """The warp carried rigidly along; basis fields are shared.

        Raises:
            ValueError: T is not rigid.
        """
        moved = AffineWarp.__new__(AffineWarp)
        moved.__dict__.update(self.__dict__)
        moved._T = rigid(T_room_scene, "T_room_scene") @ self._T
        bricks = self._bases.bricks
        placed = replace(bricks, T_scene_table=moved._T @ bricks.T_scene_table)
        moved._lookup = replace(self._lookup, frame=frame_of(placed))
        return moved
