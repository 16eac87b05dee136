"""Desk mode as a person uses it: look, probe, drag, change λ, save, reload, record."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from playwright.sync_api import Page, expect

import touchwarp as tw
from tests.browser.server import Server

Serve = Callable[[Path], Server]
LONG = 120_000
"""ms; for what has to be solved on a busy machine."""


def open_page(page: Page, url: str) -> None:
    page.goto(url)
    page.wait_for_selector("body[data-ready]")


def at(page: Page, selector: str, x: float, y: float) -> tuple[float, float]:
    """The place on the screen at shares x, y of an element."""
    box = page.locator(selector).bounding_box()
    assert box is not None
    return box["x"] + x * box["width"], box["y"] + y * box["height"]


def reading(page: Page) -> str:
    return page.locator("#reading").inner_text()


def test_it_shows_the_scene_and_how_exact_it_is(
    page: Page, serve: Serve, ball: Path, screenshots: Path
) -> None:
    open_page(page, serve(ball).url)
    expect(page.locator("#scene-name")).to_have_text("ball.toml")
    exactness = page.locator(".exactness")
    expect(exactness).to_contain_text("as float16, which adds")
    levels = re.search(r"(\d+) of (\d+) levels", exactness.inner_text())
    assert levels is not None
    expect(exactness).to_contain_text(f"{levels[2]} of {levels[2]} levels")
    expect(page.locator(".checks .check").first).to_be_visible(timeout=LONG)
    page.screenshot(path=screenshots / "desk.png")


def test_the_picture_is_not_empty(page: Page, serve: Serve, ball: Path, screenshots: Path) -> None:
    """The felt pane holds colours of the mismatch scale, the seen one the virtual object's blue."""
    open_page(page, serve(ball).url)
    page.wait_for_timeout(300)
    felt = colours(page, ".pane.felt")
    seen = colours(page, ".pane.seen")
    assert is_green(felt).mean() > 0.02
    assert is_blue(seen).mean() > 0.02
    assert is_blue(felt).mean() < 0.005
    page.get_by_text("Plain", exact=True).click()
    page.wait_for_timeout(500)
    assert is_green(colours(page, ".pane.felt")).mean() < 0.005


def colours(page: Page, selector: str) -> np.ndarray:
    """(n, 3) 0…255: every pixel of an element."""
    import io

    from matplotlib.image import imread

    picture = imread(io.BytesIO(page.locator(selector).screenshot()), format="png")
    return (255 * picture[..., :3]).reshape(-1, 3)


def is_green(rgb: np.ndarray) -> np.ndarray:
    return (rgb[:, 1] > rgb[:, 0] + 40) & (rgb[:, 1] > rgb[:, 2] + 10)


def is_blue(rgb: np.ndarray) -> np.ndarray:
    return (rgb[:, 2] > rgb[:, 0] + 60) & (rgb[:, 2] > rgb[:, 1] + 20)


def test_the_probe_touches_and_tells_the_mismatch(page: Page, serve: Serve, ball: Path) -> None:
    open_page(page, serve(ball).url)
    page.mouse.move(*at(page, ".pane.felt", 0.5, 0.5))
    expect(page.locator("#reading")).to_contain_text("touching the ball")
    told = float(re.findall(r"([\d.]+) mm away", reading(page))[0])
    # scale and shift move the ball's surface by 7 to 28 mm, depending on where it is touched
    assert 5.0 < told < 30.0
    page.mouse.move(*at(page, ".pane.felt", 0.5, 0.05))
    expect(page.locator("#reading")).to_contain_text("in the air")
    page.mouse.move(*at(page, ".pane.seen", 0.5, 0.5))
    expect(page.locator("#reading")).to_contain_text("touching the ball")


def test_the_slice_is_dragged(page: Page, serve: Serve, ball: Path, screenshots: Path) -> None:
    open_page(page, serve(ball).url)
    for mode in ("Arrows", "Lattice"):
        page.get_by_text(mode, exact=True).click()
        expect(page.locator("label.slider output").first).to_have_text(re.compile(r"y = -?0 mm"))
        page.wait_for_timeout(300)
        page.screenshot(path=screenshots / f"slice-{mode.lower()}.png")
    page.locator("input[name=slice-share]").fill("0.8")
    expect(page.locator("label.slider output").first).not_to_have_text(re.compile(r"y = -?0 mm"))


def test_the_gizmo_changes_the_warp_at_once_and_the_server_follows(
    page: Page, serve: Serve, ball: Path, screenshots: Path
) -> None:
    server = serve(ball)
    open_page(page, server.url)
    expect(page.get_by_text("Every change is live")).to_be_visible(timeout=LONG)
    shift = page.locator("input[name=translation-0]")
    expect(shift).to_have_value("15")
    drag_red_arrow(page, 60)
    moved = float(shift.input_value())
    assert moved > 18.0
    exactness = page.locator(".exactness")
    expect(exactness).to_have_attribute("data-exact", "true", timeout=LONG)
    page.locator("button[name=save]").click()
    expect(page.locator(".note")).to_have_text("Saved to ball.toml.")
    page.screenshot(path=screenshots / "moved.png")
    text = ball.read_text()
    assert "# to the right" in text
    saved = tomllib.loads(text)["prop"][0]["goal"]["translation"]
    assert saved[0] * 1e3 == pytest.approx(moved, abs=0.06)

    page.expected_errors.append("WebSocket connection")  # type: ignore[attr-defined]
    server.stop()
    server.start()
    page.reload()
    page.wait_for_selector("body[data-ready]")
    expect(shift).to_have_value(str(moved).removesuffix(".0"))


def drag_red_arrow(page: Page, by: float) -> None:
    """Find the gizmo's x arrow by its colour and drag it to the right."""
    page.mouse.move(*at(page, ".pane.seen", 0.5, 0.02))
    page.wait_for_timeout(300)
    box = page.locator(".pane.seen").bounding_box()
    assert box is not None
    import io

    from matplotlib.image import imread

    picture = imread(io.BytesIO(page.locator(".pane.seen").screenshot()), format="png")
    red = (picture[..., 0] > 0.75) & (picture[..., 1] < 0.25) & (picture[..., 2] < 0.25)
    rows, columns = np.nonzero(red)
    assert len(columns), "no gizmo is to be seen"
    tip = columns > columns.max() - 8
    x, y = box["x"] + columns[tip].mean(), box["y"] + rows[tip].mean()
    page.mouse.move(x, y)
    page.mouse.down()
    for step in range(1, 7):
        page.mouse.move(x + by * step / 6, y + 0.2 * by * step / 6)
    shown = page.locator(".exactness")
    expect(shown).to_have_attribute("data-exact", "false")  # live, before any solve
    page.mouse.up()


def test_numbers_can_be_typed(page: Page, serve: Serve, ball: Path) -> None:
    open_page(page, serve(ball).url)
    page.locator("input[name=rotation_deg-2]").fill("30")
    page.locator("input[name=rotation_deg-2]").press("Enter")
    button = page.locator("button[name=save]")
    expect(button).to_be_enabled()
    button.click()
    expect(page.locator(".note")).to_be_visible()
    assert tomllib.loads(ball.read_text())["prop"][0]["goal"]["rotation_deg"] == [0, 0, 30]


def test_locality_is_solved_on_the_server_with_progress(
    page: Page, serve: Serve, ball: Path
) -> None:
    open_page(page, serve(ball).url)
    page.locator("input[name=weight]").fill("0.6")
    expect(page.locator(".task").first).to_be_visible()
    exactness = page.locator(".exactness")
    expect(exactness).to_have_attribute("data-exact", "true", timeout=LONG)
    page.locator("button[name=save]").click()
    expect(page.locator(".note")).to_be_visible()
    weight = tomllib.loads(ball.read_text())["objective"]["mismatch_weight"]
    assert weight == pytest.approx(0.1 * 10_000**0.6, rel=0.05)


def test_a_line_of_the_certificate_leads_to_its_place(
    page: Page, serve: Serve, ball: Path, screenshots: Path
) -> None:
    open_page(page, serve(ball).url)
    line = page.locator("[data-check='contact.max']")
    expect(line).to_be_enabled(timeout=LONG)
    before = is_pink(colours(page, ".pane.felt")).mean()
    line.click()
    page.wait_for_timeout(1200)
    page.screenshot(path=screenshots / "place.png")
    assert before == 0.0
    assert is_pink(colours(page, ".pane.felt")).mean() > 1e-4


def is_pink(rgb: np.ndarray) -> np.ndarray:
    return (rgb[:, 0] > 150) & (rgb[:, 1] < 100) & (rgb[:, 2] > 100)


def test_a_scene_that_cannot_be_is_refused_in_words(page: Page, serve: Serve, ball: Path) -> None:
    open_page(page, serve(ball).url)
    page.locator("input[name=translation-2]").fill("-300")
    page.locator("input[name=translation-2]").press("Enter")
    expect(page.locator(".failure").first).to_contain_text(
        "must lie inside the outer boundary", timeout=LONG
    )


def test_nothing_is_recorded_without_consent(page: Page, serve: Serve, ball: Path) -> None:
    server = serve(ball)
    open_page(page, server.url)
    page.locator("button[name=record]").click()
    page.locator("button[name=begin]").click()  # the box is not ticked
    expect(page.locator("dialog")).to_be_visible()
    page.get_by_text("Cancel").click()
    page.mouse.move(*at(page, ".pane.felt", 0.5, 0.5))
    page.wait_for_timeout(500)
    assert not server.recordings.exists()


def test_a_recording_survives_the_server_s_death(
    page: Page, serve: Serve, ball: Path, screenshots: Path
) -> None:
    """Killed in the middle and back half a minute of frames later: every frame is on disk once."""
    page.expected_errors.append("WebSocket connection")  # type: ignore[attr-defined]
    server = serve(ball)
    open_page(page, server.url)
    page.locator("button[name=record]").click()
    page.locator("input[name=participant]").fill("P7")
    page.locator("input[name=consent]").check()
    page.locator("button[name=begin]").click()
    expect(page.locator(".recording")).to_contain_text("Recording P7")
    page.screenshot(path=screenshots / "recording.png")
    wander(page, 12)
    server.stop(at_once=True)
    expect(page.locator(".failure")).to_contain_text("server is gone")
    wander(page, 12)
    server.start()
    expect(page.locator(".failure")).to_have_count(0, timeout=LONG)
    wander(page, 6)
    page.locator("button[name=stop-recording]").click()
    recorded = int(page.locator("#recording-slot").get_attribute("data-rows") or 0)
    (folder,) = (server.recordings / "P7").iterdir()
    for _ in range(200):
        if (folder / "recording.parquet").exists():
            break
        page.wait_for_timeout(100)
    table = pq.read_table(folder / "recording.parquet")
    times = table["time_ms"].to_numpy()
    assert len(times) == recorded > 50
    assert (np.diff(times) > 0).all(), "each frame once, in order"
    assert np.diff(table["chunk"].to_numpy()).max() == 1
    check_displayed(table, tw.load_scene(ball), tw.load_warp(ball.with_suffix(".warp")))


def wander(page: Page, steps: int) -> None:
    for step in range(steps):
        page.mouse.move(*at(page, ".pane.felt", 0.4 + 0.2 * step / steps, 0.5))
        page.wait_for_timeout(150)


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


def test_a_recording_is_replayed(page: Page, serve: Serve, ball: Path) -> None:
    server = serve(ball)
    open_page(page, server.url)
    page.locator("button[name=record]").click()
    page.locator("input[name=participant]").fill("P8")
    page.locator("input[name=consent]").check()
    page.locator("button[name=begin]").click()
    wander(page, 6)
    page.locator("button[name=stop-recording]").click()
    page.locator("button[name=replay]").click()
    page.locator("dialog").get_by_text("P8").click()
    moment = page.locator("input[name=moment]")
    expect(moment).to_be_visible()
    expect(page.locator("button[name=play]")).to_have_text("Play", timeout=LONG)
    assert int(moment.input_value()) == int(moment.get_attribute("max") or 0) > 10
    page.locator("button[name=close-replay]").click()
    expect(page.locator("button[name=record]")).to_be_visible()


def test_an_exported_page_keeps_recordings_on_the_device(
    page: Page, ball: Path, tmp_path: Path
) -> None:
    import functools
    import http.server
    import threading

    from touchwarp.live.export import export_page

    export_page(ball, tmp_path / "exported", lambda step, done: None)
    handler = functools.partial(QuietHandler, directory=str(tmp_path / "exported"))
    host = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    thread = threading.Thread(target=host.serve_forever)
    thread.start()
    try:
        open_page(page, f"http://127.0.0.1:{host.server_address[1]}/")
        expect(page.locator("input[name=weight]")).to_be_disabled()
        page.locator("button[name=record]").click()
        expect(page.locator("dialog")).to_contain_text("stay on this device")
        page.locator("input[name=participant]").fill("P9")
        page.locator("input[name=consent]").check()
        page.locator("button[name=begin]").click()
        wander(page, 4)
        page.locator("button[name=stop-recording]").click()
        with page.expect_download() as download:
            page.locator("button[name=save-recording]").click()
        lines = Path(download.value.path()).read_text().splitlines()
        assert lines[0].startswith("chunk,warp,time_ms,hand")
        assert len(lines) > 5
        assert {line.count(",") for line in lines} == {lines[0].count(",")}
        state = json.loads((tmp_path / "exported" / "boot.json").read_text())
        assert lines[1].split(",")[1] == state["warp"]["identity"]
    finally:
        host.shutdown()
        host.server_close()
        thread.join()


import http.server  # noqa: E402


class QuietHandler(http.server.SimpleHTTPRequestHandler):
    """Tells nothing on stderr."""

    def log_message(self, *told: object) -> None:
        """Nothing."""
