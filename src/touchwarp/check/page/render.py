"""From a report to its page."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from importlib.resources import files
from typing import Any

from jinja2 import Environment, StrictUndefined

from touchwarp.check.case import Case
from touchwarp.check.page import charts, slice_figures
from touchwarp.check.page.map_view import between_picture, square_side
from touchwarp.check.page.palette import error_norm, unique_ids
from touchwarp.check.page.slices import Slice, cut
from touchwarp.check.page.still import still_picture
from touchwarp.check.page.surface_view import view_data
from touchwarp.check.report import Check, Report, join_unit, number_text
from touchwarp.check.summary import GROUPS, headline, sentences
from touchwarp.check.terminal import mark_of
from touchwarp.check.thresholds import THRESHOLDS, limit_of

SIGNS = {"pass": "✓", "warn": "!", "fail": "✗", "unknown": "?", "told": "·"}

MOST_PROPS_CUT = 3
"""Cuts are drawn through this many props at most, the largest."""

_TILES = (
    ("contact.p99", "contact error, 99th percentile"),
    ("virtual.p99", "distance to the virtual surface, 99th percentile"),
    ("budget.gap", "gap a person meets, 95th percentile"),
    ("offset.contact", "greatest offset in contact"),
    ("reach.gain_low", "gain of whole reaches, 5th percentile"),
    ("reach.gain_high", "gain of whole reaches, 95th percentile"),
    ("map.curvature", "change of curvature by the goal, mean"),
    ("folds.reach", "how far folds reach from the prop"),
)


_GAIN = (
    "The {} singular value of ∂f: how much {} than the real hand the displayed one moves at most. "
    "Purple is quicker, orange slower."
)
_CUT_PICTURES: tuple[tuple[str, Callable[[Case, Slice], str], str], ...] = (
    (
        "where a real point is displayed",
        slice_figures.draw_arrows,
        "Each arrow starts at a real place and ends where it is displayed, true to scale within "
        "the cut.",
    ),
    (
        "space as it is displayed",
        slice_figures.draw_lattice,
        "A square lattice of real places. It meets the virtual outline where it meets the prop; "
        "where it doubles back, space is folded.",
    ),
    (
        "mismatch",
        slice_figures.draw_mismatch,
        "How far the displayed hand is from the real one. White lines are an eighth of the "
        "greatest mismatch apart.",
    ),
    (
        "gain, quickest direction",
        partial(slice_figures.draw_gain, slowest=False),
        _GAIN.format("greatest", "quicker"),
    ),
    (
        "gain, slowest direction",
        partial(slice_figures.draw_gain, slowest=True),
        _GAIN.format("least", "slower"),
    ),
)
"""What is drawn of each cut: its words, how, and what it shows."""


@dataclass(frozen=True)
class PageFigure:
    """One picture with its words."""

    title: str
    svg: str
    caption: str


def render(report: Report) -> str:
    """The page as HTML.

    Raises:
        ValueError: the report was made without its case, so there is nothing to draw.
    """
    case = report.case
    if case is None:
        raise ValueError(
            "This report holds no samples to draw; save the page of the report that check returned."
        )
    solid = case.dimension == 3
    surface = view_data(case) if solid else None
    norm = error_norm(1e3 * case.tolerance)
    here = files("touchwarp.check.page")
    words = {name: (here / name).read_text("utf-8") for name in ("style.css", "viewer.js")}
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    numbered = _Numbering()
    return environment.from_string((here / "report.html").read_text("utf-8")).render(
        name=", ".join(p.name for p in case.props),
        facts=report.facts,
        status=report.status,
        signs=SIGNS,
        headline=headline(report),
        sentences=sentences(report),
        tiles=list(_tiles(report)),
        cuts=[numbered.all(block) for block in _cuts(case)],
        surface=None if surface is None else _for_script(surface),
        fields=[] if surface is None else surface["fields"],
        maps=bool(case.maps),
        map_fields=[] if surface is None else surface["map_fields"],
        bare=surface is not None and bool(surface["virtual"]),
        between=between_picture(case) if case.maps else "",
        square=join_unit(number_text(1e3 * square_side(case)), "mm"),
        still=still_picture(case) if solid else "",
        still_low=join_unit(number_text(float(norm.vmin or 0.0)), "mm"),
        still_high=join_unit(number_text(float(norm.vmax or 0.0)), "mm"),
        samples=_grouped(report.facts["surface_samples"]),
        domain=_grouped(report.facts["domain_samples"]),
        charts=numbered.all({"figures": list(_charts(report, case))})["figures"],
        groups=list(_groups(report)),
        thresholds=[
            {
                "quantity": t.quantity,
                "limit": limit_of(t),
                "kind": t.kind,
                "condition": t.condition,
                "source": t.source,
                "judged": report.facts["mode"] in t.modes,
            }
            for t in THRESHOLDS
        ],
        json=json.dumps(report.as_dict(), indent=1, ensure_ascii=False),
        style=words["style.css"],
        viewer=words["viewer.js"],
    )


class _Numbering:
    """Gives every picture's ids a prefix of its own."""

    def __init__(self) -> None:
        self._count = 0

    def all(self, block: dict[str, Any]) -> dict[str, Any]:
        figures = []
        for figure in block["figures"]:
            self._count += 1
            svg = unique_ids(figure.svg, f"p{self._count}")
            figures.append(PageFigure(figure.title, svg, figure.caption))
        return {**block, "figures": figures}


def _tiles(report: Report) -> Iterator[dict[str, str]]:
    for name, words in _TILES:
        if any(c.name == name for c in report.checks):
            check = report.of(name)
            mark = mark_of(check)
            note = {"told": "told, no limit", "unknown": "no known limit"}.get(mark, "")
            yield {
                "name": words,
                "value": check.value_text,
                "limit": check.limit_text,
                "mark": mark,
                "note": note,
            }


def _cuts(case: Case) -> Iterator[dict[str, Any]]:
    largest = sorted(case.props, key=lambda p: -p.area)[:MOST_PROPS_CUT]
    for prop in [p for p in case.props if p in largest]:
        cuts = cut(case, prop)
        figures = [
            PageFigure(f"{one.title}: {words}", draw(case, one), caption)
            for words, draw, caption in _CUT_PICTURES
            for one in cuts
        ]
        title = "Through space" if len(case.props) == 1 else f"Through space, at {prop.name}"
        yield {
            "title": title,
            "lead": "The prop is what is felt, the virtual object what is seen. Around them, real "
            "places and where they are displayed.",
            "figures": figures,
        }


def _charts(report: Report, case: Case) -> Iterator[PageFigure]:
    several = len(case.props) > 1
    for prop in case.props:
        of = f", {prop.name}" if several else ""
        yield PageFigure(
            f"Contact error{of}",
            charts.draw_contact_histogram(case, prop, report.shown["contact"][prop.name]),
            "Share of the surface, and of the sharp edges' length, by contact error. The dashed "
            "line is the tolerance, the dotted one the 99th percentile.",
        )
    tracking = str(report.facts["tracking"]).replace("_", " ")
    yield PageFigure(
        "What a person meets at real contact",
        charts.draw_budget(report.shown["budget"], case.tolerance),
        f"The gap between displayed skin and virtual surface by cause, with {tracking} tracking: "
        "bars end at the 95th percentile, ticks are medians, the dashed line is the tolerance.",
    )
    if report.shown["reaches"]:
        yield PageFigure(
            "Whole reaches",
            charts.draw_reach_scatter(report.shown["reaches"]),
            "Each dot is a straight reach from a ring of starts to the surface. Inside the dashed "
            "box neither gain nor direction was detected (Zenner & Krüger 2019).",
        )
        yield PageFigure(
            "Speed along the reaches",
            charts.draw_speed(report.shown["reaches"]),
            "Displayed over real speed while the hand comes near. No threshold is known for a part "
            "of a reach.",
        )
    for prop in case.props:
        changes = report.shown["perception"].get(prop.name)
        if changes is not None and len(changes["pinch"]) + len(changes["curvature"]):
            yield PageFigure(
                f"What a pinch feels and sees{f', {prop.name}' if several else ''}",
                charts.draw_changes(changes),
                "Change of the width between opposite points, and of curvature over patches of a "
                "fingertip's size. Dashed lines are the thresholds of de Tinguy et al. 2019.",
            )
    yield PageFigure(
        "Gain in Ω",
        charts.draw_gain_histogram(report.shown["gain"]),
        "Volume of Ω by the greatest and the least singular value of ∂f there.",
    )


def _groups(report: Report) -> Iterator[dict[str, Any]]:
    several = len({c.subject for c in report.checks if c.subject}) > 1
    for group, (title, what) in GROUPS.items():
        rows = [_row(c, several) for c in report.checks if c.group == group]
        yield {"title": title, "what": what[0].upper() + what[1:] + ".", "rows": rows}


def _row(check: Check, several: bool) -> dict[str, str]:
    subject = f" ({check.subject})" if several and check.subject else ""
    return {
        "mark": mark_of(check),
        "title": check.title + subject,
        "detail": check.detail,
        "condition": check.condition,
        "source": check.source,
        "value": check.value_text,
        "limit": check.limit_text,
        "where": check.where_text,
    }


def _grouped(number: int) -> str:
    return f"{number:,}".replace(",", "\u202f")


def _for_script(data: dict[str, Any]) -> str:
    """JSON that cannot end the script it stands in."""
    return json.dumps(data, ensure_ascii=False, separators=(",", ":")).replace("</", "<\\/")
