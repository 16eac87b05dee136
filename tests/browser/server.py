"""`touchwarp view` as a process, for a browser to open."""

from __future__ import annotations

import re
import subprocess
import sys
import time
import urllib.request
from pathlib import Path


class Server:
    """One running `touchwarp view`; it can be stopped and started again on the same port."""

    def __init__(self, path: Path, port: int = 0) -> None:
        self.path = path
        self.port = port
        self._process: subprocess.Popen[str] | None = None

    @property
    def url(self) -> str:
        """The page's address."""
        return f"http://localhost:{self.port}/"

    @property
    def recordings(self) -> Path:
        """The folder of its recordings."""
        return self.path.parent / "recordings"

    def start(self) -> None:
        """Start, and wait until it answers."""
        command = [sys.executable, "-u", "-m", "touchwarp", "view", str(self.path)]
        self._process = subprocess.Popen(
            [*command, "--no-browser", "--port", str(self.port)],
            stdout=subprocess.PIPE,
            text=True,
            encoding="utf-8",
        )
        assert self._process.stdout is not None
        told = re.search(r"http://localhost:(\d+)", self._process.stdout.readline())
        assert told is not None, "the server did not start"
        self.port = int(told[1])
        deadline = time.monotonic() + 120
        while True:
            try:
                urllib.request.urlopen(self.url, timeout=10).close()
                return
            except OSError:
                assert time.monotonic() < deadline, "the server does not answer"
                time.sleep(0.05)

    def stop(self, at_once: bool = False) -> None:
        """End it; `at_once` as a power cut would."""
        process, self._process = self._process, None
        if process is None:
            return
        assert process.stdout is not None
        process.stdout.close()
        if at_once:
            process.kill()
        else:
            process.terminate()
        process.wait(timeout=120)
