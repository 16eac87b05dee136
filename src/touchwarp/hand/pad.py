"""Where a person's finger pad is: calibrated from touches of a prop whose surface is known."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from touchwarp.hand.contact import NearestSurface
from touchwarp.hand.skeleton import TIP_RADIUS

Float = NDArray[np.float64]

SPREAD = 3e-3
"""m: by how much pads differ from finger to finger, as known beforehand."""

NOISE = 1e-3
"""m: tracking noise of a touch; touches farther off count less (Huber's weights, 2 of these)."""

_ROUNDS = 20


class Pad(NamedTuple):
    """A calibrated finger pad.

    Attributes:
        offset: (3,) m from the fingertip's centre to the pad, in the tip's frame.
        residual: m, root mean square of the touches' distances from the surface.
    """

    offset: Float
    residual: float


def calibrate_pad(poses: ArrayLike, surface: NearestSurface, radius: float = TIP_RADIUS) -> Pad:
    """The point of the fingertip's frame that lay on the surface at each touch.

    What touches do not tell, as the way along a plane that was always touched alike, stays as in a
    finger whose pad is `radius` out of the palm's side.

    Args:
        poses: (n, 4, 4) T_room_tip, one of each touch with the pad.
        surface: the prop's.
        radius: m, of the fingertip.

    Raises:
        ValueError: there are no touches, or poses have another shape or are not finite.
    """
    touches = np.asarray(poses, dtype=np.float64)
    if touches.ndim != 3 or touches.shape[1:] != (4, 4) or len(touches) == 0:
        raise ValueError(f"The touches have shape {touches.shape}; (n, 4, 4), n > 0, is needed.")
    if not np.isfinite(touches).all():
        raise ValueError("A touch has NaN or infinite entries; leave out lost ones.")
    rotations, centres = touches[:, :3, :3], touches[:, :3, 3]
    usual = np.array([0.0, -radius, 0.0])
    offset = usual.copy()
    for _ in range(_ROUNDS):
        slopes, away = _distances(rotations, centres, offset, surface)
        weights = np.minimum(1.0, 2.0 * NOISE / np.maximum(np.abs(away), 1e-12)) / NOISE**2
        normal = (slopes * weights[:, None]).T @ slopes + np.eye(3) / SPREAD**2
        pull = slopes.T @ (weights * away) + (offset - usual) / SPREAD**2
        offset = offset - np.linalg.solve(normal, pull)
    _, away = _distances(rotations, centres, offset, surface)
    return Pad(offset, float(np.sqrt((away**2).mean())))


def _distances(
    rotations: Float, centres: Float, offset: Float, surface: NearestSurface
) -> tuple[Float, Float]:
    """How the pads' distances from the surface change with the offset (n, 3), and these (n,) m."""
    points = rotations @ offset + centres
    nearest, normals = surface(points)
    return np.einsum("nji,nj->ni", rotations, normals), ((points - nearest) * normals).sum(axis=1)
