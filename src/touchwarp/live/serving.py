"""Serving the built page and then the scene, here and to a headset, and what is printed for both.

What takes its time to be loaded is so in a thread, once the address has been told and the page is
served: a browser loads the page meanwhile and waits for the scene.
"""

from __future__ import annotations

import asyncio
import contextlib
import io
import tempfile
import threading
import webbrowser
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from touchwarp.errors import LiveError
from touchwarp.live.addresses import LOCAL, bracketed, chosen_address, listen

if TYPE_CHECKING:
    from starlette.types import ASGIApp

    from touchwarp.live.access import Invitation
    from touchwarp.live.https import HttpsIdentity
    from touchwarp.live.servers import Servers
    from touchwarp.live.workbench import Workbench

PAGE = Path(__file__).parent / "page"

ANSWERED = 0.2
"""s, in which a page that has waited for the scene is told it, before work begins."""

Say = Callable[[str], None]


@dataclass(frozen=True)
class Settings:
    """How to serve.

    Attributes:
        path: a scene file, a warp or bases.
        port: on this machine's own address; the network address gets the next one. 0: any free.
        host: the network address to serve on as well; "" for none; one of `addresses.FIND` to find
            it.
        recordings: the folder for recordings.
        open_browser: open the page here.
    """

    path: Path
    port: int
    host: str
    recordings: Path
    open_browser: bool


@dataclass(frozen=True)
class Ended:
    """How it ended: with which exit code, and whether all work had stopped by then."""

    exit_code: int
    work_stopped: bool


def serve(settings: Settings, say: Say) -> Ended:
    """Serve until interrupted.

    Args:
        settings: how.
        say: prints a line.

    Raises:
        SceneError, GoalError, WarpFileError: the file cannot be shown.
        LiveError: the page is not built, or an address cannot be used.
        OutputError: no place for a certificate.
    """
    page = built_page()
    local = listen(LOCAL, settings.port)
    port = int(local.getsockname()[1])
    with contextlib.ExitStack() as stack:
        stack.callback(local.close)
        remote, identity, address = None, None, ""
        if settings.host:
            address = chosen_address(settings.host)
            remote = listen(address, port + 1 if settings.port else 0)
            stack.callback(remote.close)
        if settings.path.exists():  # what is missing is told of below
            say(f"{settings.path.name} is at http://localhost:{port} (Ctrl-C ends it).")

        from touchwarp.live.access import Guard, Invitation
        from touchwarp.live.reception import make_reception
        from touchwarp.live.servers import Server, Servers

        invitation = Invitation()
        if remote is not None:
            from platformdirs import user_data_path

            from touchwarp.live.https import identity_for

            identity = identity_for(address, user_data_path("touchwarp", appauthor=False) / "https")
            address = f"{bracketed(address)}:{remote.getsockname()[1]}"
            shown = identity

            def invite(new: Invitation) -> None:
                say(invitation_text(address, new, shown, port))

            invitation.renewed = invite
            invite(invitation)
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="touchwarp-view-")))
        opening = _Opening(settings, folder, port)
        app = Guard(
            make_reception(page, invitation, opening.application), port, address or None, invitation
        )
        there = [] if remote is None or identity is None else [Server(app, remote, identity)]
        servers = Servers(Server(app, local), *there)
        if settings.open_browser and settings.path.exists():
            webbrowser.open(f"http://localhost:{port}")
        with servers.ended_by_signals():
            asyncio.run(_run(servers, opening))
            work_stopped = opening.close()
            stack.close()  # here, where no signal interrupts it
        return Ended(servers.exit_code, work_stopped)


class _Opening:
    """The scene on its way: libraries and files are loaded in a thread of their own."""

    def __init__(self, settings: Settings, folder: Path, port: int) -> None:
        self._settings, self._folder, self._port = settings, folder, port
        self._workbench: Workbench | None = None
        self._opened: asyncio.Future[ASGIApp] | None = None

    @property
    def opened(self) -> asyncio.Future[ASGIApp]:
        """Of the running loop: the scene's application, or why there is none."""
        if self._opened is None:
            self._opened = asyncio.get_running_loop().create_future()
        return self._opened

    def begin(self) -> None:
        """Open it, in the background."""
        loop, opened = asyncio.get_running_loop(), self.opened

        def tell(outcome: ASGIApp | BaseException) -> None:
            if opened.cancelled():
                return
            if isinstance(outcome, BaseException):
                opened.set_exception(outcome)
            else:
                opened.set_result(outcome)
                assert self._workbench is not None
                # kernels keep the interpreter to themselves: who waits is answered before
                loop.call_later(ANSWERED, self._workbench.start)

        def work() -> None:
            outcome: ASGIApp | BaseException
            try:
                outcome = self._open()
            except BaseException as error:  # whatever it is, it is raised where it is waited for
                outcome = error
            with contextlib.suppress(RuntimeError):  # the loop has ended meanwhile
                loop.call_soon_threadsafe(tell, outcome)

        # a daemon: the program may be ended before
        threading.Thread(target=work, name="opening", daemon=True).start()

    async def application(self) -> ASGIApp:
        """The scene's application, once it is there.

        Raises:
            TouchwarpError: it will not be there.
        """
        try:
            return await asyncio.shield(self.opened)
        except asyncio.CancelledError:
            if self.opened.cancelled():
                raise LiveError("It was ended before the scene was open.") from None
            raise

    def close(self) -> bool:
        """Stop all work; whether that came in time."""
        return self._workbench is not None and self._workbench.close()

    def _open(self) -> ASGIApp:
        from touchwarp.live.application import make_application
        from touchwarp.live.conversation import Hub
        from touchwarp.live.opening import open_workbench
        from touchwarp.live.recordings import RecordingStore

        hub = Hub()
        workbench = open_workbench(self._settings.path, self._folder, hub.tell)
        store = RecordingStore(self._settings.recordings)
        hub.serve(workbench, store)
        self._workbench = workbench
        return make_application(workbench, hub, store, local_port=self._port)


def built_page() -> Path:
    """The folder of the built page.

    Raises:
        LiveError: it is not built.
    """
    if not (PAGE / "index.html").exists():
        raise LiveError(
            "The page is not built. In a checkout, run 'python web/build_page.py' or 'make demo'; "
            "an installed touchwarp has it: install it again."
        )
    return PAGE


def invitation_text(
    address: str, invitation: Invitation, identity: HttpsIdentity, local_port: int
) -> str:
    """What a person needs to open the page in a headset."""
    import segno

    from touchwarp.live.access import ENTRANCE

    link = f"https://{address}{ENTRANCE}?token={invitation.token}"
    drawn = io.StringIO()
    segno.make(link, error="l").terminal(drawn, compact=True, border=2)
    return "\n".join(
        [
            "",
            "In the headset's browser, one of:",
            drawn.getvalue(),
            f"  1. Scan this, or open  {link}",
            f"     or open  https://{address}  and type the code  {invitation.code}",
            "     (good for one browser; then a new pair is shown). The browser warns once, as the",
            "     certificate is this machine's own: choose Advanced, then Proceed. Its SHA-256 is",
            f"     {identity.fingerprint}",
            "  2. By cable, where the network keeps devices apart:",
            f"     adb reverse tcp:{local_port} tcp:{local_port}",
            f"     then open  http://localhost:{local_port}  in the headset.",
            "",
        ]
    )


async def _run(servers: Servers, opening: _Opening) -> None:
    """Run all servers until they are ended or there is no scene."""

    async def open_scene() -> None:
        await servers.started()  # the page first
        try:
            opening.begin()
            await opening.opened
        except BaseException:
            servers.end()
            raise

    async def let_go() -> None:
        await servers.ending()
        opening.opened.cancel()  # pages that wait for it are not waited for

    scene = asyncio.create_task(open_scene())
    letting_go = asyncio.create_task(let_go())
    await servers.run()
    await letting_go
    if scene.done() and not scene.cancelled():
        scene.result()
    scene.cancel()
