"""An exported page holds all that it needs, and is written whole or not at all."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from touchwarp.cli.main import main
from touchwarp.errors import LiveError, OutputError
from touchwarp.live import export
from touchwarp.live.export import export_page
from touchwarp.live.workbench import Workbench


def silent(step: str, done: float) -> None:
    """No progress is shown."""


def test_an_export_is_complete(ball_path: Path, tmp_path: Path) -> None:
    folder = tmp_path / "page"
    assert main(["view", str(ball_path), "--export", str(folder)]) == 0
    state = json.loads((folder / "boot.json").read_text())
    assert (state["live"], state["solvable"], state["recording"]) == (False, False, False)
    needed = [state["warp"]["url"], state["bases"]["url"]]
    needed += [prop["surface"] for prop in state["props"]]
    assert [name for name in ["index.html", *needed] if not (folder / name).is_file()] == []
    assert state["certificate"]["checks"]
    text = "".join(p.read_text() for p in folder.rglob("*.html")) + json.dumps(state)
    assert str(tmp_path) not in text, "the page must not tell where it was made"


def test_an_earlier_export_is_replaced_and_other_folders_are_not(
    ball_path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "page"
    folder.mkdir()
    (folder / "thesis.txt").write_text("years of work")
    assert main(["view", str(ball_path), "--export", str(folder)]) == 2
    assert (folder / "thesis.txt").exists()
    with pytest.raises(LiveError, match=r"thesis.txt is a file; give a new or empty folder"):
        export_page(ball_path, folder / "thesis.txt", silent)
    (folder / "boot.json").write_text("{}")  # now it looks like an earlier export
    monkeypatch.setattr(Workbench, "finish", lambda bench: None)
    export_page(ball_path, folder, silent)
    assert not (folder / "thesis.txt").exists()


def test_what_was_there_stays_when_it_cannot_be_written(
    ball_path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*paths: object, **options: object) -> None:
        raise OSError(28, "No space left on device")

    folder = tmp_path / "page"
    folder.mkdir()
    (folder / "boot.json").write_text("{}")
    monkeypatch.setattr(export.shutil, "copytree", full)
    with pytest.raises(OutputError, match="No space left on device"):
        export_page(ball_path, folder, silent)
    assert (folder / "boot.json").read_text() == "{}"
    assert [p.name for p in tmp_path.iterdir() if p.name.startswith(".")] == []
