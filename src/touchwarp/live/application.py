"""The ASGI application of one scene in `touchwarp view`; the page itself is in `reception`.

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

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp

from touchwarp.live.conversation import Hub
from touchwarp.live.reception import FRESH
from touchwarp.live.recordings import RecordingStore
from touchwarp.live.workbench import Workbench

_CACHED = {"Cache-Control": "private, max-age=31536000, immutable"}


def make_application(
    workbench: Workbench,
    hub: Hub,
    recordings: RecordingStore | None,
    *,
    local_port: int,
) -> ASGIApp:
    """The application, not yet guarded.

    Args:
        workbench: what is shown.
        hub: the conversations with pages.
        recordings: where recordings go; None where none are kept.
        local_port: of the listener on this machine's own address.
    """

    async def boot(request: Request) -> Response:
        return Response(workbench.state.model_dump_json(), 200, FRESH, "application/json")

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
        return Response(json.dumps(rows), 200, FRESH, "application/json")

    async def replay(request: Request) -> Response:
        _on_this_machine(request, local_port)
        wanted = request.path_params["participant"], request.path_params["recording"]
        for recording in [] if recordings is None else recordings.all():
            if (recording.participant, recording.identifier) == wanted:
                names, rows = await run_in_threadpool(recording.rows)
                head = json.dumps({"columns": names, "rows": len(rows)}).encode()
                head += b" " * (-(4 + len(head)) % 8)
                body = len(head).to_bytes(4, "little") + head + rows.astype("<f8").tobytes()
                return Response(body, 200, FRESH, "application/octet-stream")
        raise HTTPException(404, "There is no such recording.")

    return Starlette(
        routes=[
            Route("/boot.json", boot),
            Route("/tables/{name}", table),
            Route("/surfaces/{name}", surface),
            Route("/recordings.json", listing),
            Route("/recordings/{participant}/{recording}", replay),
            WebSocketRoute("/live", hub.talk),
        ]
    )


def _on_this_machine(request: Request, local_port: int) -> None:
    server = request.scope.get("server")
    if server is None or server[1] != local_port:
        raise HTTPException(403, "Recordings are shown on the machine that keeps them only.")
