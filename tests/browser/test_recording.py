"""Recordings as a person makes them: with consent, whatever becomes of the server; replayed."""

from __future__ import annotations

import functools
import http.server
import itertools
import json
import re
import threading
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
from playwright.sync_api import Page, WebSocketRoute, expect
from pyarrow import csv

import touchwarp as tw
from tests.browser.desk import at, expect_lost_server, open_page, wait_until, whole_warp
from tests.browser.server import Server
from touchwarp.live.export import export_page
from touchwarp.live.recordings import RecordingStore

Serve = Callable[[Path], Server]


def begin(page: Page, participant: str) -> None:
    page.locator("button[name=record]").click()
    page.locator("input[name=participant]").fill(participant)
    page.locator("input[name=consent]").check()
    page.locator("button[name=begin]").click()
    expect(page.locator(".recording")).to_contain_text(f"Recording {participant}")


def whole(page: Page, server: Server, participant: str) -> Path:
    """The file of a participant's only recording, once it has been joined."""
    found: list[Path] = []

    def joined() -> bool:
        found[:] = server.recordings.glob(f"{participant}/*/recording.parquet")
        return bool(found)

    wait_until(page, joined, "the recording is not whole on disk")
    (path,) = found
    return path


def test_nothing_is_recorded_without_consent(page: Page, ball_server: Server) -> None:
    before = sorted(ball_server.recordings.glob("*/*"))
    open_page(page, ball_server.url)
    page.locator("button[name=record]").click()
    page.locator("button[name=begin]").click()  # the box is not ticked
    expect(page.locator("dialog")).to_be_visible()
    page.get_by_text("Cancel").click()
    page.mouse.move(*at(page, ".pane.felt", 0.5, 0.5))
    page.wait_for_timeout(500)
    assert sorted(ball_server.recordings.glob("*/*")) == before


def test_a_recording_survives_the_server_s_death(
    page: Page, serve: Serve, ball: Path, screenshots: Path
) -> None:
    """Killed in the middle and back some frames later: every frame is on disk once."""
    expect_lost_server(page)
    server = serve(ball)
    open_page(page, server.url)
    whole_warp(page)
    begin(page, "P7")
    page.screenshot(path=screenshots / "recording.png")
    wander(page, 20)
    server.stop(at_once=True)
    expect(page.locator(".failure")).to_contain_text("server is gone")
    wander(page, 20)
    server.start()
    expect(page.locator(".failure")).to_have_count(0)
    wander(page, 12)
    page.locator("button[name=stop-recording]").click()
    recorded = rows(page)
    table = pq.read_table(whole(page, server, "P7"))
    times = table["time_ms"].to_numpy()
    assert len(times) == recorded > 50
    assert (np.diff(times) > 0).all(), "each frame once, in order"
    assert np.diff(table["chunk"].to_numpy()).max() == 1
    check_displayed(table, tw.load_scene(ball), tw.load_warp(ball.with_suffix(".warp")))


def test_a_recording_survives_a_reload(page: Page, ball_server: Server) -> None:
    """The page is reloaded in the middle: what was recorded until then is whole on disk."""
    open_page(page, ball_server.url)
    begin(page, "P11")
    wander(page, 21)
    recorded = rows(page)
    page.reload()
    page.wait_for_selector("body[data-ready]")
    expect(page.locator("button[name=record]")).to_be_visible()  # it does not go on by itself
    table = pq.read_table(whole(page, ball_server, "P11"))
    assert len(table) >= recorded > 20
    assert (np.diff(table["time_ms"].to_numpy()) > 0).all()


def test_a_page_that_is_closed_leaves_its_recording_to_the_others(
    page: Page, ball_server: Server
) -> None:
    """Another tab of the browser, open all the while, sends what is left and ends it."""
    open_page(page, ball_server.url)
    begin(page, "P12")
    wander(page, 11)
    other = page.context.new_page()
    open_page(other, ball_server.url)
    expect(other.locator("button[name=record]")).to_be_visible()
    wander(page, 11)
    recorded = rows(page)
    assert list(ball_server.recordings.glob("P12/*/recording.parquet")) == []
    page.close(run_before_unload=False)
    table = pq.read_table(whole(other, ball_server, "P12"))
    assert len(table) >= recorded > 20


def rows(page: Page) -> int:
    """How many have been recorded, as of the last change that the page tells."""
    return int(page.locator("#recording-slot").get_attribute("data-rows") or 0)


def wander(page: Page, frames: int) -> None:
    """The hand goes to and fro over the ball until so many more frames have been recorded."""
    most = rows(page) + frames
    places = itertools.cycle([*np.linspace(0.4, 0.6, 9), *np.linspace(0.6, 0.4, 9)])

    def recorded() -> bool:
        page.mouse.move(*at(page, ".pane.felt", next(places), 0.5))
        return rows(page) >= most

    wait_until(page, recorded, "too few frames are recorded")


def check_displayed(table: object, scene: tw.Scene, warp: tw.Warp) -> None:
    """What was recorded as displayed is what the warp says, at the fingertip's skin."""
    tip = "index-finger-tip"

    def column(name: str) -> np.ndarray:
        return np.asarray(table[name])  # type: ignore[index]

    real = np.stack([column(f"real.{tip}.{d}") for d in "xyz"], axis=1)
    shown = np.stack([column(f"displayed.{tip}.{d}") for d in "xyz"], axis=1)
    touching = column("contacts") > 0
    assert touching.any()
    moved = np.linalg.norm(shown - real, axis=1)[touching]
    assert moved.max() <= 1e-3 + np.abs(warp.displacement(surface_points(scene))).max() * 3**0.5
    assert moved.max() > 5e-3


def surface_points(scene: tw.Scene) -> np.ndarray:
    return np.asarray(scene.props[0].surface.vertices)


def test_a_deleted_participant_s_page_forgets_what_it_has(
    page: Page, serve: Serve, ball: Path
) -> None:
    """Deleted while the server is away: chunks that the page brings later bring nothing back."""
    page.expected_errors.append("WebSocket connection")  # type: ignore[attr-defined]
    server = serve(ball)
    open_page(page, server.url)
    begin(page, "P13")
    wander(page, 20)
    wait_until(page, (server.recordings / "P13").exists, "nothing is recorded")
    server.stop(at_once=True)
    expect(page.locator(".failure")).to_contain_text("server is gone")
    wander(page, 20)
    RecordingStore(server.recordings).delete("P13")
    server.start()
    expect(page.locator(".deleted")).to_contain_text("P13 was deleted on the server")
    expect(page.locator(".recording")).to_have_count(0)
    assert not (server.recordings / "P13").exists()
    wait_until(page, lambda: kept(page) == [], "the page keeps chunks of who was deleted")
    begin(page, "P14")  # another is recorded, and nothing of the first comes along
    wander(page, 10)
    page.locator("button[name=stop-recording]").click()
    expect(page.locator(".deleted")).to_have_count(0)
    wait_until(page, (server.recordings / "P14").exists, "P14 is not recorded")
    assert not (server.recordings / "P13").exists()


def kept(page: Page) -> list[str]:
    """Names of what the page keeps of recordings on its device."""
    names: list[str] = page.evaluate(
        "() => new Promise((done) => { indexedDB.open('touchwarp-recordings').onsuccess = (e) =>"
        " { const all = e.target.result.transaction('kept').objectStore('kept').getAllKeys();"
        " all.onsuccess = () => { e.target.result.close(); done(all.result); }; }; })"
    )
    return names


def test_a_recording_is_replayed(page: Page, ball_server: Server) -> None:
    open_page(page, ball_server.url)
    begin(page, "P8")
    wander(page, 11)
    page.locator("button[name=stop-recording]").click()
    page.locator("button[name=replay]").click()
    page.locator("dialog .listed button", has_text="P8").click()
    moment = page.locator("input[name=moment]")
    expect(moment).to_be_visible()
    expect(page.locator("button[name=play]")).to_have_text("Play")
    assert int(moment.input_value()) == int(moment.get_attribute("max") or 0) > 10
    expect(page.locator(".replayed")).to_have_text("P8")
    now, end = re.findall(r"\d+\.\d", page.locator("header output").inner_text())
    assert now == end != "0.0"
    page.locator("button[name=close-replay]").click()
    expect(page.locator("button[name=record]")).to_be_visible()


def test_a_recording_is_replayed_once_the_server_has_all_of_it(
    page: Page, ball_server: Server
) -> None:
    """Asked for at once after Stop, when its last second has not been delivered."""
    held: list[str | bytes] = []
    on_the_way: list[WebSocketRoute] = []
    holding = False

    def hold(socket: WebSocketRoute) -> None:
        on_the_way.append(socket.connect_to_server())
        socket.on_message(lambda said: held.append(said) if holding else on_the_way[0].send(said))

    page.route_web_socket("**/live", hold)
    open_page(page, ball_server.url)
    begin(page, "P10")
    wander(page, 11)
    holding = True
    page.locator("button[name=stop-recording]").click()
    page.locator("button[name=replay]").click()
    entry = page.locator("dialog .listed button", has_text="P10")
    expect(entry).to_contain_text("on its way to the server")
    expect(entry).to_be_disabled()
    holding = False
    for said in held:
        on_the_way[0].send(said)
    entry.click()
    moment = page.locator("input[name=moment]")
    expect(moment).to_be_visible()
    assert int(moment.get_attribute("max") or 0) > 10


def test_an_exported_page_keeps_recordings_on_the_device(
    page: Page, ball: Path, tmp_path: Path
) -> None:
    with exported(ball, tmp_path / "exported") as url:
        open_page(page, url)
        expect(page.locator("input[name=weight]")).to_be_disabled()
        page.locator("button[name=record]").click()
        expect(page.locator("dialog")).to_contain_text("stay on this device")
        page.locator("input[name=participant]").fill("P9")
        page.locator("input[name=consent]").check()
        page.locator("button[name=begin]").click()
        wander(page, 5)
        page.locator("button[name=stop-recording]").click()
        with page.expect_download() as download:
            page.locator("button[name=save-recording]").click()
        with zipfile.ZipFile(download.value.path()) as saved:
            table = csv.read_csv(saved.open("recording.csv"))
            about = json.loads(saved.read("about.json"))
        assert table.column_names[:2] == ["time_ms", "hand"]
        assert len(table) > 4
        assert about["participant"] == "P9"
        state = json.loads((tmp_path / "exported" / "boot.json").read_text())
        assert set(table["warp"].to_pylist()) == {state["warp"]["identity"]}
        page.locator("button[name=delete-recording]").click()
        page.locator("button[name=delete]").click()
        expect(page.locator("button[name=save-recording]")).to_have_count(0)
        page.reload()
        page.wait_for_selector("body[data-ready]")
        expect(page.locator("button[name=record]")).to_be_visible()
        expect(page.locator("button[name=save-recording]")).to_have_count(0)


def test_a_change_on_an_exported_page_is_live_and_known_to_be_unchecked(
    page: Page, ball: Path, tmp_path: Path
) -> None:
    with exported(ball, tmp_path / "exported") as url:
        open_page(page, url)
        whole_warp(page)
        expect(page.locator(".checks .check").first).to_be_visible()
        unchecked = page.get_by_text("Of the solved warp, before what was changed.")
        expect(unchecked).to_have_count(0)
        expect(page.get_by_text("Every change is live")).to_be_visible()
        shift = page.locator("input[name=translation-0]")
        shift.fill("20")
        shift.press("Enter")
        expect(page.locator(".exactness")).to_contain_text("Live warp")
        expect(unchecked).to_be_visible()


@contextmanager
def exported(path: Path, folder: Path) -> Iterator[str]:
    """The address of a scene's exported page, on a web host that knows nothing of touchwarp."""
    export_page(path, folder, lambda step, done: None)
    handler = functools.partial(QuietHandler, directory=str(folder))
    host = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    thread = threading.Thread(target=host.serve_forever)
    thread.start()
    try:
        yield f"http://127.0.0.1:{host.server_address[1]}/"
    finally:
        host.shutdown()
        host.server_close()
        thread.join()


class QuietHandler(http.server.SimpleHTTPRequestHandler):
    """Tells nothing on stderr."""

    def log_message(self, *told: object) -> None:
        """Nothing."""
