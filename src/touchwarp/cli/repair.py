"""`touchwarp repair`: a clean closed surface out of a scan."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from touchwarp.scan.repair import Repair


@click.command(
    "repair",
    epilog="\b\nExamples:\n"
    "  touchwarp repair scan.stl --unit mm -o mug.stl\n"
    "  touchwarp repair scan.stl --unit mm --genus 1 -o mug.stl\n"
    "  touchwarp repair scan.glb --bound-mm 0.5 --voxel-mm 0.4 -o mug.glb",
)
@click.argument("mesh", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    required=True,
    help="The mesh to write: .stl .obj .ply (in the unit of MESH) or .glb.",
)
@click.option("--unit", metavar="U", help="The unit of a mesh whose file has none: mm, cm, m, …")
@click.option(
    "--genus",
    type=click.IntRange(min=0),
    metavar="N",
    help="How many handles it has: 0 a ball or bottle, 1 a mug. By default, that of the mesh.",
)
@click.option(
    "--bound-mm",
    type=float,
    metavar="B",
    help="99 % of MESH must stay nearer than this; by default 0.5 % of its diagonal.",
)
@click.option(
    "--voxel-mm", type=float, metavar="V", help="Voxel of a wrap: less than half the thinnest wall."
)
@click.option(
    "--faces",
    type=click.IntRange(min=100),
    default=20_000,
    show_default=True,
    metavar="N",
    help="About how many triangles a wrap shall have.",
)
def repair_command(
    mesh: Path,
    output: Path,
    unit: str | None,
    genus: int | None,
    bound_mm: float | None,
    voxel_mm: float | None,
    faces: int,
) -> None:
    """Make one closed surface of MESH by the least that suffices, and tell how far it moved.

    Goals that map one surface to another (match, area_preserving) need such a mesh; the solver does
    not. A repair that would change the number of handles or leave the scan is refused.
    """
    from touchwarp.cli.terminal import progress_bar, show_facts
    from touchwarp.outputs import claim
    from touchwarp.scan.mesh_output import mesh_format, write_mesh
    from touchwarp.scan.repair import repair
    from touchwarp.scene.mesh_file import read_mesh, read_raw_mesh
    from touchwarp.scene.table import within
    from touchwarp.scene.units import metres_per_unit

    mesh_format(output)
    claim(output, mesh)
    with progress_bar("reading the mesh") as progress:
        surface = read_mesh(mesh, unit)
        with within(mesh.name):
            done = repair(
                surface,
                genus=genus,
                bound_mm=bound_mm,
                voxel_mm=voxel_mm,
                faces=faces,
                progress=progress,
            )
    metres = metres_per_unit(unit) if unit is not None else read_raw_mesh(mesh).metres
    write_mesh(output, done.surface, metres or 1.0)
    show_facts(f"{output}: one closed surface, genus {done.genus}", repair_rows(done))


def repair_rows(done: Repair) -> list[tuple[str, str]]:
    """What a repair did and how near it stayed, as (label, text) pairs."""
    before = "not told by its mesh" if done.genus_before is None else f"{done.genus_before}"
    rows = [
        ("faults found", done.before.faults()),
        ("done", "; ".join(done.steps) or "nothing: it was sound"),
        ("genus before", before),
        ("genus", f"{done.genus} ({done.genus_reason})"),
        ("input to result", f"{done.from_input} (p99 bound {done.bound_mm:.3g} mm)"),
        ("result to input", str(done.to_input)),
    ]
    if done.new_share > 0.001:
        rows.append(("spans holes", f"{done.new_share:.1%} of the area, where nothing was scanned"))
    return [*rows, ("faces", f"{len(done.surface.faces):,}")]
