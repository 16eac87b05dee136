"""`touchwarp demo`: the whole way once, on a mug felt as a tea cup (the paper's Figure 1)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from touchwarp import Report, Scene, TableWarp
    from touchwarp.check import Check


@dataclass(frozen=True)
class Made:
    """What the demo has made of one goal.

    Attributes:
        warp: the table.
        report: its certificate.
        seconds: from the mesh file to the saved warp; for the instant goal the combination alone.
        seconds_before: what had to be solved once before that; 0 for a plain solve.
    """

    warp: TableWarp
    report: Report
    seconds: float
    seconds_before: float = 0.0


@click.command(
    "demo",
    epilog="\b\nExamples:\n  touchwarp demo\n  touchwarp demo -o mug-demo",
)
@click.option(
    "-o",
    "--output",
    "folder",
    type=click.Path(path_type=Path),
    default=Path("demo"),
    show_default=True,
    metavar="DIR",
    help="The folder to write to; made if missing.",
)
@click.option(
    "--tolerance-mm",
    type=click.FloatRange(min=0.01),
    default=0.1,
    show_default=True,
    metavar="T",
    help="Greatest error of the tables in mm; 1 is quicker.",
)
def demo_command(folder: Path, tolerance_mm: float) -> None:
    """Make a coffee mug on a table feel like a wide tea cup, and certify it.

    Writes the scene, the mug's mesh, the warp and its certificate with pictures; then, by instant
    goals and so with no new solve, the same cup moved and turned.
    """
    from touchwarp.cli.demo_files import write_input
    from touchwarp.cli.terminal import in_bytes, in_words
    from touchwarp.outputs import claim_folder

    claim_folder(folder)
    write_input(folder, tolerance_mm)
    click.echo(f"Input   {folder / 'mug.toml'}: a coffee mug on a table, felt as a wide tea cup.")
    cup = make_cup(folder)
    size = in_bytes((folder / "mug.warp").stat().st_size)
    click.echo(f"Solved  {folder / 'mug.warp'} ({size}) in {in_words(cup.seconds)}.")
    click.echo(f"Checked {folder / 'mug.html'} in {in_words(cup.report.facts['seconds'])}.")
    turned = make_turned_cup(folder)
    click.echo(
        f"Instant {folder / 'turned.warp'}, the cup moved and turned, with no new solve: bases are "
        f"solved once ({in_words(turned.seconds_before)}), each transform then takes "
        f"{in_words(turned.seconds)}; checked in {folder / 'turned.html'}."
    )
    click.echo()
    click.echo(closing_line(folder, cup))


def make_cup(folder: Path) -> Made:
    """Solve and check mug.toml; write mug.warp, its certificate and a picture."""
    import touchwarp as tw
    from touchwarp.cli.demo_picture import draw
    from touchwarp.cli.terminal import progress_bar

    start = perf_counter()
    with progress_bar("reading the scene") as progress:
        scene = tw.load_scene(folder / "mug.toml")
        warp = tw.solve(scene, progress=progress)
        warp.save(folder / "mug.warp")
    seconds = perf_counter() - start
    assert isinstance(warp, tw.TableWarp), "the mug's scene is in space"
    draw(scene, warp, folder / "mug.png")
    return Made(warp, certify(folder / "mug", scene, warp), seconds)


def make_turned_cup(folder: Path) -> Made:
    """Solve the bases of the props once and combine them for turned.toml; check that too."""
    import touchwarp as tw
    from touchwarp.cli.terminal import progress_bar

    start = perf_counter()
    scene = tw.load_scene(folder / "turned.toml")
    with progress_bar("solving the bases") as progress:
        bases = tw.solve_bases(scene, progress=progress)
    goals = tw.goals(scene).items()
    transforms = {name: goal.matrix for name, goal in goals if goal.matrix is not None}
    bases.table(transforms)  # compiles on the first run ever
    ready = perf_counter()
    warp = bases.table(transforms)
    combined = perf_counter()
    warp.save(folder / "turned.warp")
    report = certify(folder / "turned", scene, warp)
    return Made(warp, report, combined - ready, ready - start)


def certify(stem: Path, scene: Scene, warp: TableWarp) -> Report:
    """Check a warp and write what was found beside it, as JSON and as a page."""
    import touchwarp as tw
    from touchwarp.cli.terminal import progress_bar

    with progress_bar("checking") as progress:
        report = tw.check(scene, warp, progress=progress)
        report.save_json(stem.with_suffix(".json"))
        progress("drawing the page", 1.0)
        report.save_html(stem.with_suffix(".html"))
    return report


def closing_line(folder: Path, cup: Made) -> str:
    """What was made, how long it took, how exact it is, what to beware of, what to try next."""
    from touchwarp.cli.terminal import in_words

    contact = cup.report.of("contact.p99", "mug").value_text
    estimate = cup.warp.meta.estimated_error_max_mm
    verdict = f"the certificate warns of {_listed(cup.report.with_status('warn'))}"
    failures = cup.report.with_status("fail")
    if failures:
        verdict = f"the certificate fails it for {_listed(failures)}, and " + verdict.removeprefix(
            "the certificate "
        )
    return (
        f"Made a warp by which a mug is felt as a tea cup, in {in_words(cup.seconds)} from mesh to "
        f"saved table; it misses the cup by {contact} where the mug is touched (99th percentile), "
        f"and elsewhere by {estimate:.2g} mm at most (estimated); {verdict}. "
        f"Look at {folder / 'mug.html'}, then try: "
        f"touchwarp sample {folder / 'mug.warp'} {folder / 'hand.csv'}"
    )


def _listed(checks: tuple[Check, ...]) -> str:
    return (
        "; ".join(
            f"{c.title[0].lower()}{c.title[1:]}: {c.value_text} (limit {c.limit_text})"
            for c in checks
        )
        or "nothing"
    )
