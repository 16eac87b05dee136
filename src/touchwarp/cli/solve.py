"""`touchwarp solve`: from a scene file to a warp file."""

from __future__ import annotations

import json
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from touchwarp.warp import PlaneTableWarp, TableWarp


@click.command(
    "solve",
    epilog="\b\nExamples:\n"
    "  touchwarp solve mug.toml -o mug.warp\n"
    "  touchwarp solve mug.toml -o coarse.warp --tolerance-mm 0.5\n"
    "  touchwarp solve mug.toml -o local.warp --lambda 10 --json",
)
@click.argument("scene", type=click.Path(path_type=Path))
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), required=True, help="The warp file to write."
)
@click.option(
    "--tolerance-mm",
    type=float,
    metavar="T",
    help="Greatest error of the table in mm, instead of the scene's.",
)
@click.option(
    "--lambda",
    "mismatch_weight",
    type=float,
    metavar="L",
    help="Mismatch weight λ (no unit), instead of the scene's: larger keeps the warp nearer the "
    "prop.",
)
@click.option(
    "--memory-limit-gb",
    type=float,
    default=4.0,
    show_default=True,
    metavar="G",
    help="Stop before the solve, with the tolerance that would fit, if it needs more.",
)
@click.option(
    "--float16", is_flag=True, help="Half the file; `touchwarp info` tells the error this adds."
)
@click.option("--json", "as_json", is_flag=True, help="Tell the result as JSON on stdout.")
def solve_command(
    scene: Path,
    output: Path,
    tolerance_mm: float | None,
    mismatch_weight: float | None,
    memory_limit_gb: float,
    float16: bool,
    as_json: bool,
) -> None:
    """Solve the scene file SCENE and write its warp."""
    from touchwarp.cli import terminal
    from touchwarp.outputs import claim

    claim(output, scene)
    start = perf_counter()
    import touchwarp as tw

    loaded = tw.load_scene(scene)
    if mismatch_weight is not None:
        loaded = loaded.with_objective(mismatch_weight=mismatch_weight)
    with terminal.progress_bar("reading the scene") as progress:
        warp = tw.solve(
            loaded,
            tolerance_mm=tolerance_mm,
            memory_limit_gb=memory_limit_gb,
            progress=progress,
        )
        progress("writing", 1.0)
        warp.save(output, "float16" if float16 else "float32")
    facts = solved_facts(warp, output, perf_counter() - start)
    if as_json:
        click.echo(json.dumps(facts, indent=2))
        return
    click.echo(
        f"{output}: {facts['nodes']:,} nodes, estimated error "
        f"{facts['estimated_error_max_mm']:.2g} mm at most (tolerance {facts['tolerance_mm']:g} "
        f"mm), {terminal.in_bytes(facts['bytes'])}, {terminal.in_words(facts['seconds'])}."
    )
    for note in facts["notes"]:
        click.echo(f"Note: {note}")
    click.echo(f"Next: touchwarp check {scene} {output} --html {output.with_suffix('.html')}")


def solved_facts(warp: TableWarp | PlaneTableWarp, output: Path, seconds: float) -> dict[str, Any]:
    """What `solve` tells about the warp that it has written to `output`, as JSON values."""
    import numpy as np

    record, meta = warp.solution, warp.meta
    assert record is not None, "a warp that was just solved has its record"
    notes = [
        f"prop '{name}' is shown as and where it is: its [prop.goal] is missing or changes nothing."
        for name, matrix in meta.goals.items()
        if np.array_equal(matrix, np.eye(len(matrix)))
    ]
    missed = record.estimated_error_max_mm > meta.tolerance_mm
    if missed:
        notes.append(
            "the estimated error stayed above the tolerance in the last round of refinement; "
            "`touchwarp check` fails a warp for that, and measures what it comes to."
        )
    if record.contradiction_mm > 0.0:
        notes.append(
            f"a goal asks for {record.contradiction_mm:.2g} mm where its prop meets a fixed "
            "surface that forbids it; the two are blended over the surface's blend_mm."
        )
    if getattr(record, "capped", False):
        notes.append(
            f"within {meta.edge_radius_mm:g} mm of sharp edges the grid is coarser than the field "
            "there asks for" + ("." if missed else "; beyond, the tolerance holds.")
        )
    return {
        "warp": str(output),
        "bytes": output.stat().st_size,
        "seconds": round(seconds, 3),
        "nodes": record.nodes,
        "finest_spacing_mm": record.spacing * 1e3,
        "screening_per_m2": meta.screening,
        "tolerance_mm": meta.tolerance_mm,
        "estimated_error_max_mm": record.estimated_error_max_mm,
        "estimated_error_rms_mm": record.estimated_error_rms_mm,
        "estimated_edge_error_mm": record.estimated_edge_error_mm,
        "contradiction_mm": record.contradiction_mm,
        "residual_history": list(record.residual_history),
        "notes": notes,
    }
