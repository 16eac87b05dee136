"""Plane scenes go through the same certificate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import touchwarp as tw
from touchwarp.check.report import Report
from touchwarp.scene import Prop, Scene, TransformGoal
from touchwarp.scene.shapes import polygon
from touchwarp.warp.plane_table import PlaneTableWarp

ELL = polygon([[0, 0], [0.1, 0], [0.1, 0.03], [0.03, 0.03], [0.03, 0.1], [0, 0.1]])
SCENE = Scene(
    props=[Prop("ell", ELL, TransformGoal(pivot="centre", scale=1.2, rotation_deg=10))],
    dimension=2,
)


@pytest.fixture(scope="module")
def warp() -> PlaneTableWarp:
    solved = tw.solve(SCENE, tolerance_mm=0.3)
    assert isinstance(solved, PlaneTableWarp)
    return solved


@pytest.fixture(scope="module")
def report(warp: PlaneTableWarp) -> Report:
    return tw.check(SCENE, warp, samples=20_000)


def test_a_solved_plane_scene_keeps_its_hard_promises(report: Report) -> None:
    hard = [c for c in report.checks if c.group == "hard"]
    assert {c.name: c.status for c in hard} == {c.name: "pass" for c in hard}
    assert report.of("edges.max").detail.startswith("The mean is")
    assert report.of("folds.volume").unit == "mm²"
    assert report.of("contact.mean").where is None
    assert len(report.of("contact.p99").where) == 2


def test_spaceful_checks_are_left_out(report: Report) -> None:
    assert not any(c.name in ("pinch.width", "curvature.change") for c in report.checks)


def spoiled(warp: PlaneTableWarp, node: tuple[int, int], by: float) -> PlaneTableWarp:
    values = warp.table.values.copy()
    values[node] += by
    return PlaneTableWarp(replace(warp.table, values=values), warp.meta)


def test_a_spoiled_node_fails_contact_or_field_and_a_border_identity(warp: PlaneTableWarp) -> None:
    middle = tuple(n // 2 for n in warp.table.values.shape[:2])
    border = tw.check(SCENE, spoiled(warp, (0, middle[1]), 1e-3), samples=20_000)
    assert border.of("identity.outer").status == "fail"
    assert border.of("continuity.jump").status == "fail"


def test_the_page_draws_the_plane(report: Report, tmp_path) -> None:
    html = report.save_html(tmp_path / "plane.html").read_text(encoding="utf-8")
    assert "In the plane: mismatch" in html
    assert "<canvas" not in html
    assert np.char.count(np.array(html), "<svg") >= 9
