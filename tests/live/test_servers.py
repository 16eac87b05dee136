"""`touchwarp view` as a process that is ended by signals."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from touchwarp.live.messages import BeginRecording, ChunkHeader, EndRecording
from touchwarp.live.recordings import RecordingStore
from touchwarp.warp import TableWarp

RECORDING = "a-recording"


def begin(socket: ClientConnection) -> None:
    """Begin a recording of two columns."""
    asked = BeginRecording(
        recording=RECORDING,
        participant="P7",
        consent=True,
        started="2026-01-01T00:00:00Z",
        columns=("a", "b"),
        device="a test",
    )
    socket.send(asked.model_dump_json())


def send(socket: ClientConnection, sequence: int) -> None:
    """Send a chunk: three rows whose numbers are the chunk's."""
    header = ChunkHeader(recording=RECORDING, sequence=sequence, rows=3, warp="w").model_dump_json()
    head = len(header).to_bytes(4, "little") + header.encode()
    rows = np.full((3, 2), float(sequence))
    socket.send(head + b" " * (-len(head) % 8) + rows.tobytes())


def acknowledged(socket: ClientConnection) -> set[int]:
    """The chunk that the next message acknowledges, if it does."""
    told = json.loads(socket.recv(timeout=120))
    assert told["kind"] not in ("refused", "deleted")
    return {told["sequence"]} if told["kind"] == "acknowledged" else set()


@pytest.mark.parametrize("host", [[], ["--host", "127.0.0.2"]], ids=["here", "for-a-headset"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_impatient_signals_end_it_quietly_and_keep_the_recording(
    number: signal.Signals, host: list[str], ball_path: Path, ball_table: TableWarp, tmp_path: Path
) -> None:
    """One signal after another until it has ended, as of a key held down, while a page records."""
    ball_table.save(ball_path.with_suffix(".warp"))
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    command = [sys.executable, "-u", "-m", "touchwarp", "view", str(ball_path), "--no-browser"]
    process = subprocess.Popen(
        [*command, "--port", "0", *host],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        env=os.environ | {"XDG_DATA_HOME": str(tmp_path / "data"), "TMPDIR": str(temporary)},
    )
    assert process.stdout is not None
    address = re.search(r"localhost:\d+", process.stdout.readline())
    assert address is not None
    known: set[int] = set()
    with connect(f"ws://{address[0]}/live", open_timeout=120) as socket:
        begin(socket)
        for sequence in range(30):
            send(socket, sequence)
        while len(known) < 3:  # the others are on their way
            known |= acknowledged(socket)
        while process.poll() is None:
            process.send_signal(number)
            time.sleep(0.02)
        with contextlib.suppress(ConnectionClosed):
            while True:
                known |= acknowledged(socket)
    _, complaint = process.communicate()

    assert process.returncode in (128 + number, -number)  # a shell tells both as the first
    assert complaint in ("", "Error: Interrupted; nothing half-written was left behind.\n")
    assert list(temporary.iterdir()) == []

    store = RecordingStore(ball_path.parent / "recordings")
    (recording,) = store.all()
    kept = recording.chunks()
    assert known <= set(kept)
    assert {*recording.folder.iterdir()} == {*kept.values(), recording.folder / "about.json"}
    store.end(EndRecording(recording=RECORDING, chunks=len(known)))
    _, rows = recording.rows()
    np.testing.assert_array_equal(rows, np.repeat(sorted(kept), 6).reshape(-1, 2))
