"""`touchwarp check`: the certificate of a warp."""

from __future__ import annotations

from pathlib import Path

import click


@click.command(
    "check",
    epilog="\b\nExamples:\n"
    "  touchwarp check mug.toml mug.warp\n"
    "  touchwarp check mug.toml mug.warp --html report.html --json report.json",
)
@click.argument("scene", type=click.Path(path_type=Path))
@click.argument("warp", type=click.Path(path_type=Path))
@click.option(
    "--html", type=click.Path(path_type=Path), metavar="F", help="Write one page with pictures."
)
@click.option("--json", type=click.Path(path_type=Path), metavar="F", help="Write all numbers.")
def check_command(scene: Path, warp: Path, html: Path | None, json: Path | None) -> int:
    """Hold WARP against every promise that SCENE asks of it.

    Exit code 1 if a hard check fails; warnings and unknowns leave it 0.
    """
    import touchwarp as tw
    from touchwarp.cli.terminal import progress_bar, stdout_console
    from touchwarp.outputs import claim
    from touchwarp.warp.file import load_table

    for output in (html, json):
        if output is not None:
            claim(output, scene, warp)
    with progress_bar("reading the scene") as progress:
        report = tw.check(tw.load_scene(scene), load_table(warp), progress=progress)
        if json is not None:
            report.save_json(json)
        if html is not None:
            progress("drawing the page", 1.0)
            report.save_html(html)
    stdout_console().print(report)
    return 1 if report.status == "fail" else 0
