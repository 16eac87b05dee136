"""The scene changed on the desk: by the gizmo, by numbers, λ; solved, refused, saved, reloaded."""

from __future__ import annotations

import json
import re
import tomllib
import urllib.request
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from playwright.sync_api import Page, Route, WebSocketRoute, expect
from websockets.sync.client import connect

from tests.browser.desk import (
    HeldBack,
    at,
    expect_lost_server,
    open_page,
    picture,
    wait_for,
    wait_until,
    whole_warp,
)
from tests.browser.server import Server

Serve = Callable[[Path], Server]


def test_the_gizmo_changes_the_warp_at_once_and_the_server_follows(
    page: Page, serve: Serve, ball: Path, screenshots: Path
) -> None:
    server = serve(ball)
    open_page(page, server.url)
    expect(page.get_by_text("Every change is live")).to_be_visible()
    shift = page.locator("input[name=translation-0]")
    expect(shift).to_have_value("15")
    whole_warp(page)
    drag_red_arrow(page, 60)
    whole_warp(page)
    moved = float(shift.input_value())
    assert moved > 18.0
    page.locator("button[name=save]").click()
    expect(page.locator(".note")).to_have_text("Saved to ball.toml.")
    page.screenshot(path=screenshots / "moved.png")
    text = ball.read_text()
    assert "# to the right" in text
    saved = tomllib.loads(text)["prop"][0]["goal"]["translation"]
    assert saved[0] * 1e3 == pytest.approx(moved, abs=0.06)

    expect_lost_server(page)
    server.stop()
    server.start()
    page.reload()
    page.wait_for_selector("body[data-ready]")
    expect(shift).to_have_value(str(moved).removesuffix(".0"))


def drag_red_arrow(page: Page, by: float) -> None:
    """Find the gizmo's x arrow by its colour and drag it to the right; the warp follows at once."""
    page.mouse.move(*at(page, ".pane.seen", 0.5, 0.02))
    box = page.locator(".pane.seen").bounding_box()
    assert box is not None
    wait_for(page, ".pane.seen", lambda seen: is_red(seen).any(), "no gizmo is to be seen")
    rows, columns = np.nonzero(is_red(picture(page, ".pane.seen")))
    tip = columns > columns.max() - 8
    x, y = box["x"] + columns[tip].mean(), box["y"] + rows[tip].mean()
    page.mouse.move(x, y)
    page.mouse.down()
    for step in range(1, 7):
        page.mouse.move(x + by * step / 6, y + 0.2 * by * step / 6)
    shown = page.locator(".exactness")
    expect(shown).to_have_attribute("data-exact", "false")  # live, before any solve
    expect(shown).to_contain_text("Live warp")
    expect(page.locator("input[name=translation-0]")).not_to_have_value("15")
    page.mouse.up()


def is_red(rgb: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Of the gizmo's x arrow."""
    return (rgb[..., 0] > 190) & (rgb[..., 1] < 64) & (rgb[..., 2] < 64)


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
    said = HeldBack(page)
    open_page(page, serve(ball).url)
    said.let_through()
    whole_warp(page)
    expect(page.locator(".checks .check").first).to_be_visible()  # nothing more is on its way
    said.hold()
    page.locator("input[name=weight]").fill("0.6")
    # until the new one is there the old one, which holds in contact, is told to be the old one
    wait_until(page, lambda: "state" in said.kinds, "the server does not take it")
    said.let_through("state")
    expect(page.locator(".exactness")).to_contain_text("before the last change")
    wait_until(page, lambda: "progress solve" in said.kinds, "no progress is told")
    said.let_through("progress solve")
    expect(page.locator("[data-task=solve]")).to_contain_text("Solving")
    said.let_through()
    whole_warp(page)
    page.locator("button[name=save]").click()
    expect(page.locator(".note")).to_be_visible()
    weight = tomllib.loads(ball.read_text())["objective"]["mismatch_weight"]
    assert weight == pytest.approx(0.1 * 10_000**0.6, rel=0.05)


def test_a_scene_that_cannot_be_is_refused_in_words(page: Page, serve: Serve, ball: Path) -> None:
    open_page(page, serve(ball).url)
    height = page.locator("input[name=translation-2]")
    before = height.input_value()
    height.fill("-300")
    height.press("Enter")
    expect(page.locator(".failure").first).to_contain_text("must lie inside the outer boundary")
    expect(height).to_have_value(before)
    expect(page.locator("button[name=save]")).to_be_disabled()
    whole_warp(page)


def test_a_change_that_is_refused_is_taken_back(page: Page, ball_server: Server) -> None:
    """The server says no, in words: the object, its numbers and the warp are as before."""

    def refuse_changes(socket: WebSocketRoute) -> None:
        server = socket.connect_to_server()
        refusal = {"kind": "refused", "about": "change_scene", "reason": "Nothing may be changed."}

        def from_page(message: str | bytes) -> None:
            if "change_scene" in str(message):
                socket.send(json.dumps(refusal))
            else:
                server.send(message)

        socket.on_message(from_page)

    page.route_web_socket("**/live", refuse_changes)
    open_page(page, ball_server.url)
    whole_warp(page)
    expect(page.get_by_text("Every change is live")).to_be_visible()
    scale = page.locator("input[name=scale-2]")
    scale.fill("1.3")
    scale.press("Enter")
    expect(page.locator(".failure").first).to_have_text("Nothing may be changed.")
    expect(scale).to_have_value("1.1")
    whole_warp(page)
    expect(page.locator("button[name=save]")).to_be_disabled()


def test_a_scene_without_a_warp_shows_itself_and_its_progress(
    page: Page, serve: Serve, ball: Path, screenshots: Path
) -> None:
    for ending in (".warp", ".bases"):
        ball.with_suffix(ending).unlink()
    server = serve(ball)
    # the server does not wait for the page: what it says is held back while the page is looked at
    with urllib.request.urlopen(server.url + "boot.json", timeout=60) as answer:
        begun = json.load(answer) | {"warp": None, "bases": None, "warp_current": False}
    page.route("**/boot.json", lambda route: route.fulfill(json=begun))
    said = HeldBack(page)
    open_page(page, server.url)
    expect(page.locator(".exactness")).to_contain_text("No warp yet")
    expect(page.locator("#reading")).to_contain_text("no warp yet")
    expect(page.locator(".legend")).to_have_count(0)
    # which may be done with its work before a slow page connects: it is given some more
    wait_until(page, lambda: "state" in said.kinds, "the server does not tell its scene")
    with connect(server.url.replace("http", "ws") + "live") as another:
        another.send(json.dumps({"kind": "change_scene", "mismatch_weight": 1.0}))
        wait_until(page, lambda: "progress solve" in said.kinds, "the server tells no progress")
    said.let_through("progress solve")
    expect(page.locator(".task").first).to_be_visible()
    page.screenshot(path=screenshots / "unsolved.png")
    said.let_through()
    whole_warp(page)
    expect(page.locator(".legend")).to_be_visible()
    expect(page.locator("#reading")).to_have_text(re.compile("mm away"))


def test_changes_outlive_a_server_that_goes_and_comes_back(
    page: Page, serve: Serve, ball: Path
) -> None:
    """One is made before the server dies and not saved, one while it is gone: both are there."""
    expect_lost_server(page)
    server = serve(ball)
    open_page(page, server.url)
    shift = page.locator("input[name=translation-1]")
    shift.fill("4")
    shift.press("Enter")
    expect(page.locator("button[name=save]")).to_be_enabled()
    server.stop(at_once=True)
    expect(page.locator(".failure")).to_contain_text("server is gone")
    turn = page.locator("input[name=rotation_deg-2]")
    turn.fill("20")
    turn.press("Enter")
    server.start()
    expect(page.locator(".failure")).to_have_count(0)
    button = page.locator("button[name=save]")
    expect(button).to_be_enabled()
    button.click()
    expect(page.locator(".note")).to_be_visible()
    goal = tomllib.loads(ball.read_text())["prop"][0]["goal"]
    assert goal["translation"] == [0.015, 0.004, 0.0]
    assert goal["rotation_deg"] == [0.0, 0.0, 20.0]


def test_a_warp_on_its_way_when_the_server_goes_comes_once_it_is_back(
    page: Page, serve: Serve, ball: Path
) -> None:
    """One thing went wrong, so one is told; the request that it cut off is no second one."""
    expect_lost_server(page)
    server = serve(ball)
    open_page(page, server.url)
    whole_warp(page)
    on_their_way: list[Route] = []
    page.route("**/tables/**", lambda route: on_their_way.append(route))
    shift = page.locator("input[name=translation-1]")
    shift.fill("4")
    shift.press("Enter")
    wait_until(page, lambda: on_their_way, "no new warp was asked for")
    server.stop(at_once=True)
    for route in on_their_way:
        route.continue_()
    page.unroute("**/tables/**")
    expect(page.locator(".failure")).to_contain_text("server is gone")
    server.start()
    whole_warp(page)
    expect(page.locator(".failure")).to_have_count(0)
    expect(shift).to_have_value("4")


def test_a_file_that_was_changed_meanwhile_is_not_overwritten(
    page: Page, serve: Serve, ball: Path
) -> None:
    open_page(page, serve(ball).url)
    page.locator("input[name=translation-1]").fill("3")
    page.locator("input[name=translation-1]").press("Enter")
    expect(page.locator("button[name=save]")).to_be_enabled()
    mine = ball.read_text() + "\n# written by another program\n"
    ball.write_text(mine)
    page.locator("button[name=save]").click()
    expect(page.locator(".failure").first).to_contain_text("was changed on disk")
    assert ball.read_text() == mine
