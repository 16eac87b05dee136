"""From opening the demo's page to its first picture, in a headless Chromium on this machine.

    python benchmarks/first_paint.py [--repeats 5] [--json FILE]

The server runs and the warp is solved (to 1 mm: the time to the first picture does not depend on
it). Times are the browser's own, from the start of the navigation; the picture is there when its
first frame with the mug in it has been drawn, at 1100 × 680 without a graphics processor.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from figures import Figure, print_figures, save_json
from playwright.sync_api import sync_playwright

import touchwarp as tw
from touchwarp.cli.demo_files import write_input

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from tests.browser.chromium import FLAGS, obtain_chromium
from tests.browser.server import Server

TIMES = """() => [
  performance.getEntriesByName("first-contentful-paint")[0].startTime,
  performance.getEntriesByName("first-picture")[0].startTime,
]"""


def measure(folder: Path, repeats: int) -> list[Figure]:
    """Times in seconds."""
    write_input(folder, tolerance_mm=1.0)
    scene = tw.load_scene(folder / "mug.toml")
    tw.solve(scene).save(folder / "mug.warp")
    tw.solve_bases(scene).save(folder / "mug.bases")
    server = Server(folder / "mug.toml")
    server.start()
    program, source = obtain_chromium()
    print(f"browser: {source}")
    paints, pictures = [], []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=list(FLAGS))
        for _ in range(repeats):
            page = browser.new_page(viewport={"width": 1100, "height": 680})
            page.goto(server.url)
            page.wait_for_selector("body[data-ready]")
            paint, picture = page.evaluate(TIMES)
            paints.append(paint / 1e3)
            pictures.append(picture / 1e3)
            page.close()
        browser.close()
    server.stop()
    return [
        Figure("first paint", min(paints), "s", at_most=2.0),
        Figure("first picture of the mug", min(pictures), "s", at_most=2.0),
        Figure("the same, worst of the runs", max(pictures), "s"),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        figures = measure(Path(folder), options.repeats)
    print_figures("the demo's page", figures)
    if options.json:
        save_json(options.json, figures)


if __name__ == "__main__":
    main()
