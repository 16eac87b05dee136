"""Two-handled vessels, small, and a cache of their own."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from touchwarp.goals.maps import parameterise
from touchwarp.scene.surface import Surface


@pytest.fixture(autouse=True, scope="module")
def small_and_alone(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(parameterise, "EDGES_PER_SIZE", 14)
        patch.setenv("TOUCHWARP_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


def vessel(
    radius: float, height: float, reach: float, turn: float = 0.0, wall: float = 0.005
) -> Surface:
    """A cup with a square handle on either side, m: genus 2.

    Args:
        radius, height: of the cup; wall: how thick it is.
        reach: of the handles beyond it.
        turn: deg about the axis.
    """
    from manifold3d import Manifold

    outside = Manifold.cylinder(height, radius, radius, 24)
    room = Manifold.cylinder(height, radius - wall, radius - wall, 24).translate((0, 0, wall))
    span = 2 * (radius + reach)
    bar = Manifold.cube((span, 2 * wall, height / 2), True)
    bar -= Manifold.cube((span - 4 * wall, 4 * wall, height / 2 - 4 * wall), True)
    solid = (outside + bar.translate((0, 0, height / 2))) - room
    mesh = solid.rotate((0, 0, turn)).to_mesh64()
    return Surface(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts, np.int64))


def vase() -> Surface:
    return vessel(0.03, 0.1, 0.03)


def pot() -> Surface:
    return vessel(0.05, 0.07, 0.025, turn=8.0)
