"""Nearest points tell the class of a map between things that stand in each other's place."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import CrossSection, Manifold

from touchwarp.goals.maps.hyperbolic import search
from touchwarp.goals.maps.hyperbolic.marking import Marking, find_marking
from touchwarp.goals.maps.hyperbolic.nearest_class import nearest_classes
from touchwarp.goals.maps.make import match_goal
from touchwarp.goals.maps.parameterise import work_mesh
from touchwarp.scene import MatchGoal, Prop, Surface

from ..conftest import slab_with_holes

SLAB = slab_with_holes(3)


def chain_of_rings() -> Surface:
    """Three rings in a row, where the slab has its holes: genus 3."""
    chain = Manifold()
    for k in range(3):
        ring = CrossSection.circle(0.008, 20).translate((0.018, 0)).revolve(40)
        chain = chain + ring.translate((0.032 + 0.038 * k, 0.025, 0.01))
    mesh = chain.to_mesh64()
    return Surface(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts, np.int64))


@pytest.fixture(scope="module")
def marking() -> Marking:
    return find_marking(work_mesh(SLAB, "the slab").whole)


def test_a_surface_is_nearest_to_itself_in_the_class_that_moves_nothing(marking: Marking) -> None:
    springs = marking.springs
    found = [springs.key(images) for images in nearest_classes(marking, marking)]
    assert springs.key(marking.images) in found
    # the twin: with all loops reversed it is another
    exchanged = {
        k: tuple(-letter for letter in reversed(word)) for k, word in marking.images.items()
    }
    assert springs.key(exchanged) not in found


def test_three_rings_are_matched_to_a_slab_with_three_holes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """In the class of nearest points; the others that are tried turn normals by 54° or more."""
    monkeypatch.setattr(search, "MOST_CLASSES", 8)  # nearest points are among the first
    goal = match_goal(Prop("prop", chain_of_rings()), MatchGoal(SLAB))
    assert goal.report["flips"] == 0
    assert goal.report["domain_flips"] == 0
    assert goal.report["coverage"] == 1.0
    assert goal.report["normal_mean"] < np.radians(35)
    # each ring shows around the hole that it stands at
    displacement = np.linalg.norm(goal.virtual_points - goal.prop_points, axis=1)
    assert displacement.max() < 0.038
    # the twin: in the other classes that were tried, energies are many times greater
    assert min(goal.report["start_energies"][1:]) > 3 * goal.report["start_energies"][0]
