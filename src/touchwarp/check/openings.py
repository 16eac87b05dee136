"""Holes in the props' surfaces: through one wider than a cell of the table, Ω leaks inside."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from touchwarp.check.case import Case, Finding, PropCase
from touchwarp.check.report import Check, measured, place

Float = NDArray[np.float64]


def check_openings(case: Case) -> Finding:
    """The widest opening of each prop that has any, and how many are wider than a cell."""
    checks: list[Check] = []
    if case.dimension == 3:
        for prop in case.props:
            centres, widths = find_openings(prop)
            if len(widths):
                checks.append(_opening(case, prop, centres, widths))
    return Finding(checks, {})


def find_openings(prop: PropCase) -> tuple[Float, Float]:
    """Centres (n, 3) m and widths (n,) m of the loops of open rims, by their bounding boxes.

    The width is the middle one of a box's three sides: a slit is as wide as it is narrow.
    """
    ends = prop.edges.ends[prop.edges.rim]
    if len(ends) == 0:
        return np.empty((0, 3)), np.zeros(0)
    vertices, index = np.unique(ends, return_inverse=True)
    index = index.reshape(ends.shape)
    links = coo_array(
        (np.ones(len(ends)), (index[:, 0], index[:, 1])), shape=(len(vertices), len(vertices))
    )
    count, loop = connected_components(links, directed=False)
    points = prop.goal.prop_points[vertices]
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, loop, points)
    np.maximum.at(high, loop, points)
    return 0.5 * (low + high), np.sort(high - low, axis=1)[:, 1]


def _opening(case: Case, prop: PropCase, centres: Float, widths: Float) -> Check:
    cell = case.surface_cell / np.sqrt(3.0)
    leaking = int((widths > cell).sum())
    detail = (
        f"{len(widths):,} openings, {leaking:,} of them wider than a cell ({1e3 * cell:.2g} mm)."
    )
    if leaking and prop.body.closed:
        detail += (
            " Through those Ω goes on inside the prop: u is solved there, and ties the two sides "
            "of the wall to each other; contact is not affected."
        )
    if not prop.body.closed:
        detail += " The surface is taken as a sheet: all of space around it is in Ω."
    widest = int(widths.argmax())
    return measured(
        "surface.opening",
        "Widest opening of the prop's surface",
        1e3 * float(widths[widest]),
        "mm",
        group="told",
        subject=prop.name,
        where=place(centres, widest),
        detail=detail,
    )
