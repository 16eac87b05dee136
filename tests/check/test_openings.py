"""Openings are found, and those that leak are told apart."""

from __future__ import annotations

import numpy as np
import pytest

from tests.check.stand_ins import Still, ball, ball_scene, ball_warp, case_of
from touchwarp.check.openings import check_openings, find_openings
from touchwarp.scene import Prop, Scene, Surface


def without(mask) -> Scene:
    """The ball without the faces whose middles are marked."""
    surface = ball()
    middles = surface.vertices[surface.faces].mean(axis=1)
    return Scene(props=[Prop("ball", Surface(surface.vertices, surface.faces[~mask(middles)]))])


def test_a_closed_prop_has_no_openings() -> None:
    assert check_openings(case_of(ball_scene(), ball_warp())).checks == []


def test_two_holes_are_two_openings_and_the_wider_is_told() -> None:
    scene = without(lambda m: (m[:, 0] > 0.045) | (m[:, 2] > 0.0485))
    case = case_of(scene, Still())
    _, widths = find_openings(case.props[0])
    assert len(widths) == 2
    # the caps' rims are circles of these radii, but for the zigzag of the faces
    assert sorted(1e3 * widths) == pytest.approx(
        [2e3 * np.sqrt(0.05**2 - h**2) for h in (0.0485, 0.045)], rel=0.25
    )
    (check,) = check_openings(case).checks
    assert np.array(check.where) == pytest.approx(np.array([0.045, 0, 0]), abs=3e-3)
    assert "2 openings, 2 of them wider than a cell" in check.detail
    assert "Ω goes on inside" in check.detail


def test_a_sheet_is_told_as_one() -> None:
    (check,) = check_openings(case_of(without(lambda m: m[:, 2] > 0), Still())).checks
    assert "taken as a sheet" in check.detail
    assert check.value == pytest.approx(100.0, rel=0.05)
