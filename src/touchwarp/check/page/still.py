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
    views = [_view(points, normals, colours, np.radians(turn)) for turn in (-60.0, 120.0)]
    file = io.BytesIO()
    imsave(file, np.concatenate(views, axis=1), format="png")
    return "data:image/png;base64," + base64.b64encode(file.getvalue()).decode("ascii")


def _view(points: Float, normals: Float, colours: Float, turn: float) -> NDArray[np.uint8]:
    """(h, w, 4) seen from the direction `turn` about z, a little from above."""
    rise = np.radians(24.0)
    eye = np.array([np.cos(turn) * np.cos(rise), np.sin(turn) * np.cos(rise), np.sin(rise)])
    right = np.array([-np.sin(turn), np.cos(turn), 0.0])
    up = np.cross(eye, right)
    facing = normals @ eye > 0.0
    points, normals, colours = points[facing], normals[facing], colours[facing]
    x, y, depth = points @ right, points @ up, points @ eye
    span = 1.08 * max(float(np.ptp(x)), float(np.ptp(y)), 1e-9)
    scale = HEIGHT / span
    column = ((x - 0.5 * (x.min() + x.max())) * scale + HEIGHT / 2).astype(int)
    row = ((0.5 * (y.min() + y.max()) - y) * scale + HEIGHT / 2).astype(int)
    shade = 0.55 + 0.45 * np.clip(normals @ _LIGHT, 0.0, 1.0)
    picture = np.zeros((HEIGHT, HEIGHT, 4), np.uint8)
    order = np.argsort(depth)
    rgb = (255.0 * colours * shade[:, None]).astype(np.uint8)[order]
    # dots of two by two pixels, so that samples close ranks
    nearest = np.zeros((HEIGHT, HEIGHT), np.int64)
    for right_by, down_by in ((0, 0), (0, 1), (1, 0), (1, 1)):
        r = np.clip(row[order] + down_by, 0, HEIGHT - 1)
        c = np.clip(column[order] + right_by, 0, HEIGHT - 1)
        np.maximum.at(nearest, (r, c), np.arange(1, len(order) + 1))
    padded = np.pad(nearest, 1)
    beside = np.stack([padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:]])
    gap = (nearest == 0) & ((beside > 0).sum(axis=0) >= 3)
    nearest[gap] = beside.max(axis=0)[gap]
    filled = nearest > 0
    picture[filled, :3] = rgb[nearest[filled] - 1]
    picture[filled, 3] = 255
    return picture
