"""The ASGI application of `touchwarp view`.

    /                      the page; /assets/… its parts
    /enter                 where a headset shows its token or code
    /boot.json             the scene's state
    /tables/IDENTITY.KIND  warp and bases as float16, with byte ranges
    /surfaces/KEY.bin      what is drawn
    /recordings.json       what was recorded here, and /recordings/… it, to this machine only
    /live                  the WebSocket: see `touchwarp.live.messages`

Nothing is found by path: every answer is an entry of a table in memory, so no file beside the page
and what was made for it can be asked for.
"""

from __future__ import annotations

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from html import escape
from pathlib import Path
from urllib.parse import parse_qs

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse, HTMLResponse, RedirectResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp

from touchwarp.live.access import COOKIE, ENTRANCE, Guard, Invitation
from touchwarp.live.conversation import Hub
from touchwarp.live.recordings import RecordingStore
from touchwarp.live.workbench import Workbench

_CACHED = {"Cache-Control": "private, max-age=31536000, immutable"}
_FRESH = {"Cache-Control": "no-store"}

_ENTRANCE_PAGE = """<!doctype html>
<html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>touchwarp</title>
<style>
body {{ font: 22px/1.5 system-ui, sans-serif; display: grid; place-content: center; height: 95vh;
        background: #14171b; color: #e8eaed; text-align: center; }}
input, button {{ font: inherit; font-size: 40px; width: 7em; padding: .3em; margin: .3em;
        text-align: center; border-radius: 12px; border: 2px solid #626c78; background: #1b1f25;
        color: inherit; letter-spacing: .15em; }}
button {{ background: #56b4e9; color: #14171b; border: 0; letter-spacing: 0; }}
</style>
<form method="post"><p>{text}</p>
<input name="code" inputmode="numeric" autocomplete="off" autofocus maxlength="40"
       aria-label="code"><br>
<button>Enter</button></form></html>
"""


def make_application(
    workbench: Workbench,
    hub: Hub,
    recordings: RecordingStore | None,
    page: Path,
    *,
    local_port: int,
    remote: str | None = None,
    invitation: Invitation | None = None,
) -> ASGIApp:
    """The application, guarded.

    Args:
        workbench: what is shown.
        hub: the conversations with pages.
        recordings: where recordings go; None where none are kept.
        page: the folder that holds the built page.
        local_port, remote, invitation: see `Guard`.
    """
    invitation = invitation or Invitation()

    async def boot(request: Request) -> Response:
        return Response(workbench.state.model_dump_json(), 200, _FRESH, "application/json")

    async def table(request: Request) -> Response:
        path = workbench.file(request.path_params["name"].rsplit(".", 1)[0])
        if path is None:
            raise HTTPException(404, "There is no such table (any more).")
        return FileResponse(path, headers=_CACHED, media_type="application/octet-stream")

    async def surface(request: Request) -> Response:
        packed = workbench.surface(request.path_params["name"].removesuffix(".bin"))
        if packed is None:
            raise HTTPException(404, "There is no such surface (any more).")
        return Response(packed, 200, _CACHED, "application/octet-stream")

    async def enter(request: Request) -> Response:
        text = "Type the code that the terminal shows."
        secret = request.query_params.get("token", "")
        if request.method == "POST":
            secret = await _posted_code(request)
        if secret:
            session = invitation.redeem(secret)
            if session is not None:
                answer = RedirectResponse("/", 303, _FRESH)
                secure = request.url.scheme == "https"
                answer.set_cookie(COOKIE, session, httponly=True, samesite="strict", secure=secure)
                return answer
            text = "That is not the code shown now (each is good for one browser). Wait a second."
        return HTMLResponse(_ENTRANCE_PAGE.format(text=escape(text)), headers=_FRESH)

    async def listing(request: Request) -> Response:
        _on_this_machine(request, local_port)
        known = [] if recordings is None else list(recordings.all())
        rows = [
            {
                "participant": r.participant,
                "recording": r.identifier,
                "started": r.about["started"],
                "ended": r.ended,
            }
            for r in known
        ]
        return Response(json.dumps(rows), 200, _FRESH, "application/json")

    async def replay(request: Request) -> Response:
        _on_this_machine(request, local_port)
        wanted = request.path_params["participant"], request.path_params["recording"]
        for recording in [] if recordings is None else recordings.all():
            if (recording.participant, recording.identifier) == wanted:
                names, rows = await run_in_threadpool(recording.rows)
                head = json.dumps({"columns": names, "rows": len(rows)}).encode()
                head += b" " * (-(4 + len(head)) % 8)
                body = len(head).to_bytes(4, "little") + head + rows.astype("<f8").tobytes()
                return Response(body, 200, _FRESH, "application/octet-stream")
        raise HTTPException(404, "There is no such recording.")

    async def index(request: Request) -> Response:
        return FileResponse(page / "index.html", headers=_FRESH)

    @asynccontextmanager
    async def running(app: Starlette) -> AsyncIterator[None]:
        hub.start()
        yield
        hub.stop()

    app = Starlette(
        routes=[
            Route("/", index),
            Route(ENTRANCE, enter, methods=["GET", "POST"]),
            Route("/boot.json", boot),
            Route("/tables/{name}", table),
            Route("/surfaces/{name}", surface),
            Route("/recordings.json", listing),
            Route("/recordings/{participant}/{recording}", replay),
            WebSocketRoute("/live", hub.talk),
            Mount("/assets", StaticFiles(directory=page / "assets", check_dir=False)),
        ],
        lifespan=running,
    )
    return Guard(app, local_port, remote, invitation)


async def _posted_code(request: Request) -> str:
    body = b""
    async for part in request.stream():
        body += part
        if len(body) > 1000:
            raise HTTPException(413, "A code is shorter.")
    return parse_qs(body.decode("ascii", "replace")).get("code", [""])[0]


def _on_this_machine(request: Request, local_port: int) -> None:
    server = request.scope.get("server")
    if server is None or server[1] != local_port:
        raise HTTPException(403, "Recordings are shown on the machine that keeps them only.")
