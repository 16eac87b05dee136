"""Desk mode as a person uses it: look, probe, slice, read the certificate, by mouse and by keys."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import igl
import numpy as np
import pytest
from numpy.typing import NDArray
from playwright.sync_api import Page, Route, expect

import touchwarp as tw
from tests.browser.desk import (
    at,
    drawn,
    is_blue,
    is_green,
    is_pink,
    keep_texts,
    open_page,
    picture,
    reading,
    wait_for,
    wait_until,
    whole_warp,
)
from tests.browser.server import Server

Serve = Callable[[Path], Server]


def test_it_shows_the_scene_and_how_exact_it_is(
    page: Page, ball_server: Server, screenshots: Path
) -> None:
    open_page(page, ball_server.url)
    expect(page.locator("#scene-name")).to_have_text("ball.toml")
    exactness = page.locator(".exactness")
    expect(exactness).to_contain_text("as float16, which adds")
    expect(exactness).to_have_text(re.compile(r"(\d+) of \1 levels"))
    expect(page.locator(".checks .check").first).to_be_visible()
    page.screenshot(path=screenshots / "desk.png")


def test_the_picture_is_not_empty(page: Page, ball_server: Server) -> None:
    """The felt pane holds colours of the mismatch scale, the seen one the virtual object's blue."""
    open_page(page, ball_server.url)
    wait_for(page, ".pane.felt", lambda felt: is_green(felt).mean() > 0.02, "no mismatch is seen")
    wait_for(page, ".pane.seen", lambda seen: is_blue(seen).mean() > 0.02, "no object is seen")
    assert is_blue(picture(page, ".pane.felt")).mean() < 0.005
    page.get_by_text("Plain", exact=True).click()
    wait_for(page, ".pane.felt", lambda felt: is_green(felt).mean() < 0.005, "it is still coloured")


def test_what_is_seen_where_it_is_felt_is_not_blotched(
    page: Page, serve: Serve, ball: Path
) -> None:
    """A box made wider: its top and its ghost's have the same depths."""
    text = ball.read_text().replace("ellipsoid", "box").replace("[1.2, 1.2, 1.1]", "[1.2, 1.2, 1]")
    ball.write_text(text.replace("[0.015,", "[0,"))
    open_page(page, serve(ball).url)

    def blotched() -> float:
        """The share of the object's pixels that are unlike the one beside them."""
        seen = picture(page, ".pane.seen")
        both = is_blue(seen)[:, 1:] & is_blue(seen)[:, :-1]
        unlike = np.abs(np.diff(seen, axis=1)).max(axis=-1) > 5
        return float(unlike[both].mean())

    wait_for(page, ".pane.seen", lambda seen: is_blue(seen).mean() > 0.02, "no object is seen")
    assert blotched() < 0.02


def test_what_people_notice_is_marked_on_the_scale(page: Page, mug_server: Server) -> None:
    open_page(page, mug_server.url)
    marks = page.locator(".legend[data-field=mismatch] .marks li")
    expect(marks.first).to_contain_text("52 mm")
    expect(page.locator(".legend .bar b")).to_have_count(1)
    page.get_by_text("Gain", exact=True).click()
    expect(page.locator(".legend[data-field=gain] .bar b")).to_have_count(2)
    page.get_by_text("Where these come from").click()
    expect(page.locator(".sources p").first).to_be_visible()
    page.get_by_text("Contact error", exact=True).click()
    marks = page.locator(".legend[data-field=error] .marks")
    expect(marks).to_contain_text("tolerance")
    expect(marks).to_contain_text(
        "52 mm along the surface: fingertip offset in contact: just noticeable difference"
    )
    expect(marks).to_contain_text("? off the surface: no number, but noticed far sooner")
    expect(page.locator("#panel")).to_contain_text("|f − g|: how far the displayed finger is")


def test_the_probe_touches_and_tells_the_mismatch(page: Page, ball_server: Server) -> None:
    open_page(page, ball_server.url)
    whole_warp(page)
    page.mouse.move(*at(page, ".pane.felt", 0.5, 0.5))
    drawn(page)
    expect(page.locator("#reading")).to_contain_text("touching the ball")
    told = float(re.findall(r"([\d.]+) mm away", reading(page))[0])
    # scale and shift move the ball's surface by 7 to 28 mm, depending on where it is touched
    assert 5.0 < told < 30.0
    page.mouse.move(*at(page, ".pane.felt", 0.5, 0.05))
    expect(page.locator("#reading")).to_contain_text("in the air")
    page.mouse.move(*at(page, ".pane.seen", 0.5, 0.5))
    expect(page.locator("#reading")).to_contain_text("touching the ball")


TIP, RADIUS = 9, 0.0075
BONES = [(6, 7), (7, 8), (8, 9), (11, 12), (12, 13), (1, 2), (2, 3), (0, 6), (6, 21)]


def test_the_probe_is_a_whole_hand_on_rigid_bones(
    page: Page, ball_server: Server, screenshots: Path
) -> None:
    """Its skin is on the virtual ball where the real skin is on the prop; no bone is stretched."""
    open_page(page, ball_server.url + "?probe")
    whole_warp(page)
    scene = tw.load_scene(ball_server.path)
    surface, goal = scene.props[0].surface, scene.props[0].goal
    assert isinstance(goal, tw.TransformGoal)
    low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    matrix = goal.affine(np.array([low, high]))
    virtual = surface.vertices @ matrix[:3, :3].T + matrix[:3, 3]
    turned = []
    for x, y in ((0.5, 0.45), (0.42, 0.55), (0.58, 0.5), (0.5, 0.6)):
        page.mouse.move(*at(page, ".pane.felt", x, y))
        drawn(page)
        expect(page.locator("#reading")).to_contain_text("touching the ball")
        page.wait_for_function("() => !touchwarpDesk.probe.turning", polling=50)
        real, shown, errors = page.evaluate(
            "() => { const { realPoses, displayedPoses, tipErrors } = touchwarpDesk.probe;"
            " return [[...realPoses], [...displayedPoses], [...tipErrors]]; }"
        )
        real, shown = (np.reshape(rows, (25, 4, 4)) for rows in (real, shown))
        a, b = real[:, 3, :3], shown[:, 3, :3]
        for i, j in BONES:
            kept = np.linalg.norm(b[i] - b[j]) - np.linalg.norm(a[i] - a[j])
            assert abs(kept) < 1e-6
        for vertices, joints in ((surface.vertices, a), (virtual, b)):
            squared = igl.point_mesh_squared_distance(
                joints[TIP : TIP + 1], vertices, surface.faces
            )
            assert abs(np.sqrt(squared[0][0]) - RADIUS) < 0.5e-3
        assert errors[1] < 0.1e-3
        moved = np.linalg.norm(b - a, axis=1)
        turned.append(np.ptp(moved))
    # the twin: moved as one piece, as by its fingertip alone, all joints would have moved alike
    assert max(turned) > 2e-3
    page.screenshot(path=screenshots / "probe.png")


def test_the_slice_is_dragged(page: Page, ball_server: Server, screenshots: Path) -> None:
    open_page(page, ball_server.url)
    whole_warp(page)
    output = page.locator("label.slider output").first
    for mode in ("Arrows", "Lattice"):
        before = picture(page, ".pane.seen")
        page.get_by_text(mode, exact=True).click()
        expect(output).to_have_text(re.compile(r"y = -?0 mm"))
        wait_for(
            page,
            ".pane.seen",
            lambda seen, before=before: np.abs(seen - before).mean() > 0.5,
            "no slice is seen",
        )
        page.screenshot(path=screenshots / f"slice-{mode.lower()}.png")
    page.locator("input[name=slice-share]").fill("0.8")
    expect(output).not_to_have_text(re.compile(r"y = -?0 mm"))
    page.locator("input[name=slice-share]").fill("0.5")
    expect(output).to_have_text(re.compile(r"y = -?0 mm"))
    drag_orange_knob(page)
    expect(output).not_to_have_text(re.compile(r"y = -?0 mm"))


def drag_orange_knob(page: Page) -> None:
    page.mouse.move(*at(page, ".pane.felt", 0.2, 0.9))  # the hand out of the way
    drawn(page)
    wait_for(page, ".pane.felt", lambda felt: is_orange(felt).sum() > 20, "no knob is seen")
    rows, columns = np.nonzero(is_orange(picture(page, ".pane.felt")))
    box = page.locator(".pane.felt").bounding_box()
    assert box is not None
    x, y = box["x"] + columns.mean(), box["y"] + rows.mean()
    page.mouse.move(x, y)
    page.mouse.down()
    for step in range(1, 6):
        page.mouse.move(x + 6 * step, y - 8 * step)
    page.mouse.up()


def is_orange(rgb: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Of the slice's knob."""
    red, green, blue = np.moveaxis(rgb, -1, 0)
    return (red > 150) & (red > green + 45) & (green > blue + 40) & (blue < 110)


def test_felt_and_seen_are_laid_over_each_other(
    page: Page, ball_server: Server, screenshots: Path
) -> None:
    open_page(page, ball_server.url)
    page.get_by_text("Together", exact=True).click()
    expect(page.locator(".laid-over")).to_be_visible()
    expect(page.locator(".pane.felt")).to_be_hidden()
    wait_for(page, ".pane.seen", lambda seen: is_blue(seen).mean() > 0.02, "no object is seen")
    page.mouse.move(*at(page, ".pane.seen", 0.5, 0.5))
    expect(page.locator("#reading")).to_contain_text("touching the ball")
    page.screenshot(path=screenshots / "together.png")


def test_everything_can_be_done_by_keys(page: Page, ball_server: Server) -> None:
    open_page(page, ball_server.url + "?probe")
    whole_warp(page)
    eye = "[...touchwarpDesk.stage.camera.position.toArray()]"
    page.locator("#stage").focus()
    home = page.evaluate(eye)
    for key in ("ArrowRight", "ArrowUp", "+"):
        before = page.evaluate(eye)
        page.keyboard.press(key)
        assert not np.allclose(page.evaluate(eye), before, atol=1e-4), key
    page.keyboard.press("0")
    np.testing.assert_allclose(page.evaluate(eye), home, atol=1e-6)
    before_move = reading(page)
    for _ in range(4):
        page.keyboard.press("Shift+ArrowDown")
    expect(page.locator("#reading")).not_to_have_text(before_move)
    page.keyboard.press("Tab")  # on to the panel
    assert page.evaluate("document.activeElement.closest('aside') !== null")
    unnamed = page.evaluate(
        "[...document.querySelectorAll('button, input, [role=radiogroup]')].filter((e) =>"
        " !(e.textContent.trim() || e.ariaLabel || e.labels?.length)).map((e) => e.outerHTML)"
    )
    assert unnamed == []


def test_a_line_of_the_certificate_leads_to_its_place(
    page: Page, ball_server: Server, screenshots: Path
) -> None:
    open_page(page, ball_server.url)
    line = page.locator("[data-check='contact.max']")
    expect(line).to_be_enabled()
    assert is_pink(picture(page, ".pane.felt")).mean() == 0.0
    line.click()
    wait_for(page, ".pane.felt", lambda felt: is_pink(felt).mean() > 1e-4, "no place is shown")
    expect(page.locator(".why")).to_be_visible()
    page.screenshot(path=screenshots / "place.png")
    line.click()
    wait_for(page, ".pane.felt", lambda felt: is_pink(felt).mean() == 0.0, "it is still there")
    # one that has no place says why
    line.click()
    page.locator("[data-check='contact.mean']").click()
    expect(page.locator(".why")).to_contain_text("No one place: it is a mean over")
    wait_for(page, ".pane.felt", lambda felt: is_pink(felt).mean() == 0.0, "it is still there")
    assert page.locator(".check:disabled").count() == 0


@pytest.mark.parametrize("width", [1440, 820, 390])
def test_it_fits_into_a_narrow_window(
    page: Page, ball_server: Server, width: int, screenshots: Path
) -> None:
    page.set_viewport_size({"width": width, "height": 844})
    open_page(page, ball_server.url)
    expect(page.locator("#xr-slot button")).to_be_visible()  # the last that comes into the header
    expect(page.locator("#panel button").first).to_be_visible()
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    header = page.locator("header").bounding_box()
    assert header is not None
    for button in page.locator("header button").all():
        box = button.bounding_box()
        assert box is not None
        assert box["x"] + box["width"] <= width
        assert box["height"] < header["height"]
    for pane in (".pane.felt", ".pane.seen"):
        box = page.locator(pane).bounding_box()
        assert box is not None
        assert min(box["width"], box["height"]) > 150
    page.screenshot(path=screenshots / f"narrow-{width}.png", full_page=True)


SLOW_LINE = """
  window.allowed = 2000;
  const fetched = window.fetch;
  window.fetch = async (...asked) => {
    const answer = await fetched(...asked);
    if (!String(asked[0]).includes("/tables/") || asked[1]?.headers) return answer;
    const reader = answer.body.getReader();
    let waiting = new Uint8Array();
    let passed = 0;
    const body = new ReadableStream({
      async pull(control) {
        while (passed >= allowed) await new Promise((done) => setTimeout(done, 5));
        if (waiting.length === 0) {
          const { done, value } = await reader.read();
          if (done) return control.close();
          waiting = value;
        }
        const part = waiting.slice(0, allowed - passed);
        waiting = waiting.slice(part.length);
        passed += part.length;
        control.enqueue(part);
      },
    }, { highWaterMark: 0 });
    return Object.defineProperty(new Response(body, answer), "url", { value: answer.url });
  };
"""
"""Of each table, bytes come through as the test lets them."""


def test_the_warp_is_used_from_its_coarse_levels_on(page: Page, mug_server: Server) -> None:
    """Over a slow line hands are displayed while levels are on their way, and the error is told."""
    page.add_init_script(SLOW_LINE)
    told_so_far = keep_texts(page, ".exactness", "#reading")
    open_page(page, mug_server.url)
    whole = re.compile(r"(\d+) of \1 levels")
    exactness = page.locator(".exactness")

    def comes() -> bool:
        page.evaluate("allowed = Math.ceil(1.2 * allowed)")
        drawn(page)
        return whole.search(exactness.inner_text()) is not None

    wait_until(page, comes, "the warp is not whole")
    found = re.compile(r"which adds ([\d.]+) mm.* (\d+) of (\d+) levels", re.DOTALL)
    told = [(match, hand) for text, hand in told_so_far() if (match := found.search(text))]
    errors = {int(match[2]): float(match[1]) for match, _ in told}
    assert list(errors) == sorted(errors), "levels come one after another"
    assert len(errors) >= 3
    assert list(errors.values()) == sorted(errors.values(), reverse=True)
    assert max(errors.values()) > 10 * min(errors.values())
    assert any(match[2] != match[3] and "mm away" in hand for match, hand in told)


def test_a_headset_s_way_is_told_where_there_is_none(page: Page, ball_server: Server) -> None:
    open_page(page, ball_server.url)
    page.locator("button[name=how-to-headset]").click()
    dialog = page.locator("dialog[open]")
    expect(dialog).to_contain_text("touchwarp view ball.toml --host")
    expect(dialog).to_contain_text(f"adb reverse tcp:{ball_server.port}")
    dialog.get_by_text("Close").click()
    expect(dialog).to_have_count(0)


def test_the_page_is_there_before_its_scene(page: Page, ball_server: Server) -> None:
    asked: list[Route] = []
    page.route("**/boot.json", lambda route: asked.append(route))
    page.goto(ball_server.url)
    expect(page.locator("#loading")).to_have_text("Loading the scene …")
    wait_until(page, lambda: asked, "the scene is not asked for")
    expect(page.locator("#loading")).to_contain_text("Its goal may take a minute to make")
    asked[0].continue_()
    page.wait_for_selector("body[data-ready]")
    expect(page.locator("#loading")).to_have_count(0)


def test_a_page_that_cannot_start_says_why(page: Page, ball_server: Server) -> None:
    page.expected_errors.append("500")  # type: ignore[attr-defined]
    page.route("**/boot.json", lambda route: route.fulfill(status=500, body=""))
    page.goto(ball_server.url)
    expect(page.locator("#trouble")).to_have_text("The scene cannot be fetched (500).")
    expect(page.locator("#loading")).to_have_count(0)
    page.unroute("**/boot.json")
    page.expected_errors.append("503")  # type: ignore[attr-defined]
    page.route("**/boot.json", lambda route: route.fulfill(status=503, body="No prop has a name."))
    page.reload()
    expect(page.locator("#trouble")).to_have_text("No prop has a name.")
    page.unroute("**/boot.json")
    page.expected_errors.append("404")  # type: ignore[attr-defined]
    page.route("**/surfaces/*", lambda route: route.fulfill(status=404, body=""))
    page.reload()
    expect(page.locator("#trouble")).to_contain_text("cannot be fetched (404)")
