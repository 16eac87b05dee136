"""The virtual object moved, turned and scaled by the gizmo: the numbers, the warp and the file."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from playwright.sync_api import Page, expect
from scipy.spatial.transform import Rotation

import touchwarp as tw
from tests.browser.desk import (
    HANDLES,
    HeldBack,
    at,
    drawn,
    handle_of,
    open_page,
    wait_for,
    wait_until,
    whole_warp,
)
from tests.browser.server import Server

Serve = Callable[[Path], Server]
Numbers = dict[str, NDArray[np.float64]]

KINDS = ("translation", "rotation_deg", "scale")
UNITS = {"translation": 1e3, "rotation_deg": 1.0, "scale": 1.0}
PIXELS = {"Move": (-20.0, -10.0, 8.0), "Scale": (-10.0, -10.0, 4.0), "Turn": (5.0, 5.0, 5.0)}
"""How far outwards handles of x, y, z are dragged: no threshold comes on to the colour scale."""


@pytest.mark.parametrize(("mode", "kind"), [("Move", "translation"), ("Scale", "scale")])
def test_the_gizmo_changes_one_axis_and_the_warp_with_it(
    page: Page, serve: Serve, ball: Path, screenshots: Path, mode: str, kind: str
) -> None:
    desk = Desk(page, serve(ball), mode)
    for k, axis in enumerate("xyz"):
        before, after = desk.drag(axis)
        moved = {name: after[name] - before[name] for name in KINDS}
        least = 3.0 if kind == "translation" else 0.03
        assert np.sign(PIXELS[mode][k]) * moved[kind][k] > least, (
            "outwards it grows, inwards it shrinks"
        )
        moved[kind][k] = 0.0
        for name in KINDS:
            np.testing.assert_array_equal(moved[name], 0.0, err_msg=name)
    page.screenshot(path=screenshots / f"gizmo-{mode.lower()}.png")
    desk.check_saved()


def test_the_gizmo_turns_about_each_axis_and_the_warp_with_it(
    page: Page, serve: Serve, ball: Path, screenshots: Path
) -> None:
    desk = Desk(page, serve(ball), "Turn")
    for axis, direction in zip("xyz", np.eye(3), strict=True):
        before, after = desk.drag(axis)
        turned = (turn_of(after) * turn_of(before).inv()).as_rotvec(degrees=True)
        assert abs(turned @ direction) > 2.0
        np.testing.assert_allclose(turned - (turned @ direction) * direction, 0.0, atol=0.1)
        for name in ("translation", "scale"):
            np.testing.assert_array_equal(after[name], before[name])
    page.screenshot(path=screenshots / "gizmo-turn.png")
    desk.check_saved()


def test_the_warp_stays_with_what_is_held_while_the_server_tells_where_it_was(
    page: Page, serve: Serve, ball: Path
) -> None:
    """The scene of one drag is told during the next, when the object is elsewhere already."""
    said = HeldBack(page)
    said.let_through()
    desk = Desk(page, serve(ball), "Move")
    expect(page.locator(".checks .check").first).to_be_visible()  # nothing more is on its way
    said.hold()
    desk.drag("x")
    wait_until(page, lambda: "changed" in said.kinds, "the server does not take it up")

    def hear() -> None:
        said.let_through("changed")
        drawn(page)

    desk.drag("y", held=hear)
    said.let_through()
    desk.check_saved()


EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "knob_and_crate.toml"


@pytest.mark.parametrize("size", [(1440, 900), (960, 560), (700, 900)])
def test_the_gizmo_of_a_small_prop_far_from_the_middle_is_whole(
    page: Page, serve: Serve, tmp_path: Path, size: tuple[int, int]
) -> None:
    """Of the knob, and of the crate, whose middles are at the two ends of the scene."""
    scene = tmp_path / EXAMPLE.name
    scene.write_text(EXAMPLE.read_text().replace("tolerance_mm = 0.5", "tolerance_mm = 5"))
    page.set_viewport_size({"width": size[0], "height": size[1]})
    open_page(page, serve(scene).url)
    page.mouse.move(*at(page, ".pane.seen", 0.5, 0.02))

    def whole(seen: NDArray[np.float64]) -> bool:
        """All three handles are to be seen, and none goes on beyond the pane's edge."""
        inner = np.zeros(seen.shape[:2], dtype=bool)
        inner[3:-3, 3:-3] = True
        of_axes = [np.abs(seen - colour).max(axis=-1) < 10 for colour in HANDLES.values()]
        return all(found.sum() > 10 and inner[found].all() for found in of_axes)

    wait_for(page, ".pane.seen", whole, "the knob's gizmo is cut")
    page.locator("input[name=prop][value=crate]").check(force=True)
    wait_for(page, ".pane.seen", whole, "the crate's gizmo is cut")
    page.locator("input[name=prop][value=knob]").check(force=True)
    page.locator("#stage").focus()
    for _ in range(20):
        page.keyboard.press("+")  # so near that the ends of the scene are out of sight
    wait_for(page, ".pane.seen", lambda seen: not whole(seen), "one that is cut counts as whole")


def test_a_line_about_a_small_prop_comes_near_to_it(
    page: Page, serve: Serve, tmp_path: Path
) -> None:
    """The knob is a speck in a scene that a crate, 0.9 m away, is part of."""
    scene = tmp_path / EXAMPLE.name
    scene.write_text(EXAMPLE.read_text().replace("tolerance_mm = 0.5", "tolerance_mm = 5"))
    open_page(page, serve(scene).url)
    whole_warp(page)

    def shows_knob(felt: NDArray[np.float64]) -> bool:
        """It displaces little, and so is dark; all of the crate is in the left half."""
        right = felt[:, felt.shape[1] // 2 :]
        return bool((right.max(axis=-1) < 130).mean() > 0.1)

    wait_for(page, ".pane.felt", lambda felt: not shows_knob(felt), "it is near already")
    page.locator(".check", has_text="Contact error, 99th percentile · knob").click()
    wait_for(page, ".pane.felt", shows_knob, "the knob is too far away")


class Desk:
    """The page, with the gizmo in one mode."""

    def __init__(self, page: Page, server: Server, mode: str) -> None:
        self.page, self.path, self.mode = page, server.path, mode
        self.surface = tw.load_scene(server.path).props[0].surface
        open_page(page, server.url)
        expect(page.get_by_text("Every change is live")).to_be_visible()
        whole_warp(page)
        page.get_by_text(mode, exact=True).click()
        self._shifts: list[float] = []
        self._check_displayed()

    def drag(self, axis: str, held: Callable[[], None] = lambda: None) -> tuple[Numbers, Numbers]:
        """Drag one handle; the numbers before and after. The warp follows while it is held.

        Args:
            held: what happens before it is let go of.
        """
        before = self._numbers()
        page = self.page
        grip, way = handle_of(page, axis)
        by = PIXELS[self.mode]["xyz".index(axis)]
        page.mouse.move(*grip)
        page.mouse.down()
        for step in range(1, 6):
            page.mouse.move(*(grip + way * by * step / 5))
        expect(page.locator(".exactness")).to_contain_text("Live warp")
        wait_until(page, lambda: self._differs(before), f"{axis} does not move")
        held()
        self._check_displayed()
        after = self._numbers()
        page.mouse.up()
        return before, after

    def check_saved(self) -> None:
        """The solved warp and the file have what the numbers say."""
        whole_warp(self.page)
        told = self._numbers()
        self._check_displayed()
        assert np.ptp(self._shifts) > 3.0, "a warp that stays would have been told apart"
        self.page.locator("button[name=save]").click()
        expect(self.page.locator(".note")).to_have_text(f"Saved to {self.path.name}.")
        goal = tw.load_scene(self.path).props[0].goal
        assert isinstance(goal, tw.TransformGoal)
        for kind in KINDS:
            saved = UNITS[kind] * np.array(getattr(goal, kind) or (0.0, 0.0, 0.0))
            np.testing.assert_allclose(saved, told[kind], rtol=0.006, atol=0.006)

    def _numbers(self) -> Numbers:
        told = self.page.locator("table.numbers input").evaluate_all(
            "(inputs) => inputs.map((input) => [input.name, Number(input.value)])"
        )
        values = dict(told)
        return {kind: np.array([values[f"{kind}-{k}"] for k in range(3)]) for kind in KINDS}

    def _differs(self, before: Numbers) -> bool:
        now = self._numbers()
        return any((now[kind] != before[kind]).any() for kind in KINDS)

    def _check_displayed(self) -> None:
        """The scale of mismatch ends where the numbers have the farthest place of the prop.

        It is the warp's own: each vertex of the prop is looked up in it.
        """
        end = self.page.locator(".legend[data-field=mismatch] .ends span").last

        seen: list[tuple[str, float, float]] = []

        def follows() -> bool:
            told = float(re.sub(r"[^\d.]", "", end.inner_text()))
            exactness = self.page.locator(".exactness").inner_text()
            seen[:] = [(exactness, told, self._greatest_shift())]
            return abs(told - seen[0][2]) < 0.6

        try:
            wait_until(self.page, follows, "the warp does not follow the object")
        except AssertionError as error:
            raise AssertionError(f"{error}: warp, mm it tells, mm by the numbers: {seen}") from None
        self._shifts.append(self._greatest_shift())

    def _greatest_shift(self) -> float:
        """mm, by the numbers."""
        told = self._numbers()
        goal = tw.TransformGoal(
            scale=list(told["scale"]),
            rotation_deg=list(told["rotation_deg"]),
            translation=list(1e-3 * told["translation"]),
        )
        vertices = self.surface.vertices
        matrix = goal.affine(np.array([vertices.min(axis=0), vertices.max(axis=0)]))
        shown = vertices @ matrix[:3, :3].T + matrix[:3, 3]
        return 1e3 * float(np.linalg.norm(shown - vertices, axis=1).max())


def turn_of(told: Numbers) -> Rotation:
    """R = Rz Ry Rx."""
    return Rotation.from_euler("ZYX", told["rotation_deg"][::-1], degrees=True)
