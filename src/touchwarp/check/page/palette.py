"""Colours and figures that follow the page's light or dark theme.

Matplotlib knows no CSS variables, so figures are drawn in stand-in colours that no picture uses
otherwise, and the finished SVG has them replaced. The hues are those of Okabe & Ito, which people
with any colour vision can tell apart.
"""

from __future__ import annotations

import io
import re
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.colors import Colormap, LogNorm, Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

INK = "#010203"
MUTED = "#010204"
FAINT = "#010205"
FELT = "#010206"
SEEN = "#010207"
SOLID = "#010208"
FOLD = "#010209"
PASS = "#01020a"
WARN = "#01020b"
FAIL = "#01020c"
UNKNOWN = "#01020d"
ACCENT = "#01020e"
CARD = "#01020f"

_VARIABLES = {
    INK: "--ink",
    MUTED: "--muted",
    FAINT: "--faint",
    FELT: "--felt",
    SEEN: "--seen",
    SOLID: "--solid",
    FOLD: "--fold",
    PASS: "--pass",
    WARN: "--warn",
    FAIL: "--fail",
    UNKNOWN: "--unknown",
    ACCENT: "--accent",
    CARD: "--card",
}

MISMATCH: Colormap = matplotlib.colormaps["viridis"]
ERROR: Colormap = matplotlib.colormaps["plasma"]
GAIN: Colormap = matplotlib.colormaps["PuOr"]

_STYLE: Any = {
    "svg.fonttype": "none",
    "font.family": "sans-serif",
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.labelsize": 9.0,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "text.color": INK,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": MUTED,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "xtick.labelcolor": MUTED,
    "ytick.labelcolor": MUTED,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "lines.linewidth": 1.2,
    "hatch.linewidth": 0.6,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "legend.frameon": False,
    "legend.fontsize": 8.0,
}


class Picture:
    """One figure with one set of axes, drawn in the page's style.

    Args:
        width, height: inches; the page scales the picture to its column.

    Use as a context: `with Picture(4.4, 3) as picture: picture.axes.plot(...)`, then `picture.svg`.
    """

    def __init__(self, width: float, height: float) -> None:
        self._context = matplotlib.rc_context(_STYLE)
        self._size = (width, height)
        self.svg = ""

    def __enter__(self) -> Picture:
        self._context.__enter__()
        self.figure = Figure(figsize=self._size, layout="constrained")
        FigureCanvasSVG(self.figure)
        self.axes: Axes = self.figure.add_subplot()
        return self

    def __exit__(self, *problem: Any) -> None:
        try:
            if problem[0] is None:
                self.svg = _as_svg(self.figure)
        finally:
            self._context.__exit__(*problem)

    def colour_bar(self, colours: Colormap, norm: Normalize, label: str, **more: Any) -> None:
        """A slim bar at the right of the axes."""
        bar = self.figure.colorbar(
            matplotlib.cm.ScalarMappable(norm, colours),
            cax=self.axes.inset_axes((1.025, 0.0, 0.035, 1.0)),
            label=label,
            **more,
        )
        bar.outline.set_visible(False)
        bar.ax.tick_params(length=2)


def _as_svg(figure: Figure) -> str:
    file = io.StringIO()
    # no date, no random ids: the same report gives the same page
    with matplotlib.rc_context({"svg.hashsalt": "touchwarp"}):
        figure.savefig(
            file,
            format="svg",
            transparent=True,
            metadata={"Date": None},
            bbox_inches="tight",
            pad_inches=0.02,
        )
    svg = file.getvalue()
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    width, height = re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', svg).groups()  # type: ignore[union-attr]
    svg = re.sub(r'<svg [^>]*?viewBox="[^"]*"[^>]*>', _opening(width, height), svg, count=1)
    svg = svg.replace("'sans-serif'", "inherit").replace("sans-serif", "inherit")
    for stand_in, variable in _VARIABLES.items():
        svg = svg.replace(stand_in, f"var({variable})")
    return svg


def _opening(width: str, height: str) -> str:
    return (
        f'<svg viewBox="0 0 {width} {height}" xmlns="http://www.w3.org/2000/svg" '
        'xmlns:xlink="http://www.w3.org/1999/xlink" role="img">'
    )


def unique_ids(svg: str, prefix: str) -> str:
    """The SVG with its ids made its own, since many share one page."""
    svg = re.sub(r'id="([^"]+)"', rf'id="{prefix}-\1"', svg)
    svg = re.sub(r'href="#([^"]+)"', rf'href="#{prefix}-\1"', svg)
    return re.sub(r"url\(#([^)]+)\)", rf"url(#{prefix}-\1)", svg)


def css_gradient(colours: Colormap) -> str:
    """A CSS gradient of a colour map, left to right."""
    stops = [matplotlib.colors.to_hex(colours(t)) for t in np.linspace(0.0, 1.0, 9)]
    return f"linear-gradient(to right, {', '.join(stops)})"


def colour_bytes(colours: Colormap) -> NDArray[np.uint8]:
    """(256, 3) the colour map's colours."""
    rgb: NDArray[np.uint8] = (255.0 * colours(np.arange(256))[:, :3] + 0.5).astype(np.uint8)
    return rgb


def error_norm(tolerance: float) -> LogNorm:
    """Contact errors from a hundredth of the tolerance to ten times it, by factors."""
    return LogNorm(0.01 * tolerance, 10.0 * tolerance, clip=True)
