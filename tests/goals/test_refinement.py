"""Refining changes no surface: same area, same places, same topology, short edges."""

from __future__ import annotations

import numpy as np
import pytest

from touchwarp.goals.refinement import MOST_FACES, refine
from touchwarp.goals.surface_samples import face_areas, face_normals
from touchwarp.goals.surface_tree import SurfaceTree
from touchwarp.scene.shapes import box, cylinder, make_shape
from touchwarp.scene.surface import Surface
from touchwarp.scene.topology import edge_counts, open_edge_count

SURFACES = {
    "box": box([0.03, 0.04, 0.1]),
    "cylinder": cylinder(0.03, 0.2),
    "cup": make_shape("tea_cup", {}),
}


def longest_edge(surface: Surface) -> float:
    corners = surface.vertices[surface.faces]
    return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max())


def characteristic(surface: Surface) -> int:
    edges, _ = edge_counts(surface.faces)
    return len(np.unique(surface.faces)) - len(edges) + len(surface.faces)


@pytest.mark.parametrize("name", SURFACES)
def test_a_refined_surface_is_the_same_surface(name: str) -> None:
    surface = SURFACES[name]
    fine = refine(surface, 3e-3)
    assert longest_edge(fine) <= 3e-3
    assert characteristic(fine) == characteristic(surface)
    assert open_edge_count(fine.faces) == 0
    before, after = (face_areas(s.vertices, s.faces) for s in (surface, fine))
    assert after.sum() == pytest.approx(before.sum(), rel=1e-9)
    tree = SurfaceTree(surface.vertices, surface.faces)
    near = tree.nearest(fine.vertices[fine.faces].mean(axis=1))
    assert near.distance.max() < 1e-9
    normals = face_normals(surface.vertices, surface.faces)[near.elements]
    turned = np.einsum("ij,ij->i", normals, face_normals(fine.vertices, fine.faces))
    assert turned @ after == pytest.approx(after.sum(), rel=1e-6)


def test_needles_do_not_breed_needles() -> None:
    # 88 strips of 2 mm by 200 mm; by halving alone there are 280,000 faces
    fine = refine(SURFACES["cylinder"], 2.67e-3)
    assert len(fine.faces) < MOST_FACES
    area = 2 * np.pi * 0.03 * 0.23
    # equilateral triangles of half the longest edge would be 9.2 of these
    assert len(fine.faces) < 10 * area / (2.67e-3) ** 2


def test_the_given_vertices_come_first() -> None:
    surface = SURFACES["box"]
    fine = refine(surface, 5e-3)
    assert {tuple(v) for v in fine.vertices[:8]} == {tuple(v) for v in surface.vertices}


def test_a_large_surface_is_divided_less() -> None:
    assert len(refine(box([2.0, 2.0, 2.0]), 2e-3).faces) <= MOST_FACES


def test_a_fine_surface_stays() -> None:
    surface = refine(SURFACES["box"], 5e-3)
    again = refine(surface, 5e-3)
    assert len(again.faces) == len(surface.faces)
