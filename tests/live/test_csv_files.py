"""A recording as CSV is what was recorded, to the last bit."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pyarrow import csv

from tests.live.test_recordings import BEGIN, COLUMNS, NAME
from touchwarp.cli.main import main
from touchwarp.errors import StudyError
from touchwarp.live.csv_files import write_csv
from touchwarp.live.messages import ChunkHeader, EndRecording
from touchwarp.live.recordings import RecordingStore


@pytest.fixture
def store(tmp_path: Path) -> RecordingStore:
    """One recording, begun."""
    store = RecordingStore(tmp_path / "recordings")
    store.begin(BEGIN, "0")
    return store


def fill(store: RecordingStore, rows: Any) -> np.ndarray:
    values = np.concatenate([rows(5, 3, seed) for seed in range(2)])
    for sequence in range(2):
        header = ChunkHeader(
            recording=NAME, sequence=sequence, rows=5, warp="w", notes=(f"note {sequence}",)
        )
        store.append(header, values[5 * sequence : 5 * sequence + 5])
    store.end(EndRecording(recording=NAME, chunks=2))
    return values


def test_the_table_and_its_notes_are_written(
    store: RecordingStore, rows: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    values = fill(store, rows)
    arguments = ["--folder", str(store.folder), "-o", str(tmp_path / "tables")]
    assert main(["recordings", "export", "P1", *arguments]) == 0
    target = tmp_path / "tables" / NAME / "recording.csv"
    assert capsys.readouterr().out.strip() == str(target)
    table = csv.read_csv(target)
    assert table.column_names == [*COLUMNS, "warp", "chunk"]
    stored = np.stack([table[name].to_numpy() for name in COLUMNS], axis=1)
    np.testing.assert_array_equal(stored, values)
    assert table["warp"].to_pylist() == ["w"] * 10
    assert table["chunk"].to_pylist() == [0] * 5 + [1] * 5
    about = json.loads((target.parent / "about.json").read_text())
    assert about["participant"] == "P1"
    assert about["notes"] == [{"chunk": k, "text": f"note {k}"} for k in range(2)]


def test_what_has_not_ended_is_left_out(
    store: RecordingStore, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["--folder", str(store.folder), "-o", str(tmp_path / "tables")]
    assert main(["recordings", "export", "P1", *arguments]) == 0
    assert "has not ended and is left out" in capsys.readouterr().err
    assert main(["recordings", "export", "P2", *arguments]) == 2
    assert "No participant 'P2' has recordings" in capsys.readouterr().err
    with pytest.raises(StudyError, match="has not ended; end it on its page first"):
        write_csv(next(store.all()), tmp_path)
