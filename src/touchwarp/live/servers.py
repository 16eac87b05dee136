"""Servers of one process that run and end together: by Ctrl-C, by being terminated, by a failure.

uvicorn's own handlers of signals are left out: each server would take a signal for itself, and
raise it once more at its end, into what the others are still putting away.
"""

from __future__ import annotations

import asyncio
import contextlib
import signal
import socket
import threading
from collections.abc import Iterator
from types import FrameType
from typing import TYPE_CHECKING

import uvicorn

from touchwarp.live.access import MOST_BYTES

if TYPE_CHECKING:
    from touchwarp.live.https import HttpsIdentity


class Server(uvicorn.Server):
    """One that leaves signals alone.

    Args:
        app: what it serves.
        listening: where.
        identity: its certificate; without one it speaks plain HTTP.
    """

    def __init__(
        self, app: object, listening: socket.socket, identity: HttpsIdentity | None = None
    ) -> None:
        super().__init__(
            uvicorn.Config(
                app,  # type: ignore[arg-type]
                log_level="warning",
                ws="websockets-sansio",
                ws_max_size=MOST_BYTES,
                lifespan="off",
                server_header=False,
                ssl_certfile=None if identity is None else identity.certificate,
                ssl_keyfile=None if identity is None else identity.key,
                timeout_graceful_shutdown=2,
            )
        )
        self.listening = listening

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Signals are for `Servers`."""
        yield


class Servers:
    """All servers of this process; when one ends, all do."""

    def __init__(self, *servers: Server) -> None:
        self._servers = servers
        self._signals: list[int] = []

    @property
    def exit_code(self) -> int:
        """0 after a Ctrl-C, which is the way to end them; 130 after several; 143 if terminated."""
        if signal.SIGTERM in self._signals:
            return 128 + signal.SIGTERM
        return 128 + signal.SIGINT if len(self._signals) > 1 else 0

    @contextlib.contextmanager
    def ended_by_signals(self) -> Iterator[None]:
        """Within, SIGINT and SIGTERM end them, and do not interrupt what is put away afterwards.

        Another signal changes the exit code alone: what is being written is waited for, two seconds
        at most. (Python gives signals to the main thread only: in another one nothing changes.)
        """
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        before = {
            number: signal.signal(number, self._note) for number in (signal.SIGINT, signal.SIGTERM)
        }
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    def _note(self, number: int, frame: FrameType | None) -> None:
        self._signals.append(number)
        self.end()

    def end(self) -> None:
        """Let all of them end."""
        for server in self._servers:
            server.should_exit = True

    async def started(self) -> None:
        """Wait until all of them serve."""
        while not all(server.started for server in self._servers):
            await asyncio.sleep(0.01)

    async def ending(self) -> None:
        """Wait until they are to end; what is being answered is waited for after that."""
        while not any(server.should_exit for server in self._servers):
            await asyncio.sleep(0.05)

    async def run(self) -> None:
        """Serve until one of them ends."""

        async def run(server: Server) -> None:
            try:
                await server.serve(sockets=[server.listening])
            finally:
                self.end()

        await asyncio.gather(*(run(server) for server in self._servers))
