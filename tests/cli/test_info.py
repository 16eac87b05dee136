"""`touchwarp info` tells what a file holds."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from touchwarp.cli.main import main


def test_a_scene(ball_scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(ball_scene)]) == 0
    told = capsys.readouterr().out
    assert "is a scene" in told
    assert "farthest displacement on ball" in told
    assert "10 mm" in told


def test_a_scene_is_checked(ball_scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = ball_scene.read_text()
    ball_scene.write_text(text.replace("translation = [0.01", "translation = [0.19"))
    assert main(["info", str(ball_scene)]) == 2
    assert "virtual object" in capsys.readouterr().err


def test_a_mesh(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh = tmp_path / "open.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\n")
    assert main(["info", str(mesh), "--unit", "cm", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["kind"] == "mesh"
    assert told["faces"] == 3
    assert told["watertight"] is False
    assert told["size_mm"] == [10, 10, 10]


def test_a_warp(ball_warp: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(ball_warp), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["kind"] == "warp"
    assert told["props"] == ["ball"]
    assert told["estimated_error_max_mm"] == 0.5
    assert told["bytes"] == ball_warp.stat().st_size
    assert main(["info", str(ball_warp)]) == 0
    assert "0.5 mm" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["missing.toml", "missing.stl", "missing.warp"])
def test_a_missing_file(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(tmp_path / name)]) == 2
    assert name in capsys.readouterr().err


def test_a_foreign_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "photo.jpg").write_bytes(b"\xff\xd8\xff\xe0 no warp")
    assert main(["info", str(tmp_path / "photo.jpg")]) == 2
    assert "photo.jpg" in capsys.readouterr().err
