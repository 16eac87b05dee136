"""A small scene on disk, its warp in closed form, and a server for them without a network."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from starlette.testclient import TestClient
from starlette.types import ASGIApp

from tests.cli.conftest import SCENE, ball_exact, ball_table  # noqa: F401  (fixtures)
from touchwarp.live.access import Guard, Invitation
from touchwarp.live.application import make_application
from touchwarp.live.conversation import Hub
from touchwarp.live.opening import open_workbench
from touchwarp.live.reception import make_reception
from touchwarp.live.recordings import RecordingStore
from touchwarp.live.workbench import Workbench
from touchwarp.warp import TableWarp

LOCAL_PORT = 8600
REMOTE = "192.0.2.7:8601"
LIVE = f"ws://localhost:{LOCAL_PORT}/live"

COMMENTED = SCENE.replace(
    "translation = [0.01, 0, 0]", "translation = [0.01, 0, 0]    # one centimetre to the right"
)


class Served:
    """A server in this process, and what it serves."""

    def __init__(self, folder: Path, path: Path) -> None:
        self.path = path
        self.hub = Hub()
        self.store = RecordingStore(folder / "recordings")
        self.invitation = Invitation()
        tables = folder / "tables"
        tables.mkdir()
        self.workbench: Workbench = open_workbench(path, tables, self.hub.tell)
        self.hub.serve(self.workbench, self.store)
        page = folder / "page"
        (page / "assets").mkdir(parents=True)
        (page / "index.html").write_text("<!doctype html><title>the page</title>")
        (page / "assets" / "a.js").write_text("1")
        scene = make_application(self.workbench, self.hub, self.store, local_port=LOCAL_PORT)

        async def opened() -> ASGIApp:
            return scene

        reception = make_reception(page, self.invitation, opened)
        self.app = Guard(reception, LOCAL_PORT, REMOTE, self.invitation)

    def client(self, base: str = f"http://localhost:{LOCAL_PORT}") -> TestClient:
        return TestClient(self.app, base_url=base)


@pytest.fixture
def ball_path(tmp_path: Path) -> Path:
    """A commented scene file, alone in its folder but for a file that is nobody's business."""
    folder = tmp_path / "scene"
    folder.mkdir()
    (folder / "secret.txt").write_text("secret")
    path = folder / "ball.toml"
    path.write_text(COMMENTED)
    return path


@pytest.fixture
def served(tmp_path: Path, ball_path: Path, ball_table: TableWarp) -> Iterator[Served]:  # noqa: F811
    """The scene with its warp beside it; no work is begun."""
    ball_table.save(ball_path.with_suffix(".warp"))
    server = Served(tmp_path, ball_path)
    yield server
    server.workbench.close()


@pytest.fixture
def client(served: Served) -> Iterator[TestClient]:
    """A browser on this machine."""
    with served.client() as client:
        yield client


@pytest.fixture
def rows() -> Callable[..., np.ndarray]:
    """Rows of a recording with numbers that only full precision keeps."""

    def make(count: int, columns: int, seed: int = 0) -> np.ndarray:
        values = np.random.default_rng(seed).normal(size=(count, columns)) * np.pi
        values[0, -1] = np.nan
        return values

    return make
