"""Narrow tunnels of a closed mesh are closed where they are; a handle is no tunnel."""

from __future__ import annotations

import numpy as np
import pytest

from tests.goals.maps.conftest import ring_surface
from tests.scan.scans import fine_mug, with_tunnel
from touchwarp.scan.deviation import deviation
from touchwarp.scan.soundness import inspect
from touchwarp.scan.tunnels import close_tunnels, shortest_loop
from touchwarp.scene.surface import Surface


@pytest.fixture(scope="module")
def mug() -> Surface:
    return fine_mug(3e-3)


@pytest.fixture(scope="module")
def bored(mug: Surface) -> Surface:
    """With two tunnels through its wall, opposite to the handle's side and beside it."""
    return with_tunnel(with_tunnel(mug, [-0.04, 0.0, 0.05]), [0.0, 0.04, 0.03])


def test_the_shortest_loop_of_a_torus_is_around_its_tube() -> None:
    ring = ring_surface(radius=0.03, tube=0.006, across=14)
    # a regular polygon of 14 corners; the hole is 2π·24 mm around
    assert shortest_loop(ring)[1] == pytest.approx(28 * 0.006 * np.sin(np.pi / 14), rel=1e-9)


def test_two_tunnels_are_closed_and_nothing_else_moves(mug: Surface, bored: Surface) -> None:
    assert inspect(bored).sound
    assert inspect(bored).genus == 3
    closed, around = close_tunnels(bored, 1)
    assert inspect(closed).sound
    assert inspect(closed).genus == 1
    assert len(around) == 2
    assert deviation(mug, closed).p99_mm < 0.5
    assert deviation(mug, closed).max_mm < 3.0
    # the handle's hole is still open: a loop around the grip is as long as before
    assert shortest_loop(closed)[1] == pytest.approx(shortest_loop(mug)[1], rel=0.1)


def test_only_as_many_tunnels_are_closed_as_are_too_many(bored: Surface) -> None:
    closed, around = close_tunnels(bored, 2)
    assert inspect(closed).genus == 2
    assert len(around) == 1


def test_a_handle_is_no_tunnel(mug: Surface) -> None:
    # the twin: what is asked for would cut the grip
    kept, around = close_tunnels(mug, 0)
    assert around == ()
    assert inspect(kept).genus == 1
    assert shortest_loop(mug)[1] > 0.02
