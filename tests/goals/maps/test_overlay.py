"""The overlay of two layouts: exact signs, both surfaces once and whole, nothing turned over."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from touchwarp.errors import GoalError
from touchwarp.goals.maps import overlay as overlays
from touchwarp.goals.maps.closed_mesh import ClosedMesh
from touchwarp.goals.maps.lattice import MOST, determinant, on_lattice
from touchwarp.goals.maps.layout import Layout
from touchwarp.goals.maps.meeting import Meetings
from touchwarp.goals.maps.overlay import Overlay, overlay
from touchwarp.goals.maps.parameterise import lay_out, work_mesh
from touchwarp.goals.surface_samples import face_areas
from touchwarp.scene.shapes import box, ellipsoid
from touchwarp.scene.surface import Surface

from .conftest import ring_surface

RING = ring_surface()
PAIRS = {
    "box to egg": (box([0.1, 0.06, 0.04]), ellipsoid([0.05, 0.06, 0.09], 0.5)),
    "ring to ring": (RING, Surface(RING.vertices * [1.2, 1.0, 0.7], RING.faces)),
}


def layouts(pair: str) -> tuple[Layout, Layout]:
    one, other = (lay_out(work_mesh(surface, "x").mesh) for surface in PAIRS[pair])
    return one, other


@pytest.fixture(params=PAIRS)
def pair(request: pytest.FixtureRequest) -> tuple[Layout, Layout]:
    return layouts(request.param)


def areas_along(points: np.ndarray, faces: np.ndarray, normals: np.ndarray) -> np.ndarray:
    a, b, c = (points[faces[:, k]] for k in range(3))
    return np.asarray((np.cross(b - a, c - a) * normals).sum(axis=1) / 2)


def test_determinants_have_the_sign_of_exact_arithmetic() -> None:
    rng = np.random.default_rng(0)
    for _ in range(300):
        a, b = rng.integers(-MOST, MOST, size=(2, 3))
        c = (a + b) // 2 + rng.integers(-1, 2, size=3)  # all but flat
        rows = [[Fraction(int(x)) for x in row] for row in (a, b, c)]
        exact = sum(
            rows[0][k]
            * (
                rows[1][(k + 1) % 3] * rows[2][(k + 2) % 3]
                - rows[1][(k + 2) % 3] * rows[2][(k + 1) % 3]
            )
            for k in range(3)
        )
        assert np.sign(determinant(a, b, c)) == np.sign(float(exact))


def test_rounded_arithmetic_gets_signs_wrong() -> None:
    """The twin: floating point, on the same kind of triples."""
    rng = np.random.default_rng(0)
    wrong = 0
    for _ in range(3000):
        a, b = rng.integers(-MOST, MOST, size=(2, 3))
        c = (a + b) // 2 + rng.integers(-1, 2, size=3)
        exact = np.sign(determinant(a, b, c))
        rounded = np.sign(a.astype(float) @ np.cross(b.astype(float), c.astype(float)))
        wrong += int(exact != rounded)
    assert wrong > 0


def test_both_surfaces_are_covered_once_and_nothing_is_turned_over(
    pair: tuple[Layout, Layout],
) -> None:
    prop, virtual = pair
    cut = overlay(prop, virtual)
    closed = ClosedMesh(cut.points, cut.faces)
    assert closed.genus == prop.mesh.genus
    assert (cut.faces[closed.neighbours].reshape(-1) >= 0).all()
    for points, faces, mesh in (
        (cut.points, cut.prop_face, prop.mesh),
        (cut.images, cut.virtual_face, virtual.mesh),
    ):
        along = areas_along(points, cut.faces, mesh.face_normals[faces])
        assert along.min() >= -1e-12 * mesh.area
        each = np.bincount(faces, along, len(mesh.faces))
        assert each == pytest.approx(mesh.face_areas, rel=1e-6, abs=1e-12 * mesh.area)


def test_the_claim_rejects_the_straight_map_of_the_props_own_faces() -> None:
    """The twin: the prop's faces as they are cut corners, and miss the virtual area."""
    prop, virtual = layouts("box to egg")
    cut = overlay(prop, virtual)
    image_of = np.empty_like(prop.mesh.vertices)
    corner = np.einsum("md,nd->mn", np.round(cut.points, 12), np.eye(3))
    image_of[:] = cut.images[
        [int(np.abs(corner - vertex).sum(axis=1).argmin()) for vertex in prop.mesh.vertices]
    ]
    straight = face_areas(image_of, prop.mesh.faces).sum()
    assert face_areas(cut.images, cut.faces).sum() == pytest.approx(virtual.mesh.area, rel=1e-9)
    assert straight < 0.999 * virtual.mesh.area


def test_a_layout_over_itself_has_every_corner_on_an_edge(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    layout, _ = layouts("ring to ring")
    cut = overlay(layout, layout)
    assert (
        np.abs(cut.points - cut.images).max() < 1e-5 * layout.mesh.diagonal
    )  # 64 units of 2⁻²⁸, stretched
    monkeypatch.setattr(overlays, "TRIES", 1)  # the twin: unmoved, nothing can be told
    with pytest.raises(GoalError, match="cannot be laid over one another without corners on edges"):
        overlay(layout, layout)


def test_a_triangle_too_thin_for_the_lattice_is_told() -> None:
    layout, _ = layouts("box to egg")
    points = layout.points.copy()
    face = layout.mesh.faces[0]
    points[face[0]] = points[face[1]]
    with pytest.raises(GoalError, match="triangles too thin to be told from turned ones; remesh"):
        on_lattice(layout.moved(points))


def test_meetings_and_overlays_are_what_they_say() -> None:
    prop, virtual = layouts("ring to ring")
    cut = overlay(prop, virtual)
    assert isinstance(cut, Overlay)
    assert set(np.unique(cut.prop_face)) == set(range(len(prop.mesh.faces)))
    assert set(np.unique(cut.virtual_face)) == set(range(len(virtual.mesh.faces)))
    assert Meetings._fields == ("prop", "virtual", "offset", "exact")
