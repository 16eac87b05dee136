"""`touchwarp align`: where a virtual object lies best on a prop."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from touchwarp.scan.align import Alignment


@click.command(
    "align",
    epilog="\b\nExamples:\n"
    "  touchwarp align mug.stl cup.glb --unit mm\n"
    "  touchwarp align mug.stl cup.obj --unit mm --virtual-unit cm --scale -o aligned.glb\n"
    "  touchwarp align mug.stl cup.glb --unit mm --rotation upright -o scene.toml",
)
@click.argument("prop", type=click.Path(path_type=Path))
@click.argument("virtual", type=click.Path(path_type=Path))
@click.option("--unit", metavar="U", help="The prop's unit, if its file has none: mm, cm, m, …")
@click.option("--virtual-unit", metavar="U", help="The virtual object's unit.")
@click.option("--up", metavar="A", help="The prop's up axis: x, y, z, -x, …")
@click.option("--virtual-up", metavar="A", help="The virtual object's up axis.")
@click.option("--scale", is_flag=True, help="Also find a uniform scale.")
@click.option(
    "--rotation",
    type=click.Choice(["auto", "any", "upright", "none"]),
    default="auto",
    show_default=True,
    help="Which turns are allowed; upright: about the vertical only; auto: upright where that fits "
    "about as well as any.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="Write the aligned mesh (m), or put the pose into this scene (.toml).",
)
def align_command(
    prop: Path,
    virtual: Path,
    unit: str | None,
    virtual_unit: str | None,
    up: str | None,
    virtual_up: str | None,
    scale: bool,
    rotation: str,
    output: Path | None,
) -> None:
    """Find the pose in which the mesh VIRTUAL lies nearest to the mesh PROP.

    Prints the pose as a line for [prop.goal], and the distances that remain.
    """
    from touchwarp.cli.terminal import progress_bar, show_facts
    from touchwarp.outputs import claim, replacing
    from touchwarp.scan.align import align
    from touchwarp.scan.mesh_output import mesh_format, write_mesh
    from touchwarp.scan.preparation import place
    from touchwarp.scan.scene_draft import posed_scene
    from touchwarp.scene.mesh_file import read_mesh, read_raw_mesh
    from touchwarp.scene.units import metres_per_unit
    from touchwarp.scene.write import toml_value

    text = ""
    if output is not None:
        claim(output, prop, virtual)
        if output.suffix == ".toml":
            text = posed_scene(output, virtual, {})
        else:
            mesh_format(output)
    with progress_bar("reading the meshes") as progress:
        felt, seen = read_mesh(prop, unit, up), read_mesh(virtual, virtual_unit, virtual_up)
        if rotation == "auto":
            found = place(felt, seen, scale=scale, progress=progress)
        else:
            found = align(felt, seen, scale=scale, rotation=rotation, progress=progress)
    metres = read_raw_mesh(virtual).metres if virtual_unit is None else None
    if virtual_unit is not None:
        metres = metres_per_unit(virtual_unit)
    keys = pose_keys(found, (metres or 1.0) if scale else None)
    if output is not None and text:
        text = posed_scene(output, virtual, keys)
        with replacing(output) as temporary:
            temporary.write_text(text, encoding="utf-8")
    elif output is not None:
        write_mesh(output, seen.transformed(found.T_prop_virtual))
    for key, value in keys.items():
        click.echo(f"{key} = {toml_value(value)}")
    show_facts(f"{virtual.name} on {prop.name}", alignment_rows(found))


def pose_keys(found: Alignment, metres: float | None) -> dict[str, object]:
    """The keys of [prop.goal] that put the virtual object there.

    Args:
        found: the alignment.
        metres: in the virtual file's unit, if the scale is to be told: it goes into `unit`.
    """
    keys: dict[str, object] = {}
    if metres is not None:
        keys["unit"] = float(f"{metres * found.scale:.6g}")
    position = [round(v, 7) for v in found.position]
    rotation = [round(v, 4) for v in found.rotation_deg]
    return keys | {"pose": {"position": position, "rotation_deg": rotation}}


def alignment_rows(found: Alignment) -> list[tuple[str, str]]:
    """How near it lies and what the pose leaves open, as (label, text) pairs."""
    rows = [
        ("virtual to prop", str(found.to_prop)),
        ("prop to virtual", str(found.to_virtual)),
        ("scale", f"{found.scale:.5g}"),
    ]
    if found.upright_times is not None:
        rows.append(
            (
                "turned over",
                "the up axis of its file is not up: so it lies nearest, and upright would lie "
                f"{found.upright_times:.3g} times as far; `touchwarp align --rotation upright` "
                "keeps it up",
            )
        )
    if len(found.free_axes) == 3:
        rows.append(("free", "any turn fits as well: it is as good as a ball"))
    elif found.free_axes:
        axes = " and ".join(
            "(" + ", ".join(f"{v:.2f}" for v in axis) + ")" for axis in found.free_axes
        )
        rows.append(("free", f"any turn about {axes} fits as well"))
    if found.equal_poses > 1:
        rows.append(
            (
                "symmetric",
                f"{found.equal_poses} poses fit equally well; the one that turns it least is told",
            )
        )
    return rows
