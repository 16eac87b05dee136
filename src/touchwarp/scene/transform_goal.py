"""The goal that moves, turns and stretches a prop, as the scene file says it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.scene.goal_numbers import finite
from touchwarp.scene.nearest import suggest
from touchwarp.scene.pose import rotation_matrix
from touchwarp.scene.surface_reader import SurfaceReader
from touchwarp.scene.table import Table

PIVOTS = ("centre", "base")

# Below this ratio of least to greatest stretch, virtual surfaces are taken as flattened.
SINGULAR_RATIO = 1e-6


@dataclass(frozen=True)
class TransformGoal:
    """virtual = pivot + translation + R·S·(x − pivot), x on the posed prop, axes of the scene.

    Attributes:
        pivot: "base" (the posed bounding box's centre in x and y, and its least z; in a plane
            scene its least y), "centre" (of that box), or a point, m.
        scale: one factor, or one per axis.
        rotation_deg: three angles, R = Rz·Ry·Rx; in a plane scene one angle. None: no rotation.
        translation: m. None: none.
        matrix: (d+1, d+1) scene to scene, instead of the four above.
        allow_mirror: accept a map that turns left into right.

    Raises:
        GoalError: on a singular or mirroring map, or numbers of the wrong count.
    """

    kind: ClassVar[str] = "transform"
    keys: ClassVar[tuple[str, ...]] = (
        "pivot",
        "scale",
        "rotation_deg",
        "translation",
        "matrix",
        "allow_mirror",
    )

    pivot: str | Sequence[float] = "base"
    scale: float | Sequence[float] = 1.0
    rotation_deg: float | Sequence[float] | None = None
    translation: Sequence[float] | None = None
    matrix: Sequence[Sequence[float]] | NDArray[np.float64] | None = None
    allow_mirror: bool = False

    def __post_init__(self) -> None:
        if isinstance(self.pivot, str) and self.pivot not in PIVOTS:
            raise GoalError(
                f"goal.pivot is '{self.pivot}'. {suggest(self.pivot, PIVOTS)} A point is also fine."
            )
        for key in ("pivot", "scale", "rotation_deg", "translation"):
            value = getattr(self, key)
            if value is None or isinstance(value, str):
                continue
            numbers = finite(key, value)
            plain = float(numbers) if numbers.ndim == 0 else tuple(numbers.tolist())
            object.__setattr__(self, key, plain)
        if self.matrix is not None:
            given = [k for k in ("scale", "rotation_deg", "translation") if not self._is_default(k)]
            if given or self.pivot != "base":
                raise GoalError(
                    f"goal.matrix stands beside goal.{(given or ['pivot'])[0]}; give either a "
                    "matrix or pivot, scale, rotation_deg and translation."
                )
            rows = finite("matrix", self.matrix)
            if rows.shape not in ((4, 4), (3, 3)):
                raise GoalError(
                    f"goal.matrix has shape {rows.shape}; (4, 4), or (3, 3) in a plane scene, "
                    "is needed."
                )
            if not np.array_equal(rows[-1], np.eye(len(rows))[-1]):
                raise GoalError(
                    f"goal.matrix has the last row {rows[-1].tolist()}; "
                    f"{np.eye(len(rows))[-1].tolist()} is needed: an affine map, points as columns."
                )
            object.__setattr__(self, "matrix", tuple(tuple(row) for row in rows.tolist()))
        self._check_invertible()

    def linear(self, dimension: int) -> NDArray[np.float64]:
        """R·S: (d, d)."""
        if self.matrix is not None:
            rows = np.asarray(self.matrix, dtype=np.float64)
            if len(rows) != dimension + 1:
                raise GoalError(
                    f"goal.matrix has shape {rows.shape}; ({dimension + 1}, {dimension + 1}) is "
                    f"needed in {dimension}-D."
                )
            linear: NDArray[np.float64] = rows[:-1, :-1]
            return linear
        scale = self._of_length("scale", self.scale, dimension, scalar=True)
        R = np.eye(dimension)
        if self.rotation_deg is not None:
            angles = np.asarray(self.rotation_deg)
            needed = "one angle" if dimension == 2 else "three angles"
            if angles.shape != (() if dimension == 2 else (3,)):
                raise GoalError(
                    f"goal.rotation_deg is {self.rotation_deg}; {needed} is needed in "
                    f"{dimension}-D."
                )
            R = rotation_matrix(self.rotation_deg)
        return np.asarray(R * scale)

    def affine(self, bounds: NDArray[np.float64]) -> NDArray[np.float64]:
        """The map as a (d+1, d+1) matrix, scene to scene.

        Args:
            bounds: (2, d) m: the posed prop's bounding box, which decides where the pivot is.
        """
        d = bounds.shape[1]
        linear = self.linear(d)
        if self.matrix is not None:
            return np.array(self.matrix, dtype=np.float64)
        translation = np.zeros(d)
        if self.translation is not None:
            translation = self._of_length("translation", self.translation, d)
        pivot = self.pivot_point(bounds)
        M = np.eye(d + 1)
        M[:d, :d] = linear
        M[:d, d] = pivot - linear @ pivot + translation
        return M

    def pivot_point(self, bounds: NDArray[np.float64]) -> NDArray[np.float64]:
        """The pivot (d,) m for a prop whose bounding box is `bounds` (2, d) m."""
        if not isinstance(self.pivot, str):
            return self._of_length("pivot", self.pivot, bounds.shape[1])
        point: NDArray[np.float64] = bounds.mean(axis=0)
        if self.pivot == "base":
            point[-1] = bounds[0, -1]
        return point

    @classmethod
    def read(cls, table: Table, surfaces: SurfaceReader) -> Self:
        """From the table [prop.goal] of a scene file; keys are checked by the caller."""
        dimension = surfaces.dimension
        values: dict[str, Any] = {}
        if "pivot" in table:
            is_word = isinstance(table.raw("pivot"), str)
            values["pivot"] = table.text("pivot") if is_word else table.vector("pivot", dimension)
        if "scale" in table:
            is_list = isinstance(table.raw("scale"), list)
            values["scale"] = table.vector("scale", dimension) if is_list else table.number("scale")
        if "rotation_deg" in table:
            values["rotation_deg"] = table.rotation("rotation_deg", dimension)
        if "translation" in table:
            values["translation"] = table.vector("translation", dimension)
        if "matrix" in table:
            values["matrix"] = table.rows("matrix", dimension + 1, dimension + 1)
        if "allow_mirror" in table:
            values["allow_mirror"] = table.flag("allow_mirror")
        return cls(**values)

    def entries(self) -> dict[str, Any]:
        """The keys that differ from the defaults."""
        names = ("pivot", "scale", "rotation_deg", "translation", "matrix", "allow_mirror")
        return {k: getattr(self, k) for k in names if not self._is_default(k)}

    def _is_default(self, key: str) -> bool:
        value = getattr(self, key)
        return value is None or value == type(self).__dataclass_fields__[key].default

    def _of_length(
        self, key: str, value: Any, dimension: int, scalar: bool = False
    ) -> NDArray[np.float64]:
        numbers = np.asarray(value, dtype=np.float64)
        if numbers.shape == (dimension,) or (scalar and numbers.ndim == 0):
            return np.broadcast_to(numbers, (dimension,)).copy()
        raise GoalError(f"goal.{key} is {value}; {dimension} numbers are needed.")

    def _check_invertible(self) -> None:
        if self.matrix is not None:
            linear = np.asarray(self.matrix)[:-1, :-1]
        else:
            linear = np.diag(np.atleast_1d(np.asarray(self.scale, dtype=np.float64)))
            if np.ndim(self.scale) == 0:
                linear = np.eye(3) * self.scale
        stretch = np.linalg.svd(linear, compute_uv=False)
        determinant = float(np.linalg.det(linear))
        if stretch[-1] <= SINGULAR_RATIO * stretch[0]:
            raise GoalError(
                f"the goal is singular (determinant {determinant:.3g}): it flattens the prop; "
                "every scale must differ from 0."
            )
        if determinant < 0 and not self.allow_mirror:
            raise GoalError(
                f"the goal mirrors the prop (determinant {determinant:.3g}); make an odd number "
                "of scales positive, or write allow_mirror = true if that is meant."
            )
