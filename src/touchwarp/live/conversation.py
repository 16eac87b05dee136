"""The WebSocket: what pages ask, what they are told, and recordings on their way."""

from __future__ import annotations

import asyncio
import logging
from importlib.metadata import version

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError
from starlette.concurrency import run_in_threadpool
from starlette.types import Message
from starlette.websockets import WebSocket, WebSocketDisconnect

from touchwarp.errors import StudyError, TouchwarpError
from touchwarp.live.access import MOST_BYTES
from touchwarp.live.messages import (
    FROM_PAGE,
    Acknowledged,
    Asked,
    BeginRecording,
    Changed,
    ChangeScene,
    ChunkHeader,
    Deleted,
    EndRecording,
    Finished,
    FromPage,
    FromServer,
    Refused,
    SaveScene,
)
from touchwarp.live.recordings import DeletedRecordingError, RecordingStore
from touchwarp.live.workbench import Workbench

_log = logging.getLogger("touchwarp")


class Hub:
    """All conversations of one server; `tell` may be called from any thread."""

    def __init__(self) -> None:
        self._workbench: Workbench | None = None
        self._recordings: RecordingStore | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._waiting: set[asyncio.Queue[FromServer]] = set()

    def serve(self, workbench: Workbench, recordings: RecordingStore | None) -> None:
        """What the conversations are about."""
        self._workbench, self._recordings = workbench, recordings

    def tell(self, message: FromServer) -> None:
        """Tell every page."""
        loop = self._loop
        if loop is not None and not loop.is_closed():
            loop.call_soon_threadsafe(self._spread, message)

    def _spread(self, message: FromServer) -> None:
        for queue in self._waiting:
            queue.put_nowait(message)

    async def talk(self, socket: WebSocket) -> None:
        """One conversation, from its beginning to its end."""
        assert self._workbench is not None
        await socket.accept()
        self._loop = asyncio.get_running_loop()
        queue: asyncio.Queue[FromServer] = asyncio.Queue()
        self._waiting.add(queue)
        queue.put_nowait(self._workbench.state)
        for news in self._workbench.news:
            queue.put_nowait(news)
        sender = asyncio.create_task(_send_all(queue, socket))
        try:
            while True:
                message = await socket.receive()
                if message["type"] == "websocket.disconnect":
                    break
                answer = await run_in_threadpool(self._answer, message)
                if answer is not None:
                    queue.put_nowait(answer)
        except WebSocketDisconnect:
            pass
        finally:
            self._waiting.discard(queue)
            if not self._waiting:
                self._loop = None
            sender.cancel()

    def _answer(self, message: Message) -> FromServer | None:
        """Carry out one message; a refusal for whatever cannot be."""
        about: Asked | None = None
        try:
            if message.get("bytes") is not None:
                about = "chunk"
                return self._keep(message["bytes"])
            text = message.get("text") or ""
            if len(text) > MOST_BYTES:
                return Refused(about=None, reason="The message is too long.")
            asked = FROM_PAGE.validate_json(text)
            about = asked.kind
            return self._carry_out(asked)
        except ValidationError as error:
            first = error.errors(include_url=False, include_input=False)[0]
            place = ".".join(str(part) for part in first["loc"])
            reason = f"The message does not fit: {place}: {first['msg']}."[:500]
            return Refused(about=about, reason=reason)
        except TouchwarpError as error:
            return Refused(about=about, reason=str(error))

    def _carry_out(self, message: FromPage) -> FromServer | None:
        assert self._workbench is not None
        match message:
            case ChangeScene():
                revision = self._workbench.change(message)
                return Changed(number=message.number, revision=revision)
            case SaveScene():
                self._workbench.save()
            case BeginRecording() | EndRecording():
                try:
                    return self._record(message)
                except DeletedRecordingError:
                    return Deleted(recording=message.recording)
        return None

    def _record(self, message: BeginRecording | EndRecording) -> Finished | None:
        if isinstance(message, EndRecording):
            path = self._store().end(message)
            return Finished(recording=message.recording, path=str(path.parent))
        self._store().begin(message, version("touchwarp"))
        _log.info("recording %s of %s begins", message.recording, message.participant)
        return None

    def _keep(self, data: bytes) -> Acknowledged | Deleted:
        header, rows = read_chunk(data)
        try:
            self._store().append(header, rows)
        except DeletedRecordingError:
            return Deleted(recording=header.recording)
        return Acknowledged(recording=header.recording, sequence=header.sequence)

    def _store(self) -> RecordingStore:
        if self._recordings is None:
            raise StudyError("This server keeps no recordings; save them on the device.")
        return self._recordings


def read_chunk(data: bytes) -> tuple[ChunkHeader, NDArray[np.float64]]:
    """A binary message of the page's: see `ChunkHeader`.

    Raises:
        StudyError: it is cut off, or its numbers do not fill its rows.
        ValidationError: the header does not fit.
    """
    length = int.from_bytes(data[:4], "little")
    start = (4 + length + 7) // 8 * 8
    if len(data) < 4 or start > len(data):
        raise StudyError("A chunk of a recording was cut off; send it again.")
    header = ChunkHeader.model_validate_json(data[4 : 4 + length])
    numbers = len(data) - start
    if numbers % 8 or (header.rows and numbers // 8 % header.rows) or (numbers and not header.rows):
        raise StudyError(
            f"A chunk of {numbers} bytes does not fill {header.rows} rows of numbers; "
            "send it again."
        )
    rows = np.frombuffer(data, "<f8", offset=start)
    return header, rows.reshape(header.rows, -1) if header.rows else rows.reshape(0, 0)


async def _send_all(queue: asyncio.Queue[FromServer], socket: WebSocket) -> None:
    """Send what waits; of several states or steps only the last, so a slow page stays current."""
    while True:
        waiting = [await queue.get()]
        while not queue.empty():
            waiting.append(queue.get_nowait())
        for i, message in enumerate(waiting):
            later = {other.kind for other in waiting[i + 1 :]}
            if message.kind not in ("state", "progress") or message.kind not in later:
                await socket.send_text(message.model_dump_json())
