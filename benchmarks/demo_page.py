"""The demo's page, served and opened in a headless Chromium, for the benchmarks that time it."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, sync_playwright

import touchwarp as tw
from touchwarp.cli.demo_files import write_input

# the browser and server of the tests; importing this lets a benchmark import more of them
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from tests.browser.chromium import FLAGS, obtain_chromium
from tests.browser.server import Server


@contextmanager
def demo_scene(given: Path | None, tolerance_mm: float) -> Iterator[Path]:
    """The scene that is given, or the mug's in a folder made for as long, its warp beside it."""
    if given is not None:
        yield given
        return
    with tempfile.TemporaryDirectory() as folder:
        write_input(Path(folder), tolerance_mm=tolerance_mm)
        scene = Path(folder) / "mug.toml"
        tw.solve(tw.load_scene(scene)).save(scene.with_suffix(".warp"))
        yield scene


def add_bases(scene: Path) -> None:
    """Bases beside the scene, as live changes ask for, where there are none."""
    file = scene.with_suffix(".bases")
    if not file.exists():
        tw.solve_bases(tw.load_scene(scene), tolerance_mm=0.5).save(file)


@contextmanager
def served(scene: Path) -> Iterator[tuple[str, Browser]]:
    """The address of the scene's page, and a browser to open it in."""
    server = Server(scene)
    server.start()
    program, source = obtain_chromium()
    print(f"browser: {source}")
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=program, args=list(FLAGS))
            yield server.url, browser
            browser.close()
    finally:
        server.stop()
