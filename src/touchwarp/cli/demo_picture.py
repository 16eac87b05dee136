"""The demo's picture: the same hand as it is and as it is displayed, and space between the two."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from touchwarp.outputs import replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from touchwarp import Scene, TableWarp

Float = NDArray[np.float64]

REAL, SEEN, HAND, LATTICE, INK = "#8c9199", "#0072b2", "#d55e00", "#c9ced6", "#30343b"

LOW, HIGH = np.array([-0.13, -0.01]), np.array([0.13, 0.13])
"""The picture's corners in the plane y = 0: (x, z) m."""

SPACING = 0.005
"""Between lattice lines, m."""

# Fingers from knuckle to tip in the plane y = 0, (x, z) m: one on the mug's wall, one on its lip,
# one flat on the table.
FINGERS = (
    ((-0.112, 0.104), (-0.085, 0.112), (-0.058, 0.092), (-0.0405, 0.062)),
    ((0.108, 0.119), (0.080, 0.128), (0.056, 0.118), (0.0380, 0.0952)),
    ((-0.122, 0.030), (-0.105, 0.022), (-0.085, 0.008), (-0.062, 0.0005)),
)


def draw(scene: Scene, warp: TableWarp, path: Path) -> None:
    """Write a PNG of two cuts at y = 0: what is real, and what is displayed.

    Args:
        scene: of one prop, the mug.
        warp: of that scene.
        path: the PNG file.

    Raises:
        OutputError: it cannot be written.
    """
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    import touchwarp as tw

    (goal,) = tw.goals(scene).values()
    with matplotlib.rc_context({"font.family": "sans-serif", "font.size": 10.0}):
        figure = Figure(figsize=(9.6, 2.95), dpi=110, layout="constrained")
        FigureCanvasAgg(figure)
        left, right = figure.subplots(1, 2)
        _panel(left, goal.prop_points[goal.faces], None, REAL)
        left.set_title("What is there: a mug, a hand", loc="left", color=INK)
        _panel(right, goal.virtual_points[goal.faces], warp, SEEN)
        _outline(right, goal.prop_points[goal.faces], REAL, 0.9)
        right.set_title("What is seen: a tea cup, the hand displaced", loc="left", color=INK)
        with replacing(path) as temporary:
            figure.savefig(temporary, format="png")


def _panel(axes: Axes, corners: Float, warp: TableWarp | None, colour: str) -> None:
    """One object, the lattice of space, and the fingers; all displaced where there is a warp."""
    _lattice(axes, warp)
    axes.axhspan(1e3 * LOW[1], 0.0, color="#e9e4dc", zorder=2)
    axes.axhline(0.0, color="#b8ab97", lw=1.2, zorder=2)
    _outline(axes, corners, colour, 2.4)
    for finger in FINGERS:
        joints = _shown(np.array(finger), warp)
        axes.plot(
            *_mm(_shown(_smooth(np.array(finger)), warp)),
            color=HAND,
            lw=9,
            alpha=0.25,
            solid_capstyle="round",
            zorder=5,
        )
        axes.plot(*_mm(joints), "o", color=HAND, ms=4, zorder=6)
        axes.plot(*_mm(joints[-1:]), "o", color=HAND, ms=8, mec="white", mew=1.2, zorder=7)
    axes.set(xlim=1e3 * np.array([LOW[0], HIGH[0]]), ylim=1e3 * np.array([LOW[1], HIGH[1]]))
    axes.set_aspect("equal")
    axes.set_axis_off()


def _lattice(axes: Axes, warp: TableWarp | None) -> None:
    """Lines of space; those inside the mug's wall are drawn too, so that none ends abruptly."""
    from matplotlib.collections import LineCollection

    reach = 0.03
    x = np.arange(LOW[0] - reach, HIGH[0] + reach, SPACING)
    z = np.arange(0.0, HIGH[1] + 2 * reach, SPACING)
    fine_x = np.linspace(x[0], x[-1], 600)
    fine_z = np.linspace(z[0], z[-1], 400)
    lines = [np.stack([np.full_like(fine_z, value), fine_z], axis=1) for value in x]
    lines += [np.stack([fine_x, np.full_like(fine_x, value)], axis=1) for value in z]
    shown = [1e3 * _shown(line, warp) for line in lines]
    axes.add_collection(LineCollection(shown, colors=LATTICE, linewidths=0.6, zorder=1))


def _outline(axes: Axes, corners: Float, colour: str, width: float) -> None:
    from matplotlib.collections import LineCollection

    from touchwarp.check.page.slices import cut_triangles

    # just beside y = 0, where a mesh may have vertices
    segments = 1e3 * cut_triangles(corners, 1, 1e-5)[:, :, [0, 2]]
    axes.add_collection(
        LineCollection(list(segments), colors=colour, linewidths=width, capstyle="round", zorder=4)
    )


def _shown(flat: Float, warp: TableWarp | None) -> Float:
    """Points (n, 2) of the plane y = 0, displaced where there is a warp, seen along y."""
    if warp is None:
        return flat
    return warp(np.stack([flat[:, 0], np.zeros(len(flat)), flat[:, 1]], axis=1))[:, [0, 2]]


def _smooth(finger: Float) -> Float:
    """The finger as a curve through its joints, (60, 2) m."""
    from scipy.interpolate import PchipInterpolator

    along = np.arange(len(finger))
    return np.asarray(PchipInterpolator(along, finger)(np.linspace(0, along[-1], 60)))


def _mm(points: Float) -> Float:
    """Coordinates (2, n) mm of points (n, 2) m, as axes take them."""
    return np.asarray(1e3 * points.T)
