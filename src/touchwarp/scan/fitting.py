"""Least squares of a shape's distances to measured points, from many starts; its ends can be held.

Lengths here are in units of the points' extent, about their middle.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.scan.poses import even_rotations

Float = NDArray[np.float64]

# (half sizes of a shape, points (n, 3) in its own frame) → signed distances (n,)
Distance = Callable[[Float, Float], Float]

EVEN = 24
"""Rotations to start from, beside principal axes: a box has local minima in many."""
SHORT, LONG = 10, 200
"""Evaluations of the residual and its slopes: at every start, and at the best few."""
REFINED = 5
HOLD = 1e3
"""How much more a held end weighs than a point."""
SMALLEST, LARGEST = np.log(1e-4), np.log(20.0)


@dataclass(frozen=True)
class Kind:
    """A family of shapes.

    Attributes:
        distance: to its surface.
        sizes: for each axis of its frame, which half size reaches along it.
        flat: the axes that end in flat faces.
        freedoms: numbers that say such a shape, pose included.
    """

    distance: Distance
    sizes: tuple[int, int, int]
    flat: tuple[int, ...]
    freedoms: int


@dataclass(frozen=True, eq=False)
class Fit:
    """A shape near the points.

    Attributes:
        frame: (3, 3) its axes, as columns.
        centre: (3,) its middle.
        half: its half sizes.
        cost: sum of the squared distances.
    """

    frame: Float
    centre: Float
    half: Float
    cost: float


@dataclass(frozen=True, eq=False)
class End:
    """Where a shape ends along one of its axes.

    Attributes:
        direction: (3,) unit, outward.
        axis: of the shape's frame.
        place: along the direction.
    """

    direction: Float
    axis: int
    place: float


class Fitting:
    """Shapes of one kind, fitted to points (n, 3)."""

    def __init__(self, kind: Kind, points: Float) -> None:
        self.kind = kind
        self.points = points

    def best(self) -> Fit:
        """The nearest shape."""
        axes = np.linalg.eigh(np.cov(self.points.T))[1]
        starts = [axes[:, np.roll([0, 1, 2], k)] for k in range(3)] + [np.eye(3)]
        starts += list(even_rotations(EVEN))
        short = [self.solve(self._around(start), steps=SHORT) for start in starts]
        few = sorted(short, key=lambda fit: fit.cost)[:REFINED]
        return min((self.solve(fit) for fit in few), key=lambda fit: fit.cost)

    def solve(self, start: Fit, held: Sequence[End] = (), steps: int = LONG) -> Fit:
        """Levenberg–Marquardt from a start, with some ends kept where they are told."""
        from scipy.optimize import least_squares
        from scipy.spatial.transform import Rotation

        def fit_of(x: Float) -> Fit:
            frame = Rotation.from_rotvec(x[3:6]).as_matrix() @ start.frame
            half = np.exp(np.clip(x[6:], SMALLEST, LARGEST))
            return Fit(frame, x[:3], half, 0.0)

        def residuals(x: Float) -> Float:
            fit = fit_of(x)
            off = [HOLD * (self.place(fit, end.direction, end.axis) - end.place) for end in held]
            return np.concatenate([self.distances(fit), off])

        x = np.concatenate([start.centre, np.zeros(3), np.log(start.half)])
        found = fit_of(least_squares(residuals, x, x_scale="jac", max_nfev=steps).x)
        cost = float((self.distances(found) ** 2).sum())
        return Fit(found.frame, found.centre, found.half, cost)

    def distances(self, fit: Fit) -> Float:
        """(n,) signed, of the points from the shape."""
        own = (self.points - fit.centre) @ fit.frame
        return np.asarray(self.kind.distance(fit.half, own))

    def ends(self, fit: Fit) -> list[End]:
        """Its six ends, two for each axis."""
        directions = [(sign * fit.frame[:, axis], axis) for axis in range(3) for sign in (1, -1)]
        return [End(d, axis, self.place(fit, d, axis)) for d, axis in directions]

    def place(self, fit: Fit, direction: Float, axis: int) -> float:
        """How far a shape reaches along a direction, that of one of its axes or near it."""
        return float(direction @ fit.centre + fit.half[self.kind.sizes[axis]])

    def moved(self, fit: Fit, end: End, by: float) -> Fit:
        """With one end elsewhere, and the other where it was if the kind has two sizes for them."""
        size = self.kind.sizes[end.axis]
        half = fit.half.copy()
        if self.kind.sizes.count(size) > 1:
            return Fit(fit.frame, fit.centre + by * end.direction, half, np.inf)
        half[size] = max(half[size] + by / 2, np.exp(SMALLEST))
        return Fit(fit.frame, fit.centre + by / 2 * end.direction, half, np.inf)

    def _around(self, frame: Float) -> Fit:
        """The shape about as large as the points spread along the axes of a frame."""
        frame = frame * np.array(
            [1.0, 1.0, np.sign(np.linalg.det(frame))]
        )  # eigenvectors' may be −1
        own = self.points @ frame
        low, high = own.min(axis=0), own.max(axis=0)
        reach = np.maximum(0.5 * (high - low), np.exp(SMALLEST))
        sizes = np.array(self.kind.sizes)
        half = np.array([reach[sizes == k].mean() for k in range(sizes.max() + 1)])
        return Fit(frame, frame @ (0.5 * (low + high)), half, np.inf)
