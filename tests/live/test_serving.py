"""`touchwarp view` as a process: what it prints, how it ends."""

from __future__ import annotations

import os
import re
import signal
import ssl
import subprocess
import sys
import time
import urllib.error
import urllib.request
from http.client import HTTPConnection
from pathlib import Path

import pytest

from touchwarp.errors import LiveError
from touchwarp.live import serving
from touchwarp.live.access import Invitation
from touchwarp.live.https import HttpsIdentity
from touchwarp.live.serving import built_page, invitation_text
from touchwarp.warp import TableWarp


def test_it_serves_this_machine_and_a_headset_and_ends_by_ctrl_c(
    ball_path: Path,
    ball_table: TableWarp,
    tmp_path: Path,
) -> None:
    ball_table.save(ball_path.with_suffix(".warp"))
    command = [sys.executable, "-m", "touchwarp", "view", str(ball_path), "--no-browser"]
    process = subprocess.Popen(
        [*command, "--port", "0", "--host", "127.0.0.2"],
        stdout=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        env=os.environ | {"XDG_DATA_HOME": str(tmp_path), "PYTHONUNBUFFERED": "1"},
    )
    try:
        assert process.stdout is not None
        local = re.search(r"http://localhost:\d+", process.stdout.readline())
        assert local is not None
        text = ""
        while "adb reverse" not in text:
            line = process.stdout.readline()
            assert line, "it has ended"
            text += line
        link = re.search(r"https://127\.0\.0\.2:\d+/enter\?token=\S+", text)
        assert link is not None
        with urllib.request.urlopen(f"{local[0]}/boot.json", timeout=120) as answer:
            assert b"ball.toml" in answer.read()
        anyone = ssl.create_default_context()
        anyone.check_hostname, anyone.verify_mode = False, ssl.CERT_NONE
        with pytest.raises(urllib.error.HTTPError, match="401") as refused:
            urllib.request.urlopen(
                link[0].replace("/enter?token=", "/boot.json?"), context=anyone, timeout=120
            )
        refused.value.close()
        keeping = urllib.request.build_opener(
            urllib.request.HTTPSHandler(context=anyone), urllib.request.HTTPCookieProcessor()
        )
        with keeping.open(link[0], timeout=120) as answer:
            assert answer.url.endswith("/")
    finally:
        process.send_signal(signal.SIGINT)
        process.stdout.close()
        assert process.wait(timeout=120) == 0


def test_a_page_that_is_not_built_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(serving, "PAGE", tmp_path)
    with pytest.raises(LiveError, match="The page is not built"):
        built_page()


def test_the_invitation_tells_every_way_in() -> None:
    invitation = Invitation()
    identity = HttpsIdentity(Path("a"), Path("b"), "AB:CD")
    text = invitation_text("192.0.2.7:8601", invitation, identity, 8600)
    for part in (
        f"https://192.0.2.7:8601/enter?token={invitation.token}",
        invitation.code,
        "AB:CD",
        "adb reverse tcp:8600 tcp:8600",
        "█",
    ):
        assert part in text


def test_the_address_is_told_and_the_page_served_before_what_takes_its_time_is_loaded() -> None:
    slow = "{'numba', 'scipy', 'trimesh', 'numpy'}"
    begun = "import sys; from touchwarp.live import reception, servers; servers.Server(0, 0)"
    told = f"{begun}; print({slow} & set(sys.modules))"
    run = subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "set()"


def test_a_scene_that_cannot_be_opened_ends_it_with_the_reason(tmp_path: Path) -> None:
    path = tmp_path / "broken.toml"
    path.write_text("[[prop]]\n")
    command = [sys.executable, "-m", "touchwarp", "view", str(path), "--no-browser", "--port", "0"]
    run = subprocess.run(command, capture_output=True, text=True, encoding="utf-8", timeout=240)
    assert run.returncode == 2
    assert "broken.toml is at http://localhost:" in run.stdout
    assert "broken.toml" in run.stderr


def test_ctrl_c_ends_it_while_the_scene_is_being_opened(tmp_path: Path) -> None:
    """The twin of a thread that is waited for: one that never ends."""
    never = (
        "import sys, threading\n"
        "from pathlib import Path\n"
        "from touchwarp.cli.main import main\n"
        "from touchwarp.live import serving\n"
        "serving._Opening._open = lambda self: threading.Event().wait()\n"
        f"sys.exit(main(['view', {str(tmp_path)!r}, '--no-browser', '--port', '0']))\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-u", "-c", never],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
    )
    assert process.stdout is not None
    address = re.search(r"localhost:(\d+)", process.stdout.readline())
    assert address is not None
    with urllib.request.urlopen(f"http://{address[0]}", timeout=120) as answer:
        assert b"touchwarp" in answer.read()
    waiting = HTTPConnection("localhost", int(address[1]), timeout=120)
    waiting.request("GET", "/boot.json")  # what a page asks first, and waits for
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    answered = waiting.getresponse()
    assert (answered.status, answered.read()) == (503, b"It was ended before the scene was open.")
    waiting.close()
    assert process.communicate(timeout=120)[1] == ""
    assert process.returncode == 0
