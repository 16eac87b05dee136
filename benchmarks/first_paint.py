"""From opening the demo's page to its first picture, in a headless Chromium on this machine.

    python benchmarks/first_paint.py [DEMO] [--repeats 5] [--json FILE]

DEMO is the folder that `touchwarp demo` has written; without it one is made, to 1 mm, which is
quick. The server runs and bases for live changes are there. Times are the browser's own, from the
start of the navigation, its cache empty, at 1100 × 680 without a graphics processor. The picture is
there when its first frame with the mug in it has been drawn; hands are displaced when one has been
drawn with the warp's first level; the warp is whole when all its levels are in use.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from demo_page import add_bases, demo_scene, served
from figures import Figure, print_figures, save_json

MARKS = ("first-contentful-paint", "first-picture", "first-displaced", "whole-warp")
TIMES = "(marks) => marks.map((mark) => performance.getEntriesByName(mark)[0].startTime / 1e3)"


def measure(scene: Path, repeats: int) -> list[Figure]:
    """Times in seconds."""
    add_bases(scene)
    runs = []
    with served(scene) as (address, browser):
        page = browser.new_page(viewport={"width": 1100, "height": 680})
        page.goto(address)  # until the certificate is there, the server works on that
        page.wait_for_selector(".checks", timeout=300_000)
        page.close()
        for _ in range(repeats):
            context = browser.new_context(viewport={"width": 1100, "height": 680})
            page = context.new_page()
            page.goto(address)
            page.wait_for_function("() => performance.getEntriesByName('whole-warp').length > 0")
            runs.append(page.evaluate(TIMES, list(MARKS)))
            context.close()
    paint, picture, displaced, whole = (list(times) for times in zip(*runs, strict=True))
    return [
        Figure("first paint", min(paint), "s", at_most=2.0),
        Figure("first picture of the mug", min(picture), "s", at_most=2.0),
        Figure("the same, worst of the runs", max(picture), "s"),
        Figure("first displaced hand", min(displaced), "s"),
        Figure("the warp whole", min(whole), "s"),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("demo", type=Path, nargs="?")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    given = options.demo / "mug.toml" if options.demo is not None else None
    with demo_scene(given, tolerance_mm=1.0) as scene:
        figures = measure(scene, options.repeats)
    print_figures("the demo's page", figures)
    if options.json:
        save_json(options.json, figures)


if __name__ == "__main__":
    main()
