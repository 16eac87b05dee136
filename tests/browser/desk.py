"""What tests of the desk share: opening the page, places on the screen, colours."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from matplotlib.image import imread
from numpy.typing import NDArray
from playwright.sync_api import Page

LONG = 120_000
"""ms; for what has to be solved on a busy machine."""


def open_page(page: Page, url: str) -> None:
    """Open a page and wait for its first picture."""
    page.goto(url)
    page.wait_for_selector("body[data-ready]")


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
    for _ in range(200):
        if holds(picture(page, selector)):
            return
        page.wait_for_timeout(50)
    raise AssertionError(message)


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
