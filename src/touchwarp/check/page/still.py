"""A still picture of the props' surfaces, made of the contact samples themselves.

Every sample is a dot of its error's colour, the nearest to the eye wins: no renderer is needed, and
what is seen is what was measured.
"""

from __future__ import annotations

import base64
import io

import numpy as np
from matplotlib.image import imsave
from numpy.typing import NDArray

from touchwarp.check.case import Case
from touchwarp.check.page.palette import ERROR, error_norm

Float = NDArray[np.float64]

HEIGHT = 420
_LIGHT = np.array([0.35, -0.5, 0.8]) / np.linalg.norm([0.35, -0.5, 0.8])


def still_picture(case: Case) -> str:
    """A PNG as a data address: the props from the front and from behind, by contact error."""
    points = np.concatenate([p.samples.points for p in case.props])
    normals = np.concatenate([p.body.outward * p.samples.normals for p in case.props])
    error = 1e3 * np.concatenate([case.contact_errors[p.name] for p in case.props])
    colours = ERROR(error_norm(1e3 * case.tolerance)(error))[:, :3]
    views = [view(points, normals, colours, np.radians(turn)) for turn in (-60.0, 120.0)]
    return as_address(np.concatenate(views, axis=1))


def as_address(picture: NDArray[np.uint8]) -> str:
    """A picture (h, w, 4) as the address of a PNG that holds its own data."""
    file = io.BytesIO()
    imsave(file, picture, format="png")
    return "data:image/png;base64," + base64.b64encode(file.getvalue()).decode("ascii")


def view(
    points: Float,
    normals: Float,
    colours: Float,
    turn: float,
    *,
    height: int = HEIGHT,
    around: Float | None = None,
) -> NDArray[np.uint8]:
    """(height, height, 4) dots seen from the direction `turn` about z, a little from above.

    Args:
        points: (n, 3) m.
        normals: (n, 3) outward; what faces away is left out.
        colours: (n, 3), 0 to 1.
        turn: rad.
        height: in pixels.
        around: (k, 3) m, points that the picture is fitted around; the dots where None.
    """
    rise = np.radians(24.0)
    eye = np.array([np.cos(turn) * np.cos(rise), np.sin(turn) * np.cos(rise), np.sin(rise)])
    right = np.array([-np.sin(turn), np.cos(turn), 0.0])
    up = np.cross(eye, right)
    facing = normals @ eye > 0.0
    points, normals, colours = points[facing], normals[facing], colours[facing]
    x, y, depth = points @ right, points @ up, points @ eye
    held = points if around is None else around
    ends = np.array([[(held @ axis).min(), (held @ axis).max()] for axis in (right, up)])
    span = 1.08 * max(float(np.ptp(ends, axis=1).max()), 1e-9)
    across, along = ends.mean(axis=1)
    scale = height / span
    column = ((x - across) * scale + height / 2).astype(int)
    row = ((along - y) * scale + height / 2).astype(int)
    shade = 0.55 + 0.45 * np.clip(normals @ _LIGHT, 0.0, 1.0)
    picture = np.zeros((height, height, 4), np.uint8)
    order = np.argsort(depth)
    rgb = (255.0 * colours * shade[:, None]).astype(np.uint8)[order]
    # dots of two by two pixels, so that samples close ranks
    nearest = np.zeros((height, height), np.int64)
    for right_by, down_by in ((0, 0), (0, 1), (1, 0), (1, 1)):
        r = np.clip(row[order] + down_by, 0, height - 1)
        c = np.clip(column[order] + right_by, 0, height - 1)
        np.maximum.at(nearest, (r, c), np.arange(1, len(order) + 1))
    padded = np.pad(nearest, 1)
    beside = np.stack([padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:]])
    gap = (nearest == 0) & ((beside > 0).sum(axis=0) >= 3)
    nearest[gap] = beside.max(axis=0)[gap]
    filled = nearest > 0
    picture[filled, :3] = rgb[nearest[filled] - 1]
    picture[filled, 3] = 255
    return picture
