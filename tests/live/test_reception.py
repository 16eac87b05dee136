"""While a scene is being opened the page is served; what is asked of the scene waits for it."""

from __future__ import annotations

import asyncio
from pathlib import Path

import httpx2
import pytest
from anyio.from_thread import start_blocking_portal
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp

from touchwarp.errors import SceneError
from touchwarp.live.access import Invitation
from touchwarp.live.reception import make_reception


@pytest.fixture
def page(tmp_path: Path) -> Path:
    (tmp_path / "assets").mkdir()
    (tmp_path / "index.html").write_text("the page")
    (tmp_path / "assets" / "a.js").write_text("its script")
    return tmp_path


async def get(app: ASGIApp, path: str) -> tuple[int, str]:
    """Status and body."""
    transport = httpx2.ASGITransport(app=app)
    async with httpx2.AsyncClient(transport=transport, base_url="http://localhost") as client:
        answer = await client.get(path)
    return answer.status_code, answer.text


def test_the_page_comes_at_once_and_the_scene_when_it_is_open(page: Path) -> None:
    async def visit() -> None:
        opened: asyncio.Future[ASGIApp] = asyncio.get_running_loop().create_future()
        app = make_reception(page, Invitation(), lambda: asyncio.shield(opened))
        scene = asyncio.create_task(get(app, "/boot.json"))
        assert await get(app, "/") == (200, "the page")
        assert await get(app, "/assets/a.js") == (200, "its script")
        assert (await get(app, "/enter"))[0] == 200
        assert not scene.done()
        opened.set_result(PlainTextResponse("the scene"))
        assert await scene == (200, "the scene")
        assert await get(app, "/") == (200, "the page")

    with (
        start_blocking_portal() as portal
    ):  # a thread of its own: a browser's tests have a loop here
        portal.call(visit)


def test_why_there_is_no_scene_is_told_to_who_waits(page: Path) -> None:
    async def no_scene() -> ASGIApp:
        raise SceneError("prop 1 has no name")

    async def visit() -> None:
        app = make_reception(page, Invitation(), no_scene)
        assert await get(app, "/boot.json") == (503, "prop 1 has no name")
        assert await get(app, "/") == (200, "the page")

    with (
        start_blocking_portal() as portal
    ):  # a thread of its own: a browser's tests have a loop here
        portal.call(visit)
