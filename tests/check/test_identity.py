"""Nothing moves on and beyond ∂Ω1, nor on what is held; on a sliding plane only along it."""

from __future__ import annotations

import numpy as np
import pytest

import touchwarp as tw
from tests.check.stand_ins import (
    Spoiled,
    Still,
    ball_scene,
    ball_warp,
    block_scene,
    case_of,
    shifted,
    translation,
)
from touchwarp.check.brick_faces import cell_sides
from touchwarp.check.identity import check_identity
from touchwarp.scene import Fixed, Objective, Outer
from touchwarp.scene.shapes import box, sphere


def found(scene, warp):
    return {c.name: c for c in check_identity(case_of(scene, warp)).checks}


def test_the_exact_warp_is_still_outside() -> None:
    checks = found(ball_scene(), ball_warp())
    assert {n: c.status for n, c in checks.items()} == {
        "identity.outer": "pass",
        "identity.beyond": "pass",
    }


def test_a_warp_that_is_not_zero_outside_fails() -> None:
    checks = found(ball_scene(), shifted(ball_warp(), 0.01))
    assert checks["identity.outer"].status == checks["identity.beyond"].status == "fail"
    assert checks["identity.outer"].value == pytest.approx(0.01)


def test_a_warp_that_moves_only_beyond_fails_there() -> None:
    far = Spoiled(ball_warp(), lambda x: np.where(np.abs(x).max(1, keepdims=True) > 0.25, 1e-3, 0))
    checks = found(ball_scene(), far)
    assert checks["identity.outer"].status == "pass"
    assert checks["identity.beyond"].status == "fail"


def test_a_curved_outer_boundary_has_the_tables_tolerance() -> None:
    scene = ball_scene(outer=Outer(surface=sphere(0.2, 0.5)))
    checks = found(scene, ball_warp())
    assert checks["identity.outer"].limit == pytest.approx(0.1)
    assert checks["identity.beyond"].status == "pass"
    spoiled = found(scene, shifted(ball_warp(), 0.2))
    assert spoiled["identity.outer"].status == spoiled["identity.beyond"].status == "fail"


def test_cells_that_a_curved_outer_boundary_crosses_are_judged_by_themselves() -> None:
    """To be 0 on ∂Ω1 u goes on to the nodes beyond it, and falls to 0 in the cells behind these."""
    objective = Objective(tolerance_mm=0.5)
    scene = ball_scene(outer=Outer(surface=sphere(0.2, 2.0)), objective=objective)
    table = tw.solve(scene)
    crossing = float(np.linalg.norm(cell_sides(table.bricks, sphere(0.2).vertices), axis=1).max())
    checks = found(scene, table)
    assert {name: check.status for name, check in checks.items()} == {
        "identity.outer": "pass",
        "identity.beyond": "pass",
        "identity.beside": "pass",
    }
    assert checks["identity.beside"].value > 1e-3

    def stirred(low, high):
        def by(x):
            away = np.linalg.norm(x, axis=1, keepdims=True) - 0.2
            return np.where((away > low) & (away < high), 1e-3, 0.0)

        spoiled = Spoiled(table, by)
        spoiled.bricks = table.bricks  # the cells are read off there
        checks = found(scene, spoiled)
        return {name: checks[name].status for name in ("identity.beyond", "identity.beside")}

    assert stirred(0.5 * crossing, crossing) == {
        "identity.beyond": "pass",
        "identity.beside": "warn",
    }
    assert stirred(2.1 * crossing, np.inf) == {"identity.beyond": "fail", "identity.beside": "pass"}


def along_the_table(x):
    return np.stack([1e-3 * np.ones(len(x)), np.zeros(len(x)), x[:, 2]], axis=1)


def off_the_table(x):
    return np.stack([np.zeros(len(x)), np.zeros(len(x)), np.full(len(x), 1e-4)], axis=1)


def test_a_sliding_plane_may_move_along_itself_only() -> None:
    assert (
        found(block_scene(), Spoiled(Still(), along_the_table))["identity.slide"].status == "pass"
    )
    check = found(block_scene(), Spoiled(Still(), off_the_table))["identity.slide"]
    assert check.status == "fail"
    assert check.value == pytest.approx(0.1)
    assert check.subject == "table"


def test_the_contact_line_is_told_apart() -> None:
    def at_the_block(x):
        near = (np.abs(x[:, :2]) < [0.035, 0.025]).all(axis=1)
        return np.where(near[:, None], [0, 0, 1e-3], 0.0)

    checks = found(block_scene(), Spoiled(Still(), at_the_block))
    assert checks["identity.slide"].status == "pass"
    assert checks["identity.contact_line"].value == pytest.approx(1.0)
    assert checks["identity.contact_line"].group == "told"


@pytest.mark.parametrize(
    "fixed",
    [
        Fixed("wall", plane=([0.1, 0, 0], [-1, 0, 0]), contact="hold"),
        Fixed(
            "shelf",
            surface=box([0.05, 0.05, 0.01]).transformed(translation(0, 0, 0.12)),
        ),
    ],
    ids=["plane", "mesh"],
)
def test_held_surfaces_hold(fixed: Fixed) -> None:
    scene = ball_scene(1.0, (0, 0, 0), fixed=[fixed])
    assert found(scene, Still())["identity.hold"].status == "pass"
    assert found(scene, shifted(Still(), 0.3))["identity.hold"].status == "fail"
