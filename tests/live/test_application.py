"""The server gives out what was made for the page and nothing else, and no message breaks it."""

from __future__ import annotations

import http.client
import json
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import uvicorn
from starlette.testclient import TestClient

from tests.live.conftest import LIVE, Served
from touchwarp.errors import SolveError
from touchwarp.live import workbench
from touchwarp.live.addresses import listen
from touchwarp.warp import TableWarp, load_warp


def test_the_page_and_the_state(client: TestClient) -> None:
    assert "the page" in client.get("/").text
    state = client.get("/boot.json").json()
    assert state["name"] == "ball.toml"
    assert [prop["name"] for prop in state["props"]] == ["ball"]
    assert state["props"][0]["pose"]["position"] == [0, 0, 0]
    assert state["warp_current"]
    assert {mark["value"] for mark in state["marks"]} >= {52.0, 0.88, 1.07}


def test_the_warp_comes_as_float16_and_in_parts(
    client: TestClient, ball_table: TableWarp, tmp_path: Path
) -> None:
    told = client.get("/boot.json").json()["warp"]
    whole = client.get(told["url"]).content
    assert len(whole) == told["size"]
    path = tmp_path / "fetched.warp"
    path.write_bytes(whole)
    fetched = load_warp(path)
    assert isinstance(fetched, TableWarp)
    points = np.random.default_rng(0).uniform(-0.15, 0.15, (2000, 3))
    lost = np.linalg.norm(fetched(points) - ball_table(points), axis=1).max() * 1e3
    assert 0.0 < lost <= told["storage_error_mm"]
    part = client.get(told["url"], headers={"range": "bytes=100-199"})
    assert part.status_code == 206
    assert part.content == whole[100:200]


def test_a_surface_is_the_prop_s(client: TestClient) -> None:
    packed = client.get(client.get("/boot.json").json()["props"][0]["surface"]).content
    vertices, faces = np.frombuffer(packed, "<u4", 2)
    prop = np.frombuffer(packed, "<f4", 3 * vertices, 8).reshape(-1, 3)
    virtual = np.frombuffer(packed, "<f4", 3 * vertices, 8 + 12 * vertices).reshape(-1, 3)
    corners = np.frombuffer(packed, "<u4", 3 * faces, 8 + 24 * vertices)
    assert corners.max() == vertices - 1
    np.testing.assert_allclose(virtual - prop, np.tile([0.01, 0, 0], (vertices, 1)), atol=1e-7)
    assert np.linalg.norm(prop, axis=1).max() == pytest.approx(0.05, abs=1e-6)


def test_what_is_not_there_is_not_found(client: TestClient) -> None:
    for path in ("/tables/0.warp", "/surfaces/0.bin", "/ball.toml", "/recordings/P1/none"):
        assert client.get(path).status_code == 404


PATHS = [
    "/../scene/secret.txt",
    "/assets/../../scene/secret.txt",
    "/assets/..%2f..%2fscene%2fsecret.txt",
    "/assets/%2e%2e/%2e%2e/scene/secret.txt",
    "/assets//etc/passwd",
    "/tables/..%2f..%2fscene%2fsecret.txt",
    "/tables/../../scene/secret.txt",
    "/surfaces/..%2fsecret.txt",
    "/recordings/../scene",
    "/recordings/..%2f..%2fscene/secret.txt",
    "/secret.txt",
    "/scene/secret.txt",
]


def test_no_path_leads_out(served: Served) -> None:
    """Over a real connection, since clients tidy paths up before they ask."""
    listening = listen("127.0.0.1", 0)
    port = listening.getsockname()[1]
    served.app._local_port = port  # type: ignore[attr-defined]
    server = uvicorn.Server(uvicorn.Config(served.app, log_level="critical"))
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]})
    thread.start()
    try:
        deadline = time.monotonic() + 120
        while not server.started:
            assert time.monotonic() < deadline, "the server does not start"
            time.sleep(0.01)
        for path in PATHS:
            connection = http.client.HTTPConnection("127.0.0.1", port, timeout=120)
            connection.putrequest("GET", path, skip_host=False)
            connection.endheaders()
            answer = connection.getresponse()
            status, body = answer.status, answer.read()
            connection.close()
            assert status in (403, 404), path
            assert b"secret" not in body, path
    finally:
        server.should_exit = True
        thread.join(timeout=120)
        listening.close()


@pytest.mark.parametrize(
    ("sent", "told"),
    [
        ("no json", "does not fit"),
        ('{"kind": "dance"}', "does not fit"),
        ('{"kind": "change_scene", "goals": {"bowl": null}}', "does not fit"),
        (
            '{"kind": "change_scene", "goals": {"bowl": {"scale": [1, 1, 1], '
            '"rotation_deg": [0, 0, 0], "translation": [0, 0, 0]}}}',
            "no prop is named 'bowl'",
        ),
        ('{"kind": "end_recording", "recording": "12345678", "chunks": 1}', "begin it first"),
        (b"", "cut off"),
        (b"\xff\xff\xff\xff", "cut off"),
        (b"\x02\x00\x00\x00{}  ", "does not fit"),
    ],
)
def test_messages_that_make_no_sense_are_refused(
    client: TestClient, sent: str | bytes, told: str
) -> None:
    with client.websocket_connect(LIVE) as socket:
        assert socket.receive_json()["kind"] == "state"
        if isinstance(sent, bytes):
            socket.send_bytes(sent)
        else:
            socket.send_text(sent)
        answer = socket.receive_json()
        assert answer["kind"] == "refused"
        assert told in answer["reason"]
        socket.send_text(json.dumps({"kind": "save_scene"}))
        assert {socket.receive_json()["kind"] for _ in range(2)} == {"state", "saved"}


def test_a_change_is_told_to_every_page(client: TestClient) -> None:
    change = {"kind": "change_scene", "mismatch_weight": 4.0}
    with client.websocket_connect(LIVE) as one, client.websocket_connect(LIVE) as other:
        assert one.receive_json()["revision"] == other.receive_json()["revision"] == 0
        one.send_json(change)
        for socket in (one, other):
            state = socket.receive_json()
            assert (state["mismatch_weight"], state["unsaved"]) == (4.0, True)
            assert not state["warp_current"]


def test_the_page_that_asks_is_told_from_which_revision_on_it_has_its_change(
    client: TestClient,
) -> None:
    change = {"kind": "change_scene", "number": 7, "mismatch_weight": 4.0}
    with client.websocket_connect(LIVE) as socket:
        assert socket.receive_json()["revision"] == 0
        socket.send_json(change)
        assert socket.receive_json()["revision"] == 1
        assert socket.receive_json() == {"kind": "changed", "number": 7, "revision": 1}
        socket.send_json(change | {"number": 8})  # which changes nothing: no new state is told
        assert socket.receive_json() == {"kind": "changed", "number": 8, "revision": 1}


def test_a_page_that_comes_late_is_told_what_failed_and_how_far_the_work_is(
    client: TestClient, served: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, goes_on = threading.Event(), threading.Event()

    def fail(*given: object, **named: object) -> None:
        raise SolveError("no room")

    def pause(scene: object, warp: object, progress: Callable[[str, float], None]) -> None:
        progress("half of it", 0.5)
        begun.set()
        goes_on.wait(60)
        raise SolveError("ended")

    monkeypatch.setattr(workbench, "solve_bases", fail)
    monkeypatch.setattr(workbench, "check", pause)
    served.workbench.start()
    assert begun.wait(60)
    with client.websocket_connect(LIVE) as socket:
        assert socket.receive_json()["kind"] == "state"
        told = [socket.receive_json() for _ in range(2)]
    goes_on.set()
    assert told == [
        {"kind": "failed", "task": "bases", "reason": "no room"},
        {"kind": "progress", "task": "check", "step": "half of it", "done": 0.5},
    ]
