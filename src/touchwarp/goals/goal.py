"""The retargeting goal g: for every point of a prop's surface, where it must appear (eq. 1)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.scene.surface import Surface


@dataclass(frozen=True, eq=False)
class Goal:
    """g on one prop, piecewise linear on triangles (on segments in a plane scene).

    Attributes:
        prop_points: (n, d) m, scene frame: points of the prop's surface.
        virtual_points: (n, d) m, scene frame: row i is the image of row i of `prop_points`.
        faces: (m, d) int64: rows of indices into both.
        kind: the goal's name in the scene file, such as "transform".
        report: what the maker of the goal measured, by name; empty for a transform.
        matrix: (d+1, d+1) scene to scene where g is affine, else None.
        virtual_surface: the virtual object's own surface where it has one, which the images of
            the prop's points should lie on and cover; None where the image is all there is.
        landmarks: (k, 2, d) m, scene frame: points of the prop, each with the point of the virtual
            surface that it should go to; None where there are none.
    """

    prop_points: NDArray[np.float64]
    virtual_points: NDArray[np.float64]
    faces: NDArray[np.int64]
    kind: str = "arrays"
    report: dict[str, Any] = field(default_factory=dict)
    matrix: NDArray[np.float64] | None = None
    virtual_surface: Surface | None = None
    landmarks: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        prop_points = np.ascontiguousarray(self.prop_points, dtype=np.float64)
        virtual_points = np.ascontiguousarray(self.virtual_points, dtype=np.float64)
        faces = np.ascontiguousarray(self.faces, dtype=np.int64)
        if prop_points.ndim != 2 or prop_points.shape[1] not in (2, 3):
            raise GoalError(
                f"A goal's prop points have shape {prop_points.shape}; (n, 3) or (n, 2) is needed."
            )
        if virtual_points.shape != prop_points.shape:
            raise GoalError(
                f"A goal has {prop_points.shape} prop points but {virtual_points.shape} virtual "
                "points; row i of one is the image of row i of the other, so shapes must agree."
            )
        if faces.ndim != 2 or faces.shape[1] != prop_points.shape[1] or len(faces) == 0:
            raise GoalError(
                f"A goal's faces have shape {faces.shape}; (m, {prop_points.shape[1]}), m ≥ 1, "
                "is needed."
            )
        if not (np.isfinite(prop_points).all() and np.isfinite(virtual_points).all()):
            raise GoalError("A goal has NaN or infinite points; finite coordinates are needed.")
        if faces.min() < 0 or faces.max() >= len(prop_points):
            raise GoalError(
                f"A goal's faces refer to points {faces.min()} to {faces.max()}, but there are "
                f"{len(prop_points)} points."
            )
        dimension = prop_points.shape[1]
        if self.virtual_surface is not None and self.virtual_surface.dimension != dimension:
            raise GoalError(
                f"A goal's virtual surface is {self.virtual_surface.dimension}-D, but its points "
                f"are {dimension}-D; both must be of the scene's dimension."
            )
        if self.landmarks is not None:
            pairs = np.ascontiguousarray(self.landmarks, dtype=np.float64)
            if pairs.ndim != 3 or pairs.shape[1:] != (2, dimension) or not np.isfinite(pairs).all():
                raise GoalError(
                    f"A goal's landmarks have shape {pairs.shape}; finite (k, 2, {dimension}) is "
                    "needed: a point of the prop and one of the virtual surface in each row."
                )
            pairs.setflags(write=False)
            object.__setattr__(self, "landmarks", pairs)
        for name, value in (
            ("prop_points", prop_points),
            ("virtual_points", virtual_points),
            ("faces", faces),
        ):
            value.setflags(write=False)
            object.__setattr__(self, name, value)

    @property
    def image(self) -> Surface:
        """The prop's faces where g shows them: m, scene frame."""
        return Surface(self.virtual_points, self.faces)

    @property
    def shown(self) -> Surface:
        """What is seen, m, scene frame: the virtual object itself, or else the prop's image."""
        return self.virtual_surface or self.image

    @property
    def displacement(self) -> NDArray[np.float64]:
        """(n, d) m, scene axes: u = g − x at the prop points."""
        return self.virtual_points - self.prop_points
