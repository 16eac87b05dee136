"""A foot is closed flat on the table, and the rest of the thing stays as it was."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from manifold3d import Manifold

from tests.scan.scans import (
    BEAKER_HEIGHT,
    BEAKER_RADIUS,
    HOLLOW,
    SEGMENTS,
    beaker,
    disc,
    ringed,
    stool,
    surface_of,
)
from touchwarp.scan.deviation import distances, sample
from touchwarp.scan.foot import with_flat_foot
from touchwarp.scan.soundness import inspect, volume
from touchwarp.scene.shapes import make_shape
from touchwarp.scene.surface import Surface


def test_a_hollow_is_closed_and_nothing_else_changes() -> None:
    cup = beaker()
    foot = with_flat_foot(cup)
    assert foot is not None
    assert foot.pieces == 1
    assert foot.hollow == pytest.approx(HOLLOW, rel=1e-9)
    # a regular polygon's area, by its radius
    inner = 0.5 * SEGMENTS * np.sin(2 * np.pi / SEGMENTS) * (BEAKER_RADIUS - 0.004) ** 2
    assert volume(foot.surface) == pytest.approx(volume(cup) + inner * HOLLOW, rel=1e-9)
    assert inspect(foot.surface).sound
    # no fan: layouts of surfaces do not bear vertices of very many neighbours
    assert np.bincount(foot.surface.faces.ravel()).max() < 40
    # what is seen of it and touched is where it was
    points = sample(cup, 4000, np.random.default_rng(0))[0]
    below = (np.linalg.norm(points[:, :2], axis=1) < BEAKER_RADIUS - 1e-3) & (points[:, 2] < 0.005)
    assert distances(points[~below], foot.surface).max() < 1e-9
    # the twin: in the hollow itself it is not
    assert distances(points[below], foot.surface).max() > 0.9 * HOLLOW


def test_an_uneven_ring_is_cut_where_its_outline_is_whole() -> None:
    # the ring is 0.6 mm lower on one side; a plane below its inner rim's highest point opens it
    cup = beaker()
    low = cup.vertices[:, 2] < 1e-9
    vertices = cup.vertices.copy()
    vertices[low, 2] -= 3e-4 * (1 - cup.vertices[low, 0] / BEAKER_RADIUS)
    vertices[:, 2] -= vertices[:, 2].min()
    foot = with_flat_foot(Surface(vertices, cup.faces))
    assert foot is not None
    highest = 3e-4 * (1 + (BEAKER_RADIUS - 0.004) / BEAKER_RADIUS)
    assert highest < foot.drawn < highest + 1.5e-4
    assert foot.pieces == 1
    assert foot.surface.bounds[0, 2] == 0.0
    assert inspect(foot.surface).genus == 0


def test_a_round_belly_stands_on_a_flat_of_its_own() -> None:
    ball = make_shape("sphere", {"radius": 0.04}).transformed(
        np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.04], [0, 0, 0, 1.0]])
    )
    foot = with_flat_foot(ball)
    assert foot is not None
    assert foot.hollow == 0.0
    assert 0 < foot.drawn < 0.015 * 0.14
    flat = foot.surface.vertices[foot.surface.vertices[:, 2] == 0.0]
    # the circle in which a plane at that height cuts the ball
    reach = np.sqrt(foot.drawn * (0.08 - foot.drawn))
    assert np.linalg.norm(flat[:, :2], axis=1).max() == pytest.approx(reach, rel=5e-3)


@pytest.mark.parametrize("kind", ["mug", "tea_cup", "cylinder"])
def test_a_flat_foot_is_left_as_it_is(kind: str) -> None:
    shape = {"radius": 0.03, "height": 0.1} if kind == "cylinder" else {}
    thing = make_shape(kind, shape)
    foot = with_flat_foot(thing)
    assert foot is not None
    assert foot.surface is thing
    assert foot.drawn == 0.0


def test_each_leg_gets_a_foot_of_its_own() -> None:
    foot = with_flat_foot(stool())
    assert foot is not None
    assert foot.pieces == 3


def _notched() -> Any:
    return beaker() - Manifold.cube([0.1, 0.01, 2 * HOLLOW]).translate([0, 0, -HOLLOW])


def _tube() -> Any:
    return disc(BEAKER_HEIGHT, BEAKER_RADIUS) - disc(
        3 * BEAKER_HEIGHT, BEAKER_RADIUS - 0.004
    ).translate([0, 0, -BEAKER_HEIGHT])


@pytest.mark.parametrize(
    "thing",
    [_tube(), disc(0.05, 0.02).translate([0, 0, 0.01])],
    ids=["a tube", "above the table"],
)
def test_what_has_no_outline_near_the_table_is_not_closed(thing: Any) -> None:
    assert with_flat_foot(surface_of(thing)) is None


def test_a_hollow_that_opens_to_a_side_stays_open() -> None:
    notch = Manifold.cube([0.1, 0.01, 2 * HOLLOW]).translate([0, 0, -HOLLOW])
    cup = surface_of(ringed() - notch)
    foot = with_flat_foot(cup)
    # the outline of its ring is a C, which is flat on the table
    assert foot is not None
    assert foot.surface is cup


def test_an_open_surface_is_not_closed() -> None:
    cup = beaker()
    assert with_flat_foot(Surface(cup.vertices, cup.faces[1:])) is None
