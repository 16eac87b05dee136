"""From a surface to its area-preserving layout on the sphere or the flat torus."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.maps.areas import polish_areas, spread, target_shares
from touchwarp.goals.maps.closed_mesh import ClosedMesh, closed_mesh
from touchwarp.goals.maps.embed import embed, relax_layout
from touchwarp.goals.maps.homology import handle_places, torus_forms
from touchwarp.goals.maps.layout import Layout
from touchwarp.goals.maps.layout_cache import keep_layout, load_layout
from touchwarp.goals.maps.tidy import Tidied, tidy
from touchwarp.goals.refinement import refine
from touchwarp.scene.surface import Surface

AREA_AIM = 0.02
"""The spread of area ratios that a layout is polished to: small beside that of any `match`."""
EDGES_PER_SIZE = 40
"""Edges longer than the root of the surface's area over this are divided first."""
TIDY = 2e-6
"""m: how far taking out a needle may move the surface."""
LONG_TO_SHORT = 6
ROUNDS = 4


def work_mesh(surface: Surface, what: str) -> Tidied:
    """The surface as a closed mesh without long edges and, within `TIDY`, without needles.

    Raises:
        GoalError: the surface is not closed, not manifold, or in pieces.
    """
    mesh = closed_mesh(surface, what)
    longest = float(np.sqrt(mesh.area)) / EDGES_PER_SIZE
    fine = refine(Surface(mesh.vertices, mesh.faces), longest)
    return tidy(ClosedMesh(fine.vertices, fine.faces), TIDY, longest / LONG_TO_SHORT)


def check_topology(prop: ClosedMesh, virtual: ClosedMesh, kind: str) -> None:
    """Raise GoalError unless both have as many handles."""
    if prop.genus == virtual.genus:
        return
    told = " and ".join(
        f"{what} has genus {mesh.genus}{_places(mesh)}"
        for what, mesh in (("the prop", prop), ("the virtual object", virtual))
    )
    raise GoalError(
        f"{told}; {kind} needs surfaces of the same genus, as no one-to-one map joins these. Fill "
        "the hole of one or cut its handle in a modelling tool, or choose another kind: "
        "plane_projection or direction."
    )


def lay_out(mesh: ClosedMesh) -> Layout:
    """The mesh's area-preserving layout, from the cache if it is there.

    Raises:
        GoalError: the mesh cannot be laid out.
    """
    kept = load_layout(mesh)
    if kept is not None:
        return kept
    shifts = _corner_shifts(mesh)
    layout = Layout(mesh, embed(mesh, shifts), shifts)
    target = target_shares(mesh.face_areas)
    for _ in range(ROUNDS):
        layout = polish_areas(layout, target, AREA_AIM)
        if spread(layout.shares, target) <= AREA_AIM:
            break
        layout = relax_layout(layout)  # a needle that stopped the steps of all gets out of the way
    keep_layout(layout)
    return layout


def _corner_shifts(mesh: ClosedMesh) -> NDArray[np.float64]:
    if mesh.genus == 0:
        return np.zeros((len(mesh.faces), 3, 2))
    first, second, _ = torus_forms(mesh).reshape(3, -1, 2).astype(np.float64)
    return np.stack([np.zeros_like(first), first, first + second], axis=1)


def _places(mesh: ClosedMesh) -> str:
    if mesh.genus == 0:
        return ""
    many = mesh.genus > 1
    where = ", ".join(
        "({:.0f} {:.0f} {:.0f})".format(*place) for place in 1e3 * handle_places(mesh)[:6]
    )
    return f" ({'handles' if many else 'a handle'} about {where} mm)"
