"""Needles go before a layout is made, and come back without turning anything over."""

from __future__ import annotations

import numpy as np
import pytest

from touchwarp.goals.maps.closed_mesh import ClosedMesh, closed_mesh
from touchwarp.goals.maps.embed import relax_layout
from touchwarp.goals.maps.layout import Layout
from touchwarp.goals.maps.parameterise import TIDY, lay_out, work_mesh
from touchwarp.goals.maps.tidy import Tidied, tidy
from touchwarp.goals.surface_tree import SurfaceTree
from touchwarp.scene.surface import Surface

from .conftest import ring_surface, slab_with_holes


def with_needles(surface: Surface, part: float = 1e-4) -> ClosedMesh:
    """Some faces cut by a vertex next to one of their corners: three needles each."""
    mesh = closed_mesh(surface, "x")
    vertices, faces = list(mesh.vertices), [list(face) for face in mesh.faces]
    for f in range(0, len(mesh.faces), 7):
        a, b, c = mesh.faces[f]
        corners = mesh.vertices[[a, b, c]]
        vertices.append((1 - 2 * part) * corners[0] + part * corners[1] + part * corners[2])
        new = len(vertices) - 1
        faces[f] = [a, b, new]
        faces += [[b, c, new], [c, a, new]]
    return ClosedMesh(np.array(vertices), np.array(faces, np.int64))


@pytest.mark.parametrize("surface", [slab_with_holes(1), ring_surface()])
def test_needles_go_and_come_back_unturned(surface: Surface) -> None:
    whole = with_needles(surface)
    tidied = tidy(whole, TIDY, 0.0)
    assert len(tidied.removed) >= len(whole.faces) // 40
    tree = SurfaceTree(whole.vertices, whole.faces)
    assert tree.nearest(tidied.mesh.vertices[tidied.mesh.faces].mean(axis=1)).distance.max() <= TIDY
    layout = tidied.restore(lay_out(tidied.mesh))
    assert set(map(tuple, layout.mesh.faces.tolist())) == {
        tuple(np.roll(face, -int(np.argmin(face))).tolist()) for face in whole.faces
    }
    assert (layout.shares > 0).all()
    assert layout.shares.sum() == pytest.approx(1, abs=1e-9)


def test_the_claim_rejects_needles_put_back_onto_their_neighbours() -> None:
    """The twin: put back where they collapsed to, not into their rings, they have no area."""
    whole = with_needles(ring_surface())
    tidied = tidy(whole, TIDY, 0.0)
    layout = tidied.restore(lay_out(tidied.mesh))
    points = layout.points.copy()
    points[tidied.removed] = points[tidied.rings[:, 0]]
    assert (layout.moved(points).shares <= 1e-15).any()


A_HAIR = 1e-3
"""On a torus of area 1, where edges of that mesh are some 0.05 long."""


def off_their_places(layout: Layout, tidied: Tidied, below: Layout) -> float:
    """How far vertices that came back are from where the mesh without them has their points."""
    back = tidied.whole.vertices[tidied.removed]
    tree = SurfaceTree(tidied.mesh.vertices, tidied.mesh.faces)
    nearest = tree.nearest(back)
    own = np.einsum("nk,nkd->nd", tree.weights(nearest), below.corners[nearest.elements])
    gap = layout.points[tidied.removed] - own
    gap[:, :2] -= np.rint(gap[:, :2])
    return float(np.linalg.norm(gap, axis=1).max())


def test_needles_come_back_to_their_own_places() -> None:
    tidied = tidy(with_needles(ring_surface()), TIDY, 0.0)
    below = lay_out(tidied.mesh)
    assert off_their_places(tidied.restore(below), tidied, below) < A_HAIR


def test_the_claim_rejects_needles_that_were_given_room() -> None:
    """The twin: with even triangles around them the map would tear along them."""
    tidied = tidy(with_needles(ring_surface()), TIDY, 0.0)
    below = lay_out(tidied.mesh)
    evened = relax_layout(tidied.restore(below))
    assert off_their_places(evened, tidied, below) > A_HAIR


def test_a_mesh_without_needles_stays_as_it_is() -> None:
    tidied = work_mesh(ring_surface(), "x")
    layout = lay_out(tidied.mesh)
    assert tidied.restore(layout) is layout
