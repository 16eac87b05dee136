"""Recordings made in the headset: through a server's death, and on a page that has no server."""

from __future__ import annotations

import base64
import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
from playwright.sync_api import Page

import touchwarp as tw
from tests.browser.desk import wait_until
from tests.browser.headset import RADIUS, Headset
from tests.browser.person import Person, RealProp, touchable
from tests.browser.server import Server
from tests.browser.test_recording import begin, exported
from touchwarp.live.conversation import read_chunk
from touchwarp.live.csv_files import write_csv
from touchwarp.live.messages import BeginRecording, EndRecording
from touchwarp.live.recordings import RecordingStore

GOAL = np.diag([1.2, 1.2, 0.6, 1.0])
GOAL[0, 3] = 0.015
TIP = "[...touchwarpProbe.displacement.displayed[1].subarray(16 * 9 + 12, 16 * 9 + 15)]"


def test_a_recording_in_the_headset_survives_the_server_s_death(
    page: Page, serve: Callable[[Path], Server], mug: Path
) -> None:
    """Killed while the prop is touched, and back: each frame once, and every note."""
    page.expected_errors.append("WebSocket connection")  # type: ignore[attr-defined]
    server = serve(mug)
    page.set_viewport_size({"width": 1280, "height": 640})
    headset = Headset(page)
    headset.open(server.url)
    begin(page, "P31")
    headset.enter()
    person = Person(headset, RealProp(tw.load_scene(mug).props[0]))
    person.arrive()
    hands = person.touching(touchable(person.prop, 100, seed=4))
    headset.step([{"right": hand} for hand in hands])
    server.stop(at_once=True)
    shown = headset.step([{"right": hand} for hand in hands], TIP)
    assert headset.probe("it.room.panel.content.recording") == "P31"
    assert headset.probe("it.displacement.weight") == 1  # the warp is on the device
    headset.poke("Pause")
    headset.poke("Resume")
    server.start()
    person.rest(1.5)
    headset.poke("Stop rec.")
    recorded = headset.probe("it.context.recorder.status.rows")
    (folder,) = (server.recordings / "P31").iterdir()
    wait_until(page, (folder / "recording.parquet").exists, "the recording is not whole on disk")
    table = pq.read_table(folder / "recording.parquet")
    assert len(table) == recorded
    right = table["hand"].to_numpy() == 1
    assert (np.diff(table["time_ms"].to_numpy()[right]) > 0).all()
    assert np.diff(table["chunk"].to_numpy()).max() == 1
    # what was displayed while the server was dead is there, frame by frame
    tips = np.stack(
        [table[f"displayed.index-finger-tip.{d}"].to_numpy()[right] for d in "xyz"], axis=1
    )
    distance = np.linalg.norm(np.array(shown)[:, None] - tips[None], axis=2)
    assert distance.min(axis=1).max() < 1e-6
    told = [note["text"] for note in json.loads((folder / "about.json").read_text())["notes"]]
    for event in ("verified: immersed", "pause: immersed", "resume: immersed"):
        assert any(event in text for text in told)


KEPT = """() => new Promise((done) => {
  indexedDB.open("touchwarp-recordings").onsuccess = ({ target: { result: database } }) => {
    const store = database.transaction("kept").objectStore("kept");
    const [names, values] = [store.getAllKeys(), store.getAll()];
    values.onsuccess = () => done(names.result.map((name, k) => {
      const { bytes } = values.result[k];
      const letters = bytes && [...new Uint8Array(bytes)].map((byte) => String.fromCharCode(byte));
      const text = letters && btoa(letters.join(""));
      return [name, text ?? values.result[k]];
    }));
  };
})"""


def test_an_exported_page_is_touched_and_saves_what_a_server_would(
    page: Page, mug: Path, tmp_path: Path
) -> None:
    """In the headset, without a server: rows and notes equal those of the server's files."""
    with exported(mug, tmp_path / "exported") as url:
        page.set_viewport_size({"width": 1280, "height": 640})
        headset = Headset(page)
        headset.open(url)
        begin(page, "P32")
        headset.enter()
        person = Person(headset, RealProp(tw.load_scene(mug).props[0]))
        person.arrive()
        hands = person.touching(touchable(person.prop, 20, seed=5))
        tips = np.array(headset.step([{"right": hand} for hand in hands], TIP))
        gaps = np.abs(person.prop.distance(person.prop.to_scene(tips), GOAL) - RADIUS)
        assert gaps.max() < 1e-3
        headset.leave()
        page.locator("button[name=stop-recording]").click()
        with page.expect_download() as download:
            page.locator("button[name=save-recording]").click()
        with zipfile.ZipFile(download.value.path()) as saved:
            saved.extractall(tmp_path / "page")
        kept = dict(page.evaluate(KEPT))
    state = json.loads((tmp_path / "exported" / "boot.json").read_text())
    target = server_files(kept, state["version"], tmp_path)
    assert (tmp_path / "page" / "recording.csv").read_bytes() == target.read_bytes()
    about = json.loads((tmp_path / "page" / "about.json").read_text())
    assert about == json.loads((target.parent / "about.json").read_text())
    assert any("verified: immersed" in note["text"] for note in about["notes"])


def server_files(kept: dict[str, Any], version: str, folder: Path) -> Path:
    """What a server writes as CSV of the chunks that a page has kept."""
    store = RecordingStore(folder / "recordings")
    (begun,) = (value for name, value in kept.items() if name.startswith("begin/"))
    store.begin(BeginRecording.model_validate(begun), version)
    chunks = sorted(name for name in kept if name.startswith("chunk/"))
    for name in chunks:
        store.append(*read_chunk(base64.b64decode(kept[name])))
    store.end(EndRecording(recording=begun["recording"], chunks=len(chunks)))
    return write_csv(next(store.all()), folder / "server")
