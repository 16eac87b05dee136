"""`touchwarp table`: a warp as a regular lookup table, for engines that read no other."""

from __future__ import annotations

from math import prod
from pathlib import Path

import click

BYTES_PER_NODE = 36  # while it is made: three float64 and their float32 copies


@click.command(
    "table",
    epilog="\b\nExamples:\n  touchwarp table mug.warp --shape 128 128 128 -o mug.npz",
)
@click.argument("warp", type=click.Path(path_type=Path))
@click.option(
    "--shape",
    type=click.IntRange(min=1),
    nargs=3,
    required=True,
    metavar="NX NY NZ",
    help="Nodes along each axis of the outer box; NZ is 1 for a plane warp.",
)
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), required=True, help="The .npz file to write."
)
@click.option(
    "--memory-limit-gb",
    type=float,
    default=4.0,
    show_default=True,
    metavar="G",
    help="Refuse a table that needs more.",
)
def table_command(
    warp: Path, shape: tuple[int, int, int], output: Path, memory_limit_gb: float
) -> None:
    """Sample WARP on a regular grid and write it as a NumPy .npz file.

    The file has 'origin' (3,) m, 'spacing' (3,) m and 'displacement' (NX, NY, NZ, 3) float32 m, in
    the scene's frame; the first and last nodes lie on the faces of the outer box. For a plane warp
    these are (2,), (2,) and (NX, NY, 2).

    A regular table mixes both sides of a surface within its cells and so misses the prop by about
    half a cell; where contact matters, read the warp file itself (docs/warp-file.md).
    """
    from touchwarp.cli.terminal import in_bytes
    from touchwarp.errors import OutputError, TouchwarpError
    from touchwarp.outputs import claim, replacing

    if output.suffix != ".npz":
        raise OutputError(f"the output is {output.name}; a NumPy file (.npz) is needed.")
    claim(output, warp)
    needed = prod(shape) * BYTES_PER_NODE / 1e9
    if needed > memory_limit_gb:
        raise TouchwarpError(
            f"A table of {shape[0]} × {shape[1]} × {shape[2]} nodes needs {needed:.3g} GB, and the "
            f"limit is {memory_limit_gb:g} GB; ask for fewer nodes or raise --memory-limit-gb."
        )
    import numpy as np

    from touchwarp.warp.file import load_table
    from touchwarp.warp.plane_table import PlaneTableWarp

    loaded = load_table(warp)
    axes = loaded.dimension
    if min(shape[:axes]) < 2 or shape[axes:] not in ((), (1,)):
        raise TouchwarpError(
            f"The shape is {shape[0]} {shape[1]} {shape[2]}; {warp} is a warp in {axes}-D, which "
            f"needs {'three numbers of 2 or more' if axes == 3 else 'two of 2 or more, then 1'}."
        )
    if isinstance(loaded, PlaneTableWarp):
        regular = loaded.resample(shape[:2])
    else:
        regular = loaded.resample(shape)
    with replacing(output) as temporary, temporary.open("wb") as file:
        np.savez(
            file,
            origin=regular.origin,
            spacing=regular.spacing,
            displacement=regular.displacement.astype(np.float32),
        )
    nodes = " × ".join(str(n) for n in regular.displacement.shape[:-1])
    spacing = " × ".join(f"{length * 1e3:.3g}" for length in regular.spacing)
    size = in_bytes(output.stat().st_size)
    click.echo(f"{output}: {nodes} nodes, {spacing} mm apart, {size}.")
