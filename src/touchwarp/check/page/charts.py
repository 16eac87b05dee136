"""Histograms, reach curves and the error budget."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.ticker import FuncFormatter, NullFormatter
from numpy.typing import NDArray

from touchwarp.check.budget import CAUSES
from touchwarp.check.case import Case, PropCase
from touchwarp.check.page.palette import (
    ACCENT,
    CARD,
    FAIL,
    FAINT,
    INK,
    MUTED,
    SEEN,
    SOLID,
    WARN,
    Picture,
)
from touchwarp.check.reaches import STOP_SHORT
from touchwarp.check.thresholds import (
    PINCH_CURVATURE,
    PINCH_WIDTH,
    REACH_DIRECTION,
    REACH_GAIN,
)

Float = NDArray[np.float64]

WIDTH, HEIGHT = 4.5, 2.7


def draw_contact_histogram(case: Case, prop: PropCase, shown: dict[str, Any]) -> str:
    """Contact error over the surface and on sharp edges, with the tolerance.

    What lies on a fixed plane, or may not meet its goal beside a fixed surface, has a colour of its
    own and no part in the percentile.
    """
    error = 1e3 * case.contact_errors[prop.name]
    kept = shown["kept"]
    edges = 1e3 * shown["edge_error"]
    tolerance = 1e3 * case.tolerance
    low = 1e-3 * tolerance
    high = max(20.0 * tolerance, 2.0 * float(error.max()) if np.isfinite(error.max()) else 0.0)
    bins = np.geomspace(low, high, 70)
    with Picture(WIDTH, HEIGHT) as picture:
        axes = picture.axes
        styles: tuple[tuple[Float, str, dict[str, Any]], ...] = (
            (
                error[kept],
                "surface",
                {"color": SEEN, "histtype": "stepfilled", "alpha": 0.55},
            ),
            (
                error[~kept],
                "on or held by what is fixed",
                {"color": MUTED, "histtype": "stepfilled", "alpha": 0.55},
            ),
            (edges, "sharp edges", {"color": WARN, "histtype": "step", "lw": 1.5}),
        )
        for values, name, style in styles:
            if len(values):
                whole = len(edges) if values is edges else len(error)
                share = np.full(len(values), 100.0 / whole)
                axes.hist(
                    np.clip(values, low, high), bins.tolist(), weights=share, label=name, **style
                )
        axes.set_xscale("log")
        _limit(picture, tolerance, "tolerance")
        p99 = float(np.quantile(error[kept], 0.99)) if kept.any() else 0.0
        if low < p99 < high:
            axes.axvline(p99, color=INK, lw=0.9, ls=":")
            axes.annotate(
                "99 %",
                (p99, 0.62),
                xycoords=("data", "axes fraction"),
                xytext=(3, 0),
                textcoords="offset points",
                color=MUTED,
                fontsize=8,
            )
        axes.set(xlim=(low, high), xlabel="contact error |f − g|, mm", ylabel="share, %")
        axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.legend(loc="upper left")
    return picture.svg


def draw_gain_histogram(shown: dict[str, Any]) -> str:
    """Volume of Ω by its greatest and least gain."""
    with Picture(WIDTH, HEIGHT) as picture:
        axes = picture.axes
        top = 3.0
        bins = np.linspace(0.0, top, 91).tolist()
        weights = 100.0 * shown["volume"]
        for key, name, colour in (("low", "least", WARN), ("high", "greatest", SEEN)):
            axes.hist(
                np.clip(shown[key], 0.0, top),
                bins,
                weights=weights,
                histtype="stepfilled",
                alpha=0.5,
                color=colour,
                label=f"{name} gain",
            )
        axes.axvline(1.0, color=INK, lw=0.8)
        # most of Ω hardly moves; a logarithmic share keeps the rest in sight
        axes.set_yscale("log")
        axes.set(xlim=(0.0, top), ylim=(1e-3, 200.0), xlabel="gain, ×", ylabel="share of Ω, %")
        axes.yaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
        axes.legend(loc="upper right")
    return picture.svg


def draw_reach_scatter(shown: dict[str, Any]) -> str:
    """Each whole reach by its gain and its turn, with the detection thresholds."""
    assert isinstance(REACH_GAIN.limit, tuple)
    assert isinstance(REACH_DIRECTION.limit, float)
    low, high = (limit or 0.0 for limit in REACH_GAIN.limit)
    steepest = REACH_DIRECTION.limit
    ratio, turn = shown["ratio"], shown["turn"]
    noticed = (ratio < low) | (ratio > high) | (turn > steepest)
    with Picture(WIDTH, HEIGHT) as picture:
        axes = picture.axes
        axes.fill_between([low, high], 0.0, steepest, color=SOLID, lw=0)
        for some, colour, name in (
            (~noticed, SEEN, "within both"),
            (noticed, FAIL, "beyond one"),
        ):
            if some.any():
                axes.scatter(
                    ratio[some],
                    turn[some],
                    s=7,
                    color=colour,
                    alpha=0.6,
                    lw=0,
                    label=f"{name}: {100 * some.mean():.0f} %",
                )
        left, right = min(0.85, ratio.min() - 0.02), max(1.1, ratio.max() + 0.02)
        top = max(6.0, 1.08 * float(turn.max()))
        axes.plot(
            [low, low, high, high], [0, steepest, steepest, 0], color=INK, lw=0.9, ls=(0, (4, 3))
        )
        axes.set(xlim=(left, right), ylim=(0.0, top))
        axes.set(xlabel="gain of the whole reach, ×", ylabel="turn of the whole reach, °")
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, handletextpad=0.2)
    return picture.svg


def draw_speed(shown: dict[str, Any]) -> str:
    """Speed ratio along the reaches, against the distance still to go."""
    speed = shown["speed"]
    length = np.linalg.norm(shown["ends"] - shown["starts"], axis=1)
    # on a common axis of millimetres before contact
    steps = speed.shape[1]
    far = float(np.quantile(length, 0.05))
    to_go = np.linspace(STOP_SHORT, far, 240)
    along = 1.0 - to_go[None, :] / length[:, None]
    index = np.clip((along * steps).astype(int), 0, steps - 1)
    at = np.take_along_axis(speed, index, axis=1)
    bands = np.quantile(at, [0.05, 0.25, 0.5, 0.75, 0.95], axis=0)
    mm = 1e3 * to_go
    with Picture(WIDTH, HEIGHT) as picture:
        axes = picture.axes
        axes.fill_between(mm, bands[0], bands[4], color=SEEN, alpha=0.2, lw=0, label="90 %")
        axes.fill_between(mm, bands[1], bands[3], color=SEEN, alpha=0.35, lw=0, label="50 %")
        axes.plot(mm, bands[2], color=SEEN, label="median")
        axes.axhline(1.0, color=INK, lw=0.8)
        axes.set(
            xlim=(mm[-1], 0.0),
            xlabel="real distance before contact, mm",
            ylabel="displayed / real speed, ×",
        )
        axes.legend(loc="upper left", ncols=3)
    return picture.svg


def draw_budget(shown: dict[str, Any], tolerance: float) -> str:
    """The gap at real contact by cause: a bar to the 95th percentile, a tick at the median."""
    gaps = shown["gaps"]
    rows = [(CAUSES[cause], gaps[cause], SEEN) for cause in CAUSES]
    rows[-1] = (rows[-1][0], rows[-1][1], ACCENT)
    rows.append((f"all, with {shown['other'].replace('_', ' ')}", shown["compared"], FAINT))
    with Picture(WIDTH, HEIGHT) as picture:
        axes = picture.axes
        floor = 1e-3
        for place, (_, values, colour) in enumerate(rows):
            median, p95 = (1e3 * float(np.quantile(values, q)) for q in (0.5, 0.95))
            axes.barh(place, max(p95, floor), left=0.0, height=0.62, color=colour, alpha=0.75)
            axes.plot([max(median, floor)] * 2, [place - 0.31, place + 0.31], color=INK, lw=1.6)
            axes.annotate(
                f"{median:.2g} · {p95:.2g}",
                (max(p95, floor), place),
                xytext=(4, 0),
                textcoords="offset points",
                va="center",
                color=MUTED,
                fontsize=8,
                bbox={"facecolor": CARD, "edgecolor": "none", "pad": 1.0},
            )
        axes.set_xscale("log")
        axes.set_xlim(floor, 60.0 * max(1e3 * float(np.quantile(r[1], 0.95)) for r in rows))
        axes.set_yticks(range(len(rows)), [name for name, _, _ in rows])
        axes.invert_yaxis()
        axes.tick_params(axis="y", length=0)
        axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.set_xlabel("gap, mm: median · 95th percentile")
        _limit(picture, 1e3 * tolerance, "")
    return picture.svg


def draw_changes(shown: dict[str, Any]) -> str:
    """How much wider or narrower pinches, and how much sharper or flatter patches become."""
    with Picture(WIDTH, HEIGHT) as picture:
        axes = picture.axes
        bins = np.linspace(-100.0, 200.0, 76).tolist()
        for key, name, colour, threshold in (
            ("pinch", "pinch width", SEEN, PINCH_WIDTH),
            ("curvature", "curvature", WARN, PINCH_CURVATURE),
        ):
            values = 100.0 * shown[key]
            if len(values) == 0:
                continue
            share = np.full(len(values), 100.0 / len(values))
            axes.hist(
                np.clip(values, -100.0, 200.0),
                bins,
                weights=share,
                histtype="stepfilled",
                alpha=0.5,
                color=colour,
                label=f"{name} (±{threshold.limit:.3g} %)",
            )
            assert isinstance(threshold.limit, float)
            for end in (-threshold.limit, threshold.limit):
                axes.axvline(end, color=colour, lw=1.0, ls=(0, (4, 3)))
        axes.axvline(0.0, color=INK, lw=0.8)
        axes.set(xlim=(-100.0, 200.0), xlabel="change from felt to seen, %", ylabel="share, %")
        axes.legend(loc="upper right")
    return picture.svg


def _limit(picture: Picture, value: float, name: str) -> None:
    picture.axes.axvline(value, color=FAIL, lw=1.0, ls=(0, (4, 3)), zorder=0.5)
    if name:
        picture.axes.annotate(
            name,
            (value, 0.97),
            xycoords=("data", "axes fraction"),
            xytext=(-3, 0),
            textcoords="offset points",
            ha="right",
            va="top",
            color=FAIL,
            fontsize=8,
        )
