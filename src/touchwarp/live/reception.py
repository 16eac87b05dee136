"""What is served at once, while the scene is still being opened: the page and the way in.

    /                      the page; /assets/… its parts
    /enter                 where a headset shows its token or code
    everything else        waits for the scene's own application

So a browser loads the page while this process loads its libraries. Imports here are light.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from html import escape
from pathlib import Path
from urllib.parse import parse_qs

from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import (
    FileResponse,
    HTMLResponse,
    PlainTextResponse,
    RedirectResponse,
    Response,
)
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocketClose

from touchwarp.errors import TouchwarpError
from touchwarp.live.access import COOKIE, ENTRANCE, Invitation

FRESH = {"Cache-Control": "no-store"}

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


def make_reception(
    page: Path, invitation: Invitation, scene: Callable[[], Awaitable[ASGIApp]]
) -> ASGIApp:
    """The application of a whole server, not yet guarded.

    Args:
        page: the folder that holds the built page.
        invitation: what opens the way in.
        scene: waits for the scene's application; its TouchwarpError is told to who asks for it.
    """

    async def index(request: Request) -> Response:
        return FileResponse(page / "index.html", headers=FRESH)

    async def enter(request: Request) -> Response:
        text = "Type the code that the terminal shows."
        secret = request.query_params.get("token", "")
        if request.method == "POST":
            secret = await _posted_code(request)
        if secret:
            session = invitation.redeem(secret)
            if session is not None:
                answer = RedirectResponse("/", 303, FRESH)
                secure = request.url.scheme == "https"
                answer.set_cookie(COOKIE, session, httponly=True, samesite="strict", secure=secure)
                return answer
            text = "That is not the code shown now (each is good for one browser). Wait a second."
        return HTMLResponse(_ENTRANCE_PAGE.format(text=escape(text)), headers=FRESH)

    async def wait(scope: Scope, receive: Receive, send: Send) -> None:
        answer: ASGIApp
        try:
            answer = await scene()
        except TouchwarpError as error:
            if scope["type"] == "websocket":
                answer = WebSocketClose(code=1011, reason="the scene cannot be opened")
            else:
                answer = PlainTextResponse(str(error), 503, FRESH)
        await answer(scope, receive, send)

    return Starlette(
        routes=[
            Route("/", index),
            Route(ENTRANCE, enter, methods=["GET", "POST"]),
            Mount("/assets", StaticFiles(directory=page / "assets", check_dir=False)),
            Mount("", wait),
        ]
    )


async def _posted_code(request: Request) -> str:
    body = b""
    async for part in request.stream():
        body += part
        if len(body) > 1000:
            raise HTTPException(413, "A code is shorter.")
    return parse_qs(body.decode("ascii", "replace")).get("code", [""])[0]
