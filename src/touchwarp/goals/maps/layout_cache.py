"""Layouts kept on disk by the content of their mesh."""

from __future__ import annotations

import numpy as np

from touchwarp.goals.cache import Cache, content_key
from touchwarp.goals.maps.closed_mesh import ClosedMesh
from touchwarp.goals.maps.layout import Layout

LAYOUTS = Cache("layouts", most_bytes=100_000_000)
"""A layout of 20,000 faces takes 0.36 MB."""


def load_layout(mesh: ClosedMesh) -> Layout | None:
    """The layout kept of this very mesh; None where there is none, or it is damaged."""
    arrays = LAYOUTS.load(content_key(mesh.vertices, mesh.faces))
    if arrays is None:
        return None
    return Layout(mesh, arrays["points"], arrays["corner_shift"].astype(np.float64))


def keep_layout(layout: Layout) -> None:
    """Keep a layout for its mesh."""
    LAYOUTS.keep(
        content_key(layout.mesh.vertices, layout.mesh.faces),
        points=layout.points,
        corner_shift=layout.corner_shift.astype(np.int8),
    )
