"""Who may connect.

This machine's own address serves whoever is on this machine (and a headset whose port is led here
by `adb reverse`). A network address serves only browsers that have shown the token of the printed
link, or the printed code, each of which is good for one browser. On either, requests that a foreign
page makes a browser send are turned away: by the name they ask for (DNS rebinding) and by their
origin.
"""

from __future__ import annotations

import hmac
import secrets
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from urllib.parse import urlsplit

from starlette.datastructures import Headers
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocketClose

COOKIE = "touchwarp"
ENTRANCE = "/enter"
LOCAL_NAMES = frozenset({"localhost", "127.0.0.1", "[::1]"})
SECONDS_BETWEEN_TRIES = 1.0
TRIES_A_CODE = 10
MOST_BYTES = 4 << 20
"""Of one message; a second of two hands takes half a megabyte."""

HEADERS = {
    "Content-Security-Policy": (
        "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
        "worker-src 'self' blob:; connect-src 'self' ws: wss:; object-src 'none'; "
        "base-uri 'none'; frame-ancestors 'none'; form-action 'self'"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
}


@dataclass
class Invitation:
    """A token for a link and a code for typing; whichever is shown first uses up both.

    Attributes:
        renewed: called when there is a new pair to show.
        clock: s; replaced in tests.
    """

    renewed: Callable[[Invitation], None] = lambda invitation: None
    clock: Callable[[], float] = time.monotonic
    token: str = ""
    code: str = ""
    _sessions: set[str] = field(default_factory=set)
    _tries: int = 0
    _next_try: float = 0.0

    def __post_init__(self) -> None:
        self._renew()

    def redeem(self, secret: str) -> str | None:
        """A session for the right token or code, else None; wrong ones cost time."""
        now = self.clock()
        if now < self._next_try:
            return None
        given = secret.strip().encode()
        right = any(hmac.compare_digest(given, s.encode()) for s in (self.token, self.code))
        if not right:
            self._next_try = now + SECONDS_BETWEEN_TRIES
            self._tries += 1
            if self._tries >= TRIES_A_CODE:
                self._renew()
                self.renewed(self)
            return None
        session = secrets.token_urlsafe(24)
        self._sessions.add(session)
        self._renew()
        self.renewed(self)
        return session

    def knows(self, session: str) -> bool:
        """Whether a session was given out here."""
        return any(hmac.compare_digest(session.encode(), s.encode()) for s in self._sessions)

    def _renew(self) -> None:
        self.token = secrets.token_urlsafe(16)
        self.code = f"{secrets.randbelow(10**6):06d}"
        self._tries = 0


class Guard:
    """Lets in what may come in, and adds the headers that keep foreign content out.

    Args:
        app: what is guarded.
        local_port: of the listener on this machine's own address.
        remote: "host:port" of the network listener, or None.
        invitation: for the network listener.
    """

    def __init__(
        self, app: ASGIApp, local_port: int, remote: str | None, invitation: Invitation
    ) -> None:
        self._app = app
        self._local_port = local_port
        self._remote = remote
        self._invitation = invitation

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """ASGI."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        refusal = self._refusal(scope)
        if refusal is None:
            await self._app(scope, receive, _with_headers(send))
        elif scope["type"] == "websocket":
            await WebSocketClose(code=4403, reason="not allowed")(scope, receive, send)
        else:
            await refusal(scope, receive, _with_headers(send))

    def _refusal(self, scope: Scope) -> Response | None:
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        name = host.rsplit(":", 1)[0] if not host.endswith("]") else host
        local = self._is_local(scope)
        known = name in LOCAL_NAMES if local else host == self._remote
        if not known:
            return PlainTextResponse(
                "This server goes by another name; use the printed address.\n", 421
            )
        origin = headers.get("origin")
        if origin is not None and urlsplit(origin).netloc != host:
            return PlainTextResponse("Pages of other sites may not ask here.\n", 403)
        if scope["type"] == "websocket" and origin is None and not local:
            return PlainTextResponse("A browser's own page is needed.\n", 403)
        if local or scope["path"] == ENTRANCE or self._invitation.knows(_session(headers)):
            return None
        if scope["path"] == "/":
            return RedirectResponse(ENTRANCE, 303)
        return PlainTextResponse("Enter by the printed link or code first.\n", 401)

    def _is_local(self, scope: Scope) -> bool:
        server: Iterable[object] | None = scope.get("server")
        return server is not None and tuple(server)[1] == self._local_port


def _session(headers: Headers) -> str:
    try:
        morsel = SimpleCookie(headers.get("cookie", "")).get(COOKIE)
    except CookieError:
        return ""
    return "" if morsel is None else morsel.value


def _with_headers(send: Send) -> Send:
    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            extra = [(k.lower().encode(), v.encode()) for k, v in HEADERS.items()]
            message = {**message, "headers": [*message.get("headers", []), *extra]}
        await send(message)

    return sending
