"""Rings of neighbours hold the whole mesh."""

from __future__ import annotations

import numpy as np
import pytest

from touchwarp.goals.maps.levels import faces_of
from touchwarp.goals.maps.parameterise import work_mesh
from touchwarp.goals.maps.rings import build_rings

from .conftest import slab_with_holes


@pytest.mark.parametrize("holes", [0, 1, 6])
def test_faces_come_back_from_their_rings(holes: int) -> None:
    mesh = work_mesh(slab_with_holes(holes), "x").mesh
    assert mesh.genus == holes
    rings = build_rings(mesh.faces, np.zeros((len(mesh.faces), 3, 2)), len(mesh.vertices))
    faces, _ = faces_of(*rings[:3], np.ones(len(mesh.vertices), np.bool_))
    first = mesh.faces.argmin(axis=1)[:, None]
    turned = np.take_along_axis(mesh.faces, (first + np.arange(3)) % 3, axis=1)
    assert set(map(tuple, faces.tolist())) == set(map(tuple, turned.tolist()))
