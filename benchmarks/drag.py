"""Frames of the desk while the virtual object is dragged, in a headless Chromium on this machine.

    python benchmarks/drag.py [DEMO] [--seconds 5] [--json FILE]

DEMO is the folder that `touchwarp demo` has written; without it one is made, to 1 mm, which is
quick. The mug's virtual object is dragged by the gizmo's red arrow, to and fro by 40 pixels, at
1100 × 680. At each frame the goal is set in the warp of the bases, the prop's vertices are looked
up and coloured, and the hand is displayed. Without a graphics processor most of a frame goes by in
drawing; so what the page's own scripts take, events included, is told apart from three.js's: with
one, that decides the rate.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
from demo_page import add_bases, demo_scene, served
from figures import Figure, print_figures, save_json
from playwright.sync_api import Page

from tests.browser.desk import handle_of, open_page, whole_warp

WATCH = """
  window.frames = [];
  let [events, frame] = [0, null];
  const spend = (call, tell) => (...given) => {
    const begin = performance.now();
    try { return call(...given); } finally { tell(performance.now() - begin); }
  };
  const ask = window.requestAnimationFrame.bind(window);
  window.requestAnimationFrame = (call) => ask((at) => {
    if (frame?.at !== at) {
      frames.push((frame = { at, script: events, drawing: 0, drawn: false }));
      events = 0;
    }
    spend(call, (spent) => (frame.script += spent))(at);
  });
  const listen = EventTarget.prototype.addEventListener;
  EventTarget.prototype.addEventListener = function (kind, call, ...how) {
    const own = kind === "pointermove" && typeof call === "function";
    const timed = own ? spend(call.bind(this), (spent) => (events += spent)) : call;
    return listen.call(this, kind, timed, ...how);
  };
  window.watchDrawing = (renderer) => {
    const render = renderer.render.bind(renderer);
    renderer.render = (...given) => {
      frame.drawn = true;
      spend(render, (spent) => (frame.drawing += spent))(...given);
    };
  };
"""


def drag(page: Page, seconds: float) -> np.ndarray:
    """(n, 3) ms of each frame drawn: since the one before, in scripts, of them in drawing."""
    grip, way = handle_of(page, "x")
    page.mouse.move(*grip)
    page.mouse.down()
    page.mouse.move(*(grip + 2 * way))
    page.evaluate("watchDrawing(touchwarpDesk.stage.renderer)")
    page.evaluate("frames.length = 0")
    begin = time.monotonic()
    while (spent := time.monotonic() - begin) < seconds:
        page.mouse.move(*(grip + 20 * np.sin(3 * spent) * way))
    rows = page.evaluate(
        "frames.filter((f) => f.drawn).map(({ at, script, drawing }) => [at, script, drawing])"
    )
    page.mouse.up()
    frames = np.array(rows)
    frames[1:, 0] = np.diff(frames[:, 0])
    return frames[2:]


def measure(scene: Path, seconds: float) -> list[Figure]:
    """Frames a second and times in ms."""
    add_bases(scene)
    with served(scene) as (address, browser):
        page = browser.new_page(viewport={"width": 1100, "height": 680})
        page.add_init_script(WATCH)
        open_page(page, address + "?probe")
        page.wait_for_selector(".checks", timeout=300_000)  # the server has no other work
        whole_warp(page)
        page.get_by_text("Every change is live").wait_for()
        since, script, drawing = drag(page, seconds).T
    own = script - drawing
    return [
        Figure("frames drawn while dragging, in software", 1e3 / since.mean(), "1/s"),
        Figure("the same, longest time between two", since.max(), "ms"),
        Figure("of each in the page's own scripts, median", float(np.median(own)), "ms"),
        Figure("the same, 95th percentile", float(np.percentile(own, 95)), "ms", at_most=16.7),
        Figure("the same, worst", own.max(), "ms"),
        Figure("drawing, as far as scripts wait for it, median", float(np.median(drawing)), "ms"),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("demo", type=Path, nargs="?")
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    given = options.demo / "mug.toml" if options.demo is not None else None
    with demo_scene(given, tolerance_mm=1.0) as scene:
        figures = measure(scene, options.seconds)
    print_figures("dragging on the desk", figures)
    if options.json:
        save_json(options.json, figures)


if __name__ == "__main__":
    main()
