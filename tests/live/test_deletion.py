"""What a participant has had deleted stays deleted, whatever pages still bring of it."""

from __future__ import annotations

import json
import threading
from pathlib import Path
from typing import Any

import pytest
from starlette.testclient import TestClient

from tests.live.conftest import LIVE, Served
from tests.live.test_recordings import BEGIN, NAME, packed, told
from touchwarp.errors import OutputError
from touchwarp.live.messages import ChunkHeader, EndRecording
from touchwarp.live.recordings import DeletedRecordingError, RecordingStore
from touchwarp.live.tombstones import Tombstones

HEADER = ChunkHeader(recording=NAME, sequence=0, rows=4, warp="w")
LONG_AGO, SOON = "2020-01-01T00:00:00.000Z", "2999-01-01T00:00:00.000Z"


def test_chunks_that_come_after_the_deletion_bring_nothing_back(
    served: Served, client: TestClient, rows: Any
) -> None:
    """The page repeats beginning, chunks and end, as it does after a lost connection."""
    with client.websocket_connect(LIVE) as socket:
        socket.send_text(BEGIN.model_dump_json())
        socket.send_bytes(packed(0, rows(4, 3)))
        told(socket, "acknowledged")
        served.store.delete("P1")
        socket.send_bytes(packed(1, rows(4, 3)))
        assert told(socket, "deleted") == {"kind": "deleted", "recording": NAME}
    with client.websocket_connect(LIVE) as socket:
        socket.send_text(BEGIN.model_dump_json())
        assert told(socket, "deleted")["recording"] == NAME
        socket.send_bytes(packed(2, rows(4, 3)))
        assert told(socket, "deleted")["recording"] == NAME
        socket.send_text(EndRecording(recording=NAME, chunks=3).model_dump_json())
        assert told(socket, "deleted")["recording"] == NAME
    assert list(served.store.all()) == []
    assert not (served.store.folder / "P1").exists()


def test_without_the_note_of_it_they_would_be_there_again(served: Served, rows: Any) -> None:
    served.store.begin(BEGIN, "0")
    served.store.delete("P1")
    for note in served.store.folder.glob(".deleted/*"):
        note.unlink()
    served.store.begin(BEGIN, "0")
    served.store.append(HEADER, rows(4, 3))
    assert [r.participant for r in served.store.all()] == ["P1"]


def test_a_recording_that_the_server_never_heard_of_is_deleted_if_it_is_older(
    tmp_path: Path,
) -> None:
    """The page was away when it began, and when its participant's were deleted."""
    store = RecordingStore(tmp_path)
    store.begin(BEGIN, "0")
    store.delete("P1")
    other = BEGIN.model_copy(update={"recording": "fedcba9876543210", "started": LONG_AGO})
    with pytest.raises(DeletedRecordingError, match="was deleted with all of its participant's"):
        store.begin(other, "0")
    # of another participant, or begun since, it is taken
    store.begin(other.model_copy(update={"participant": "P2"}), "0")
    store.begin(other.model_copy(update={"recording": "aaaaaaaaaaaa", "started": SOON}), "0")
    store.begin(other.model_copy(update={"recording": "bbbbbbbbbbbb", "started": "today"}), "0")
    assert sorted(r.participant for r in store.all()) == ["P1", "P1", "P2"]


def test_a_second_deletion_remembers_the_first(tmp_path: Path) -> None:
    store = RecordingStore(tmp_path)
    for name in ("aaaaaaaaaaaa", "bbbbbbbbbbbb"):
        store.begin(BEGIN.model_copy(update={"recording": name, "started": SOON}), "0")
        store.delete("P1")
    (note,) = tmp_path.glob(".deleted/*")
    assert json.loads(note.read_text())["recordings"] == ["aaaaaaaaaaaa", "bbbbbbbbbbbb"]
    assert [path.name for path in tmp_path.iterdir()] == [".deleted"]
    tombstones = Tombstones(tmp_path)
    assert tombstones.hold("aaaaaaaaaaaa")
    assert not tombstones.hold("cccccccccccc")


def test_a_deletion_while_chunks_are_written_leaves_nothing(tmp_path: Path, rows: Any) -> None:
    store = RecordingStore(tmp_path)
    store.begin(BEGIN, "0")
    values = rows(4, 3)
    outcome: list[type[Exception]] = []
    written = threading.Event()

    def write() -> None:
        for sequence in range(100_000):
            try:
                store.append(HEADER.model_copy(update={"sequence": sequence}), values)
            except DeletedRecordingError:
                outcome.append(DeletedRecordingError)
                return
            except OutputError:
                continue  # its folder went while it wrote; the page tries again
            finally:
                if sequence == 20:
                    written.set()

    writer = threading.Thread(target=write)
    writer.start()
    assert written.wait(60)
    store.delete("P1")
    writer.join(60)
    assert outcome == [DeletedRecordingError]
    assert [path.name for path in tmp_path.iterdir()] == [".deleted"]
