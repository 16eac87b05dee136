"""`touchwarp view`: a scene or a warp in the browser, on the desk or in a headset."""

from __future__ import annotations

import os
from pathlib import Path

import click


@click.command(
    "view",
    epilog="\b\nExamples:\n"
    "  touchwarp view mug.toml\n"
    "  touchwarp view mug.warp --no-browser\n"
    "  touchwarp view mug.toml --host\n"
    "  touchwarp view mug.toml --export page",
)
@click.argument("file", metavar="SCENE|WARP", type=click.Path(path_type=Path))
@click.option(
    "--host",
    is_flag=False,
    flag_value="auto",
    default="",
    metavar="[ADDRESS]",
    help="Serve a headset on the network too, by HTTPS, and print how to open the page there.",
)
@click.option(
    "--port",
    type=click.IntRange(0, 65534),
    default=8600,
    show_default=True,
    help="On this machine; the network gets the next one. 0 takes any free one.",
)
@click.option("--no-browser", is_flag=True, help="Do not open a browser here.")
@click.option(
    "--recordings",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="The folder for recordings; without it 'recordings' beside the file.",
)
@click.option(
    "--export",
    "export",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Write a page that any web host can serve, instead of serving it.",
)
def view_command(
    file: Path,
    host: str,
    port: int,
    no_browser: bool,
    recordings: Path | None,
    export: Path | None,
) -> int:
    """Show a scene file or a warp in the browser: see, probe and change it, by mouse or by hand.

    Only this machine can connect, unless --host is given.
    """
    if export is not None:
        from touchwarp.cli.terminal import in_bytes, progress_bar
        from touchwarp.live.export import export_page

        with progress_bar("reading the scene") as progress:
            size = export_page(file, export, progress)
        click.echo(
            f"{export}: {in_bytes(size)}. Serve it by any web host; a headset needs HTTPS. To try "
            f"it here: python -m http.server -d {export}"
        )
        return 0
    from touchwarp.live.serving import Settings, serve

    folder = recordings or file.parent / "recordings"
    ended = serve(Settings(file, port, host, folder, not no_browser), click.echo)
    if not ended.work_stopped:
        # A solve between two of its steps cannot be interrupted, and nothing of it will be kept;
        # recordings are on disk and temporary files removed.
        os._exit(ended.exit_code)
    return ended.exit_code
