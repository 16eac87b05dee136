"""`touchwarp check`: exit 1 on fail only; a report is whole or absent."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from touchwarp.cli.main import main
from touchwarp.warp.table import TableWarp


def test_a_kept_promise_is_exit_0(
    ball_scene: Path, ball_warp: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    report, page = tmp_path / "report.json", tmp_path / "report.html"
    outputs = ["--json", str(report), "--html", str(page)]
    assert main(["check", str(ball_scene), str(ball_warp), *outputs]) == 0
    assert json.loads(report.read_text())["status"] in ("pass", "warn")
    assert page.read_text(encoding="utf-8").rstrip().endswith("</html>")
    assert "Contact error, mean" in capsys.readouterr().out


def test_a_broken_promise_is_exit_1_and_told(
    ball_scene: Path, ball_table: TableWarp, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # The table samples the exact warp without a fit to the surface, and so misses a finer promise.
    warp, report = tmp_path / "strict.warp", tmp_path / "report.json"
    TableWarp(ball_table.bricks, replace(ball_table.meta, tolerance_mm=0.3)).save(warp)
    assert main(["check", str(ball_scene), str(warp), "--json", str(report)]) == 1
    told = json.loads(report.read_text())
    assert told["status"] == "fail"
    assert "contact.p99" in [c["name"] for c in told["checks"] if c["status"] == "fail"]
    assert "breaks a promise" in capsys.readouterr().out


def test_a_scene_of_another_warp_is_bad_input(
    ball_scene: Path, ball_warp: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ball_scene.write_text(ball_scene.read_text().replace("0.01, 0, 0", "0.02, 0, 0"))
    report = tmp_path / "report.json"
    assert main(["check", str(ball_scene), str(ball_warp), "--json", str(report)]) == 2
    assert "is not the one that the warp was made for" in capsys.readouterr().err
    assert not report.exists()


@pytest.mark.parametrize("option", ["--html", "--json"])
def test_outputs_are_tried_first(
    option: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output = tmp_path / "nowhere" / "report"
    assert main(["check", "no.toml", "no.warp", option, str(output)]) == 2
    assert "nowhere does not exist" in capsys.readouterr().err
