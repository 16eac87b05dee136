"""What was recorded is what was sent, to the last bit, whatever happened on the way."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from starlette.testclient import TestClient

from tests.live.conftest import LIVE, Served
from touchwarp.cli.main import main
from touchwarp.errors import StudyError
from touchwarp.live.messages import BeginRecording, ChunkHeader, EndRecording
from touchwarp.live.recordings import Recording, RecordingStore

NAME = "0123456789abcdef"
COLUMNS = ("time_ms", "x", "y")
BEGIN = BeginRecording(
    recording=NAME,
    participant="P1",
    consent=True,
    started="2030-01-01T00:00:00Z",
    columns=COLUMNS,
    device="test",
)


def packed(sequence: int, rows: np.ndarray, notes: tuple[str, ...] = ()) -> bytes:
    header = ChunkHeader(recording=NAME, sequence=sequence, rows=len(rows), warp="w", notes=notes)
    text = header.model_dump_json().encode()
    head = len(text).to_bytes(4, "little") + text
    return head + b"\0" * (-len(head) % 8) + rows.astype("<f8").tobytes()


def told(socket: Any, kind: str) -> Any:
    """The next message of a kind."""
    while (message := socket.receive_json())["kind"] != kind:
        assert message["kind"] != "refused", message
    return message


def test_a_dropped_connection_loses_nothing(served: Served, client: TestClient, rows: Any) -> None:
    """The page repeats all that it has no acknowledgement of; some of it had arrived."""
    sent = [rows(5, 3, seed) for seed in range(6)]
    with client.websocket_connect(LIVE) as socket:
        socket.send_text(BEGIN.model_dump_json())
        for sequence in (0, 1, 2):
            socket.send_bytes(packed(sequence, sent[sequence]))
        assert told(socket, "acknowledged")["sequence"] == 0
    with client.websocket_connect(LIVE) as socket:  # 1 and 2 may be there or not
        socket.send_text(BEGIN.model_dump_json())
        for sequence in (1, 2, 4, 3, 5):
            socket.send_bytes(packed(sequence, sent[sequence], (f"note {sequence}",)))
        got = {told(socket, "acknowledged")["sequence"] for _ in range(5)}
        assert got == {1, 2, 3, 4, 5}
        socket.send_text(EndRecording(recording=NAME, chunks=6).model_dump_json())
        told(socket, "finished")
    (recording,) = served.store.all()
    table = pq.read_table(recording.whole)
    stored = np.stack([table[name].to_numpy() for name in COLUMNS], axis=1)
    np.testing.assert_array_equal(stored, np.concatenate(sent))
    assert table["chunk"].to_pylist() == np.repeat(range(6), 5).tolist()
    assert [path.name for path in recording.folder.iterdir() if "0" in path.name] == []
    assert {"chunk": 3, "text": "note 3"} in recording.about["notes"]


def test_the_lossless_claim_rejects_single_precision(served: Served, rows: Any) -> None:
    served.store.begin(BEGIN, "0")
    values = rows(4, 3)
    header = ChunkHeader(recording=NAME, sequence=0, rows=4, warp="w")
    served.store.append(header, values.astype(np.float32).astype(np.float64))
    _, stored = next(served.store.all()).rows()
    assert not np.array_equal(stored, values, equal_nan=True)


def test_a_missing_chunk_is_asked_for(served: Served, rows: Any) -> None:
    served.store.begin(BEGIN, "0")
    header = ChunkHeader(recording=NAME, sequence=1, rows=4, warp="w")
    served.store.append(header, rows(4, 3))
    with pytest.raises(StudyError, match="lacks 1 of 2 chunks, the first is 0; send them again"):
        served.store.end(EndRecording(recording=NAME, chunks=2))
    served.store.append(header.model_copy(update={"sequence": 0}), rows(4, 3))
    served.store.end(EndRecording(recording=NAME, chunks=2))
    served.store.end(EndRecording(recording=NAME, chunks=2))  # once more changes nothing
    served.store.append(header, rows(4, 3))
    assert next(served.store.all()).ended


def test_notes_without_rows_are_kept(served: Served, client: TestClient, rows: Any) -> None:
    """What happened while no hand was there, such as a pause, is told in a chunk of its own."""
    sent = rows(4, 3, 0)
    with client.websocket_connect(LIVE) as socket:
        socket.send_text(BEGIN.model_dump_json())
        socket.send_bytes(packed(0, sent))
        socket.send_bytes(packed(1, sent[:0], ("paused",)))
        assert {told(socket, "acknowledged")["sequence"] for _ in range(2)} == {0, 1}
        socket.send_text(EndRecording(recording=NAME, chunks=2).model_dump_json())
        told(socket, "finished")
    (recording,) = served.store.all()
    assert recording.about["notes"] == [{"chunk": 1, "text": "paused"}]
    assert pq.read_table(recording.whole).num_rows == 4


def test_an_empty_recording_ends(served: Served) -> None:
    served.store.begin(BEGIN, "0")
    served.store.end(EndRecording(recording=NAME, chunks=0))
    names, values = next(served.store.all()).rows()
    assert (names, values.shape) == (list(COLUMNS), (0, 3))


def test_a_recording_is_replayed_as_it_was(served: Served, client: TestClient, rows: Any) -> None:
    served.store.begin(BEGIN, "0")
    values = rows(7, 3)
    served.store.append(ChunkHeader(recording=NAME, sequence=0, rows=7, warp="w"), values)
    (listed,) = client.get("/recordings.json").json()
    assert (listed["participant"], listed["ended"]) == ("P1", False)
    body = client.get(f"/recordings/P1/{NAME}").content
    length = int.from_bytes(body[:4], "little")
    head = json.loads(body[4 : 4 + length])
    assert head == {"columns": list(COLUMNS), "rows": 7}
    numbers = np.frombuffer(body, "<f8", offset=4 + length).reshape(7, 3)
    np.testing.assert_array_equal(numbers, values)


def test_a_recording_that_ends_while_it_is_read_is_read_whole(
    served: Served, rows: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    served.store.begin(BEGIN, "0")
    values = rows(8, 3)
    for sequence in (0, 1):
        header = ChunkHeader(recording=NAME, sequence=sequence, rows=4, warp="w")
        served.store.append(header, values[4 * sequence : 4 * sequence + 4])
    (recording,) = served.store.all()
    chunks = Recording.chunks

    def chunks_then_end(self: Recording) -> dict[int, Path]:
        found = chunks(self)
        monkeypatch.setattr(Recording, "chunks", chunks)
        served.store.end(EndRecording(recording=NAME, chunks=2))
        return found

    monkeypatch.setattr(Recording, "chunks", chunks_then_end)
    np.testing.assert_array_equal(recording.rows()[1], values)
    assert recording.ended


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"columns": ("x", "x")}, "need names, each another one"),
        ({"columns": ()}, "need names, each another one"),
        ({"columns": ("warp", "x")}, "columns of the server's own"),
    ],
)
def test_columns_need_names_of_their_own(served: Served, change: Any, message: str) -> None:
    with pytest.raises(StudyError, match=message):
        served.store.begin(BEGIN.model_copy(update=change), "0")


def test_a_name_is_begun_once(served: Served) -> None:
    served.store.begin(BEGIN, "0")
    served.store.begin(BEGIN, "0")
    with pytest.raises(StudyError, match="was begun before with other values"):
        served.store.begin(BEGIN.model_copy(update={"participant": "P2"}), "0")


def test_rows_that_do_not_fit_are_refused(served: Served, rows: Any) -> None:
    header = ChunkHeader(recording=NAME, sequence=0, rows=4, warp="w")
    with pytest.raises(StudyError, match="No recording 0123456789abcdef was begun"):
        served.store.append(header, rows(4, 3))
    served.store.begin(BEGIN, "0")
    with pytest.raises(StudyError, match="8 numbers came where 4 rows of 3 columns"):
        served.store.append(header, rows(4, 2))


def test_numbers_that_fill_no_rows_are_refused(client: TestClient, rows: Any) -> None:
    with client.websocket_connect(LIVE) as socket:
        socket.send_text(BEGIN.model_dump_json())
        socket.send_bytes(packed(0, rows(4, 3))[:-8])
        answer = [socket.receive_json() for _ in range(2)][-1]
        assert "does not fill 4 rows" in answer["reason"]


def test_one_command_deletes_one_participant(
    tmp_path: Path, rows: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "recordings"
    store = RecordingStore(folder)
    for participant, name in (("P1", "aaaaaaaa"), ("P1", "bbbbbbbb"), ("P2", "cccccccc")):
        store.begin(BEGIN.model_copy(update={"participant": participant, "recording": name}), "0")
    assert main(["recordings", "list", "--folder", str(folder)]) == 0
    assert capsys.readouterr().out.count("P1") == 4  # name and folder, twice
    assert main(["recordings", "delete", "P1", "--folder", str(folder)]) == 0
    assert "Deleted 2 recordings of P1" in capsys.readouterr().out
    assert [r.participant for r in store.all()] == ["P2"]
    assert not (folder / "P1").exists()


def test_listing_where_there_is_nothing_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["recordings", "list", "--folder", str(tmp_path)]) == 0
    told = capsys.readouterr()
    assert told.out == ""
    assert f"No recordings in {tmp_path}" in told.err


@pytest.mark.parametrize("name", ["P9", "..", "../scene", "P*", ""])
def test_nothing_else_is_ever_deleted(
    tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "recordings"
    RecordingStore(folder).begin(BEGIN, "0")
    (tmp_path / "scene").mkdir()
    (tmp_path / "scene" / "about.json").write_text("{}")
    assert main(["recordings", "delete", name, "--folder", str(folder)]) == 2
    assert "has recordings in" in capsys.readouterr().err
    assert (tmp_path / "scene").exists()
    assert len(list(RecordingStore(folder).all())) == 1


def test_deleting_where_there_is_nothing_says_so(tmp_path: Path) -> None:
    with pytest.raises(StudyError, match="there are none at all"):
        RecordingStore(tmp_path).delete("P1")
