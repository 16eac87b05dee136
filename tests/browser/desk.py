"""What tests of the desk share: opening the page, places on the screen, colours."""

from __future__ import annotations

import io
import json
import re
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.image import imread
from numpy.typing import NDArray
from playwright.sync_api import Page, WebSocketRoute, expect

LONG = 120_000
"""ms; how long anything is waited for: what is awaited is the condition, not the machine."""


def open_page(page: Page, url: str) -> None:
    """Open a page and wait for its first picture."""
    page.goto(url)
    page.wait_for_selector("body[data-ready]")


def expect_lost_server(page: Page) -> None:
    """What a browser logs by itself when the server goes, whatever was on its way, is no defect."""
    page.expected_errors += ["WebSocket connection", "net::ERR_"]  # type: ignore[attr-defined]


def drawn(page: Page) -> None:
    """Wait until what was done has come into a frame."""
    frame = "requestAnimationFrame"
    page.evaluate(f"() => new Promise((done) => {frame}(() => {frame}(() => done())))")


def whole_warp(page: Page) -> None:
    """Wait until the solved warp is in use, with all its levels."""
    expect(page.locator(".exactness")).to_have_attribute("data-exact", "true")
    expect(page.locator(".exactness")).to_have_text(re.compile(r"(\d+) of \1 levels"))
    drawn(page)


def keep_texts(page: Page, *selectors: str) -> Callable[[], list[list[str]]]:
    """Have a page, not yet opened, remember all that elements ever told; gives what they did."""
    page.add_init_script(
        f"window.told = []; new MutationObserver(() => told.push({list(selectors)}.map("
        "(name) => document.querySelector(name)?.textContent ?? ''))).observe(document,"
        " { subtree: true, childList: true, characterData: true })"
    )
    return lambda: page.evaluate("told")


class HeldBack:
    """What the server says to a page, not yet opened, until it is let through."""

    def __init__(self, page: Page) -> None:
        self._held: list[str | bytes] = []
        self._open = False
        page.route_web_socket("**/live", self._route)

    @property
    def kinds(self) -> list[str]:
        """Of the messages that are held, with what they are about: "state", "progress solve"."""
        held = [json.loads(message) for message in self._held]
        return [" ".join([said["kind"], *filter(None, [said.get("task")])]) for said in held]

    def hold(self) -> None:
        """From now on."""
        self._open = False

    def let_through(self, first: str | None = None) -> None:
        """All up to the first message of a kind; without one, all that comes later, too."""
        count = len(self._held) if first is None else self.kinds.index(first) + 1
        self._open = first is None
        for message in self._held[:count]:
            self._page.send(message)
        del self._held[:count]

    def _route(self, socket: WebSocketRoute) -> None:
        self._page = socket
        socket.connect_to_server().on_message(self._hear)

    def _hear(self, message: str | bytes) -> None:
        self._held.append(message)
        if self._open:
            self.let_through()


def at(page: Page, selector: str, x: float, y: float) -> tuple[float, float]:
    """The place on the screen at shares x, y of an element."""
    box = page.locator(selector).bounding_box()
    assert box is not None
    return box["x"] + x * box["width"], box["y"] + y * box["height"]


def reading(page: Page) -> str:
    """What the hand tells."""
    return page.locator("#reading").inner_text()


def picture(page: Page, selector: str) -> NDArray[np.float64]:
    """(h, w, 3) 0…255: an element as it looks."""
    shot = imread(io.BytesIO(page.locator(selector).screenshot()), format="png")
    return 255.0 * np.asarray(shot)[..., :3]


def wait_for(page: Page, selector: str, holds: Any, message: str) -> None:
    """Until an element's picture is as wanted; drawing takes its time on a busy machine."""
    wait_until(page, lambda: holds(picture(page, selector)), message)


def wait_until(page: Page, holds: Callable[[], Any], message: str) -> None:
    """Until something holds that the page does not tell by itself."""
    deadline = time.monotonic() + 1e-3 * LONG
    while not holds():
        assert time.monotonic() < deadline, message
        page.wait_for_timeout(50)


def is_green(rgb: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Of the mismatch scale's middle."""
    green: NDArray[np.bool_] = (rgb[..., 1] > rgb[..., 0] + 40) & (rgb[..., 1] > rgb[..., 2] + 10)
    return green


def is_blue(rgb: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Of a virtual object."""
    blue: NDArray[np.bool_] = (rgb[..., 2] > rgb[..., 0] + 60) & (rgb[..., 2] > rgb[..., 1] + 20)
    return blue


def is_pink(rgb: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Of the place that a line of the certificate is about."""
    pink: NDArray[np.bool_] = (rgb[..., 0] > 150) & (rgb[..., 1] < 100) & (rgb[..., 2] > 100)
    return pink


def handle_of(page: Page, axis: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where to grab the gizmo's handle of an axis, on the screen, and which way along it.

    It is found by its colour, as far from the other axes' handles as it reaches; the way is that of
    the coloured line there, outwards.
    """
    page.mouse.move(*at(page, ".pane.seen", 0.5, 0.02))  # what the mouse is over has another colour
    places: dict[str, NDArray[np.float64]] = {}

    def are_seen(seen: NDArray[np.float64]) -> bool:
        for name, colour in HANDLES.items():
            rows, columns = np.nonzero(np.abs(seen - colour).max(axis=-1) < 10)
            places[name] = np.stack([columns, rows], axis=1).astype(float)
        return all(len(found) > 10 for found in places.values())

    wait_for(page, ".pane.seen", are_seen, "no gizmo is to be seen")
    own = places[axis]
    others = np.concatenate([found for name, found in places.items() if name != axis])
    apart = np.linalg.norm(own[:, None] - others[None], axis=2).min(axis=1)
    grip = own[apart.argmax()]
    near = own[np.linalg.norm(own - grip, axis=1) < 25] - grip
    way = np.linalg.svd(near - near.mean(axis=0))[2][0]
    way *= np.sign(way @ (grip - others.mean(axis=0))) or 1.0
    box = page.locator(".pane.seen").bounding_box()
    assert box is not None
    return grip + np.array([box["x"] + 0.5, box["y"] + 0.5]), way


HANDLES = {"x": (212, 48, 28), "y": (46, 139, 87), "z": (106, 79, 176)}
"""Colours of the gizmo's handles."""
