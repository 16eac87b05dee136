"""Pictures of a cut: displacement arrows, the warped lattice, mismatch, gain and folds."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize, TwoSlopeNorm
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from touchwarp.check.case import Case
from touchwarp.check.page.palette import (
    CARD,
    FAINT,
    FELT,
    FOLD,
    GAIN,
    MISMATCH,
    MUTED,
    SEEN,
    SOLID,
    Picture,
)
from touchwarp.check.page.slices import AXES, Slice

Float = NDArray[np.float64]

WIDTH = 4.5
ARROWS = 30
LATTICE = 40
"""Lines along the longer side."""

SEEN_ON_COLOUR: dict[str, Any] = {
    "color": "#ffffff",
    "linewidth": 1.4,
    "linestyle": (0.0, (3.4, 2.2)),
    "path_effects": [withStroke(linewidth=2.8, foreground="#1d2126")],
}
"""Blue would drown in the mismatch's colours, and the prop is white in the dark: dark-edged white
dashes stand out from all of them, in either theme."""

_FEWEST_MM = 0.4
"""Shorter arrows are left out."""

_GAIN_SPAN = 1.0
"""The gain's colours reach from 2⁻¹ to 2¹."""


def draw_arrows(case: Case, cut: Slice) -> str:
    """Prop, virtual object, and arrows from real to displayed places, true to scale."""
    with _picture(cut) as picture:
        axes = picture.axes
        stride = max(1, max(cut.in_region.shape) // ARROWS)
        take = (slice(stride // 2, None, stride), slice(stride // 2, None, stride))
        inside = cut.in_region[take]
        starts = 1e3 * cut.points[take][..., list(cut.axes)][inside]
        ends = 1e3 * cut.displayed[take][..., list(cut.axes)][inside]
        step = ends - starts
        long = np.linalg.norm(step, axis=1) > _FEWEST_MM
        axes.plot(*starts[~long].T, ".", ms=1.2, color=FAINT)
        axes.quiver(
            *starts[long].T,
            *step[long].T,
            angles="xy",
            scale_units="xy",
            scale=1.0,
            width=0.0032,
            headwidth=4.2,
            headlength=4.6,
            headaxislength=4.0,
            color=SEEN,
            alpha=0.75,
        )
        _objects(axes, cut)
        _frame(axes, cut)
        _legend(
            axes,
            Line2D([], [], color=FELT, lw=1.8, label="prop, felt"),
            Line2D([], [], color=SEEN, lw=1.6, label="virtual object, seen"),
            Line2D(
                [], [], color=SEEN, lw=1.0, alpha=0.75, marker=">", ms=3, label="real → displayed"
            ),
        )
    return picture.svg


def draw_lattice(case: Case, cut: Slice) -> str:
    """A square lattice of real places, drawn where it is displayed (Figure 4 of the paper)."""
    with _picture(cut) as picture:
        axes = picture.axes
        pitch = float((cut.high - cut.low).max()) / LATTICE
        for number in range(2):
            other = 1 - number
            lines = np.arange(cut.low[number] + pitch / 2, cut.high[number], pitch)
            along = np.linspace(cut.low[other], cut.high[other], 6 * LATTICE)
            flat = np.empty((len(lines), len(along), 2))
            flat[..., number], flat[..., other] = lines[:, None], along
            real = cut.place(flat.reshape(-1, 2))
            shown = 1e3 * case.warp(real)[:, list(cut.axes)]
            shown[~case.region.contains(real)] = np.nan
            shown = shown.reshape(flat.shape)
            pieces = np.stack([shown[:, :-1], shown[:, 1:]], axis=2).reshape(-1, 2, 2)
            pieces = pieces[np.isfinite(pieces).all(axis=(1, 2))]
            axes.add_collection(LineCollection(_joined(pieces), colors=MUTED, linewidths=0.55))
        _objects(axes, cut)
        _folds(axes, cut)
        _frame(axes, cut)
        _legend(
            axes,
            Line2D([], [], color=MUTED, lw=0.8, label="square lattice, as displayed"),
            Line2D([], [], color=FELT, lw=1.8, label="prop, felt"),
            Line2D([], [], color=SEEN, lw=1.6, label="virtual object, seen"),
        )
    return picture.svg


def draw_mismatch(case: Case, cut: Slice) -> str:
    """|u| over the cut."""
    size = 1e3 * np.linalg.norm(cut.displayed - cut.points, axis=-1)
    norm = Normalize(0.0, max(1e-3, 1e3 * case.boundary_maximum))
    with _picture(cut) as picture:
        _image(picture.axes, cut, MISMATCH(norm(size)))
        _contours(picture.axes, cut, size, norm)
        _objects(picture.axes, cut, fill=False, seen=SEEN_ON_COLOUR)
        _frame(picture.axes, cut)
        picture.colour_bar(MISMATCH, norm, "mismatch |u|, mm")
        _legend(
            picture.axes,
            Line2D([], [], color=FELT, lw=1.8, label="prop, felt"),
            Line2D([], [], **SEEN_ON_COLOUR, label="virtual object, seen"),
        )
    return picture.svg


def draw_gain(case: Case, cut: Slice, slowest: bool) -> str:
    """The greatest or least gain over the cut, with folds marked."""
    gain = np.log2(np.maximum(cut.gain_low if slowest else cut.gain_high, 1e-6))
    norm = TwoSlopeNorm(0.0, -_GAIN_SPAN, _GAIN_SPAN)
    with _picture(cut) as picture:
        _image(picture.axes, cut, GAIN(norm(np.clip(gain, -_GAIN_SPAN, _GAIN_SPAN))))
        _folds(picture.axes, cut)
        _objects(picture.axes, cut, fill=False)
        _frame(picture.axes, cut)
        picture.colour_bar(
            GAIN,
            norm,
            f"gain, {'slowest' if slowest else 'quickest'} direction, ×",
            ticks=[-1, -0.5, 0, 0.5, 1],
            format=lambda value, _: f"{2**value:.2g}",
        )
        _legend(
            picture.axes,
            Patch(facecolor=FOLD, alpha=0.9, label="folded, det ∂f < 0"),
            Line2D([], [], color=FELT, lw=1.8, label="prop, felt"),
            Line2D([], [], color=SEEN, lw=1.6, label="virtual object, seen"),
        )
    return picture.svg


def _picture(cut: Slice) -> Picture:
    shape = (cut.high - cut.low)[1] / (cut.high - cut.low)[0]
    return Picture(WIDTH, float(np.clip(0.62 + WIDTH * shape, 2.4, 6.5)))


def _image(axes: Axes, cut: Slice, colours: Float) -> None:
    colours = colours.copy()
    colours[~cut.in_region, 3] = 0.0
    axes.imshow(
        (255 * colours + 0.5).astype(np.uint8),
        origin="lower",
        extent=cut.extent_mm,
        interpolation="nearest",
        aspect="equal",
    )


def _contours(axes: Axes, cut: Slice, size: Float, norm: Normalize) -> None:
    masked = np.ma.array(size, mask=~cut.in_region)
    levels = np.linspace(0.0, float(norm.vmax or 1.0), 9)[1:-1]
    first, second = (1e3 * cut.points[..., a] for a in cut.axes)
    axes.contour(first, second, masked, levels, colors="#ffffff", linewidths=0.5, alpha=0.55)


def _objects(axes: Axes, cut: Slice, fill: bool = True, seen: dict[str, Any] | None = None) -> None:
    if fill:
        axes.contourf(
            *(1e3 * cut.points[..., a] for a in cut.axes),
            (~cut.in_region).astype(float),
            levels=[0.5, 1.5],
            colors=[SOLID],
        )
    plain = {"color": SEEN, "linewidth": 1.6}
    for segments, style in (
        (cut.seen, seen or plain),
        (cut.felt, {"color": FELT, "linewidth": 1.8}),
    ):
        lines = _joined(1e3 * segments)
        if not fill and "path_effects" not in style:
            # a rim in the card's colour, so that the outline stands out from any other
            rim = style | {"color": CARD, "linewidth": style["linewidth"] + 1.6}
            axes.add_collection(LineCollection(lines, **rim, capstyle="round"))
        cap = "butt" if "linestyle" in style else "round"
        axes.add_collection(LineCollection(lines, **style, capstyle=cap))
    if cut.ground is not None:
        left, right, bottom, _ = cut.extent_mm
        height = 1e3 * cut.ground
        axes.axhline(height, color=FELT, lw=1.2)
        if height > bottom:
            axes.add_patch(
                Rectangle(
                    (left, bottom),
                    right - left,
                    height - bottom,
                    facecolor="none",
                    edgecolor=FAINT,
                    hatch="////",
                    lw=0,
                )
            )


def _folds(axes: Axes, cut: Slice) -> None:
    folded = cut.in_region & ~(cut.determinant >= 0.0)
    if not folded.any():
        return
    axes.contourf(
        *(1e3 * cut.points[..., a] for a in cut.axes),
        folded.astype(float),
        levels=[0.5, 1.5],
        colors=[FOLD],
        alpha=0.9,
    )


def _frame(axes: Axes, cut: Slice) -> None:
    left, right, bottom, top = cut.extent_mm
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
    axes.set_xlabel(f"{AXES[cut.axes[0]]}, mm")
    axes.set_ylabel(f"{AXES[cut.axes[1]]}, mm")
    axes.tick_params(length=2.5)


def _legend(axes: Axes, *entries: Line2D | Patch) -> None:
    axes.legend(
        handles=list(entries),
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        ncols=len(entries),
        handlelength=1.4,
        columnspacing=1.2,
        borderaxespad=0.2,
    )


def _joined(segments: Float) -> list[Float]:
    """Segments chained into polylines where they follow one another: smaller files, round joins."""
    if len(segments) == 0:
        return []
    start = np.round(segments[:, 0], 6)
    end = np.round(segments[:, 1], 6)
    by_end: dict[tuple[float, float], list[int]] = {}
    for n in range(len(segments)):
        for point in (start[n], end[n]):
            by_end.setdefault((float(point[0]), float(point[1])), []).append(n)
    used = np.zeros(len(segments), bool)
    lines = []
    for first in range(len(segments)):
        if used[first]:
            continue
        used[first] = True
        line = [segments[first, 0], segments[first, 1]]
        for grow_front in (False, True):
            while True:
                tip = np.round(line[0] if grow_front else line[-1], 6)
                key = (float(tip[0]), float(tip[1]))
                onward = next((n for n in by_end.get(key, ()) if not used[n]), None)
                if onward is None:
                    break
                used[onward] = True
                here, there = segments[onward]
                ahead = there if np.array_equal(np.round(here, 6), tip) else here
                if grow_front:
                    line.insert(0, ahead)
                else:
                    line.append(ahead)
        lines.append(np.array(line))
    return lines
