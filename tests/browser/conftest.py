"""A real browser for the tests of the page; see chromium.py for where it comes from."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright

import touchwarp as tw
from tests.browser.chromium import FLAGS, obtain_chromium
from tests.browser.desk import LONG
from tests.browser.headset import Headset
from tests.browser.person import Person, RealProp
from tests.browser.server import Server

SCENE = """\
# a ball on a table, felt 15 mm beside where it is and larger
[objective]
tolerance_mm = 0.5

[outer]
box = { min = [-0.2, -0.2, -0.1], max = [0.2, 0.2, 0.25] }

[[prop]]
name = "ball"
shape = { kind = "ellipsoid", size = [0.1, 0.1, 0.1] }
pose = { position = [0, 0, 0.06] }

[prop.goal]
kind = "transform"
scale = [1.2, 1.2, 1.1]
translation = [0.015, 0, 0]    # to the right

[[fixed]]
name = "table"
plane = { point = [0, 0, 0], normal = [0, 0, 1] }
"""

MUG_SCENE = """\
[objective]
tolerance_mm = 0.5

[[prop]]
name = "mug"
shape = { kind = "mug" }

[prop.goal]
kind = "transform"
pivot = [0, 0, 0]
scale = [1.2, 1.2, 0.6]
translation = [0.015, 0, 0]

[[fixed]]
name = "table"
plane = { point = [0, 0, 0], normal = [0, 0, 1] }
contact = "slide"
"""

expect.set_options(timeout=LONG)

THROTTLE = float(os.environ.get("TOUCHWARP_CPU_THROTTLE", "1"))
"""How many times slower the page's processor is made, to find what only holds on a fast one."""

Enter = Callable[..., Person]

SHOTS = Path(__file__).resolve().parents[2] / "build" / "screenshots"


@pytest.fixture(scope="session")
def chromium(pytestconfig: pytest.Config) -> Iterator[Browser]:
    """The browser, started once."""
    program, source = obtain_chromium()
    reporter = pytestconfig.pluginmanager.get_plugin("terminalreporter")
    if reporter is not None:
        reporter.write_line(f"\nbrowser tests run in {source}")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=list(FLAGS))
        yield browser
        browser.close()


@pytest.fixture
def page(chromium: Browser, serve: Callable[[Path], Server]) -> Iterator[Page]:
    """A fresh tab, 960 × 560; errors that its scripts throw or log fail the test.

    It is closed before servers end (hence `serve`), so that it does not miss them.
    """
    context = chromium.new_context(viewport={"width": 960, "height": 560}, ignore_https_errors=True)
    tab = context.new_page()
    tab.set_default_timeout(LONG)
    if THROTTLE != 1.0:
        session = context.new_cdp_session(tab)
        session.send("Emulation.setCPUThrottlingRate", {"rate": THROTTLE})
    errors: list[str] = []
    tab.on("pageerror", lambda error: errors.append(str(error)))
    tab.on("console", lambda line: errors.append(line.text) if line.type == "error" else None)
    tab.expected_errors = []  # type: ignore[attr-defined]
    yield tab
    expected = tab.expected_errors  # type: ignore[attr-defined]
    context.close()
    assert [e for e in errors if not any(word in e for word in expected)] == []


@pytest.fixture(scope="session")
def screenshots() -> Path:
    """A folder, outside version control, where tests leave pictures to look at."""
    SHOTS.mkdir(parents=True, exist_ok=True)
    return SHOTS


@pytest.fixture
def serve(tmp_path: Path) -> Iterator[Callable[[Path], Server]]:
    """Starts `touchwarp view` for a scene or a warp; what was started is ended."""
    started: list[Server] = []

    def start(path: Path) -> Server:
        server = Server(path)
        started.append(server)
        server.start()
        return server

    yield start
    for server in started:
        server.stop()


@pytest.fixture(scope="session")
def share() -> Iterator[Callable[[Path], Server]]:
    """As `serve`, for scenes that no test changes: one server for all of them."""
    started: dict[Path, Server] = {}

    def start(path: Path) -> Server:
        if path not in started:
            started[path] = Server(path)
            started[path].start()
        return started[path]

    yield start
    for server in started.values():
        server.stop()


def solved(folder: Path, name: str, text: str) -> Path:
    """A folder with a scene, its warp and its bases."""
    path = folder / f"{name}.toml"
    path.write_text(text)
    scene = tw.load_scene(path)
    tw.solve(scene).save(path.with_suffix(".warp"))
    tw.solve_bases(scene, tolerance_mm=0.5).save(path.with_suffix(".bases"))
    return folder


@pytest.fixture(scope="session")
def ball_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scene that is quick to solve, solved: ball.toml, ball.warp and ball.bases; copy it."""
    return solved(tmp_path_factory.mktemp("ball-scene"), "ball", SCENE)


@pytest.fixture(scope="session")
def mug_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same for a mug."""
    return solved(tmp_path_factory.mktemp("mug-scene"), "mug", MUG_SCENE)


@pytest.fixture
def ball(ball_folder: Path, tmp_path: Path) -> Path:
    """The scene file, in a folder of its own, to be changed."""
    return Path(shutil.copytree(ball_folder, tmp_path / "scene")) / "ball.toml"


@pytest.fixture
def mug(mug_folder: Path, tmp_path: Path) -> Path:
    """The scene file, in a folder of its own, to be changed."""
    return Path(shutil.copytree(mug_folder, tmp_path / "scene")) / "mug.toml"


@pytest.fixture
def ball_server(share: Callable[[Path], Server], ball_folder: Path) -> Server:
    """Serves the ball to tests that change nothing."""
    return share(ball_folder / "ball.toml")


@pytest.fixture
def mug_server(share: Callable[[Path], Server], mug_folder: Path) -> Server:
    """Serves the mug to tests that change nothing."""
    return share(mug_folder / "mug.toml")


@pytest.fixture
def enter(page: Page, mug_server: Server) -> Enter:
    """Puts the headset on and goes in to the mug; nothing is touched yet."""

    def inside(noise: float = 0.0, said: tuple[str, ...] = (), **options: Any) -> Person:
        page.set_viewport_size({"width": 1280, "height": 640})
        headset = Headset(page, **options)
        headset.open(mug_server.url)
        headset.enter(*said)
        return Person(headset, RealProp(tw.load_scene(mug_server.path).props[0]), noise)

    return inside
