"""A person with a headset on: hands that go where a test wants, at 72 frames a second."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from playwright.sync_api import Page

ROOT = Path(__file__).resolve().parents[2]
EMULATOR = ROOT / "web" / "node_modules" / "iwer" / "build" / "iwer.min.js"
TIPS = (4, 9, 14, 19, 24)
RADIUS = 0.008

Hand = NDArray[np.float64]
"""(25, 4, 4): T_room_joint."""


class Headset:
    """The emulated headset of one page; make it before the page is opened.

    Args:
        page: not yet opened.
        options: of the emulated device, where they are other than a Quest 3's.
    """

    def __init__(self, page: Page, **options: Any) -> None:
        self.page = page
        page.add_init_script(f"window.headsetOptions = {json.dumps(options)}")
        page.add_init_script(path=EMULATOR)
        page.add_init_script(path=Path(__file__).with_name("headset.js"))
        self.relaxed: dict[str, Hand] = {}

    def open(self, url: str) -> None:
        """Open a page and wait until it offers the headset."""
        self.page.goto(url + "?probe")
        self.page.wait_for_selector("#enter-xr")
        for side in ("left", "right"):
            rows = self.page.evaluate(f"headset.relaxed('{side}')")
            self.relaxed[side] = np.reshape(rows, (25, 4, 4)).transpose(0, 2, 1)

    def enter(self, *said: str) -> None:
        """Go through the page before the headset, and in.

        Args:
            said: what else is ticked there, as selectors of its inputs.
        """
        self.page.click("#enter-xr")
        for choice in ("[name=clear]", "[name=empty]", *said):
            self.page.check(f".preflight input{choice}")
        self.page.click(".preflight .enter")
        self.page.wait_for_selector("#enter-xr:disabled")
        self._await("window.touchwarpProbe?.session.phase === 'calibrate'")
        self.page.evaluate("headset.takeClock()")
        self._await("headset.hasClock()")

    def leave(self) -> None:
        """End the session, as the headset's own button would."""
        self.page.evaluate("touchwarpProbe.xr.end()")
        self.page.evaluate("headset.giveClockBack()")
        self.page.wait_for_selector("#enter-xr:enabled")

    def step(self, frames: list[dict[str, Hand]], tell: str = "") -> list[Any]:
        """Frames with the hands given; `tell`, a JavaScript expression, is evaluated after each."""
        numbers = np.full((len(frames), 2, 25, 4, 4), np.nan, dtype=np.float32)
        for row, frame in zip(numbers, frames, strict=True):
            for side, hand in frame.items():
                row[("left", "right").index(side)] = hand.transpose(0, 2, 1)
        packed = base64.b64encode(numbers.tobytes()).decode()
        each = f"() => ({tell})" if tell else "null"
        result: list[Any] = self.page.evaluate(f"packed => headset.step(packed, {each})", packed)
        return result

    def picture(self, path: Path) -> None:
        """What the headset shows, both eyes, without the page beneath."""
        self.page.add_style_tag(content=":is(header, .stage, aside) { opacity: 0 }")
        self.page.evaluate("headset.draw()")
        self.page.screenshot(path=path)

    def settle(self) -> None:
        """Wait, outside the headset's time, until what touches tell has been worked out."""
        self._await("!touchwarpProbe.calibrator?.busy")

    def await_warp(self) -> None:
        """Wait, outside the headset's time, until the solved warp has come, with all its levels."""
        tables = "touchwarpProbe.context.tables"
        whole = f"{tables}.current?.levelsLoaded === {tables}.current?.levelCount"
        self._await(f"{tables}.exact && {whole}")

    def _await(self, condition: str) -> None:
        self.page.wait_for_function(f"() => {condition}", polling=20)

    def wait(self, seconds: float, **hands: Hand) -> None:
        """Time passes, hands stay."""
        self.step([hands] * max(1, round(72 * seconds)))

    def probe(self, expression: str) -> Any:
        """A value of what the page shows; `it` is the session's experience."""
        return self.page.evaluate(
            f"(() => {{ const it = touchwarpProbe; return {expression}; }})()"
        )

    def poke(self, label: str) -> None:
        """Push the right index fingertip through a button of the panel."""
        middle = f"it.room.panel.localToWorld(it.room.panel.middleOf({label!r}).clone())"
        place = np.array(self.probe(f"{middle}.toArray()"))
        out = np.array(self.probe("it.room.panel.getWorldDirection(it.head.clone()).toArray()"))
        approach = [place + away * out for away in (0.06, 0.03, 0.01, -0.005, 0.03, 0.06)]
        self.step([{"right": self.hand_at("right", tip, -out)} for tip in approach])

    def poke_last(self, label: str) -> None:
        """Push a button that ends the session: the hand has no frames to go back in."""
        middle = f"it.room.panel.localToWorld(it.room.panel.middleOf({label!r}).clone())"
        place = np.array(self.probe(f"{middle}.toArray()"))
        out = np.array(self.probe("it.room.panel.getWorldDirection(it.head.clone()).toArray()"))
        approach = [place + away * out for away in (0.06, 0.03, 0.01, -0.005)]
        self.step([{"right": self.hand_at("right", tip, -out)} for tip in approach])

    def hand_at(
        self, side: str, tip: NDArray[np.float64], towards: NDArray[np.float64], finger: int = 1
    ) -> Hand:
        """A relaxed hand with one fingertip's centre at `tip`, come from the way it points to."""
        hand = self.relaxed[side].copy()
        joint = TIPS[finger]
        pointing = hand[joint, :3, 3] - hand[0, :3, 3]
        turn = np.eye(4)
        turn[:3, :3] = rotation_between(pointing, towards)
        hand = turn @ hand
        hand[:, :3, 3] += tip - hand[joint, :3, 3]
        return hand

    def pinching(self, side: str, at: NDArray[np.float64]) -> Hand:
        """A hand with its wrist at a place, thumb and index finger closed."""
        hand = self.relaxed[side].copy()
        hand[:, :3, 3] += at - hand[0, :3, 3]
        hand[TIPS[1], :3, 3] = hand[TIPS[0], :3, 3]
        return hand

    def open_hand(self, side: str, at: NDArray[np.float64]) -> Hand:
        """A relaxed hand with its wrist at a place, thumb and index finger apart."""
        hand = self.relaxed[side].copy()
        hand[:, :3, 3] += at - hand[0, :3, 3]
        return hand


def rotation_between(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    """The shortest rotation that takes one direction to another (Rodrigues)."""
    a, b = one / np.linalg.norm(one), other / np.linalg.norm(other)
    v, c = np.cross(a, b), float(a @ b)
    if c < -0.9999:
        axis = np.cross(a, [1.0, 0.0, 0.0] if abs(a[0]) < 0.9 else [0.0, 1.0, 0.0])
        axis /= np.linalg.norm(axis)
        return 2 * np.outer(axis, axis) - np.eye(3)
    k = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + k + k @ k / (1 + c)
