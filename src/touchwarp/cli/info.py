"""`touchwarp info`: what a warp, scene or mesh file holds."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import click

Rows = list[tuple[str, str]]


@click.command(
    "info",
    epilog="\b\nExamples:\n"
    "  touchwarp info mug.warp\n"
    "  touchwarp info mug.toml\n"
    "  touchwarp info scan.stl --unit mm --json",
)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--unit", metavar="U", help="The unit of a mesh whose file has none: mm, cm, m, …")
@click.option("--json", "as_json", is_flag=True, help="Tell it as JSON on stdout.")
def info_command(file: Path, unit: str | None, as_json: bool) -> None:
    """Tell what FILE holds: a warp, a scene (.toml) or a mesh (.stl .obj .ply .glb .gltf .3mf).

    A scene is also checked as far as that goes without a solve: its meshes, its goals, and whether
    everything fits inside the outer boundary.
    """
    from touchwarp.cli.terminal import show_facts

    kind, rows, facts = describe_file(file, unit)
    if as_json:
        click.echo(json.dumps({"kind": kind, **facts}, indent=2, ensure_ascii=False))
    else:
        show_facts(f"{file} is a {kind}", rows)


def describe_file(file: Path, unit: str | None = None) -> tuple[str, Rows, dict[str, Any]]:
    """What kind of file it is, what to show of it, and the same as JSON values.

    Raises:
        TouchwarpError: the file cannot be read, or does not hold what its name says.
    """
    from touchwarp.scene.mesh_file import FORMATS

    ending = file.suffix.lower().lstrip(".")
    if ending == "toml":
        return "scene", *_scene(file)
    if ending in FORMATS:
        return "mesh", *_mesh(file, unit)
    return _warp(file)


def _mesh(file: Path, unit: str | None) -> tuple[Rows, dict[str, Any]]:
    from dataclasses import asdict

    from touchwarp.scene import inspect_mesh

    facts = inspect_mesh(file, unit)
    return facts.rows(), asdict(facts)


def _scene(file: Path) -> tuple[Rows, dict[str, Any]]:
    from touchwarp.cli.terminal import progress_bar
    from touchwarp.goals import goals, outer_box, validate
    from touchwarp.scene import describe, load_scene

    with progress_bar("reading the scene") as progress:
        scene = load_scene(file)
        goal_of = goals(scene, progress)
        validate(scene, goal_of)
    rows = describe(scene)
    low, high = outer_box(scene, goal_of)
    rows.append(("outer box from", _point(low)))
    rows.append(("outer box to", _point(high)))
    for name, goal in goal_of.items():
        reach = float((goal.displacement**2).sum(axis=1).max() ** 0.5)
        rows.append((f"farthest displacement on {name}", f"{reach * 1e3:.4g} mm"))
    return rows, dict(rows)


def _warp(file: Path) -> tuple[str, Rows, dict[str, Any]]:
    from touchwarp.cli.terminal import in_bytes
    from touchwarp.warp.file import load_warp
    from touchwarp.warp.plane_table import PlaneTableWarp

    warp = load_warp(file)
    meta = warp.meta
    if isinstance(warp, PlaneTableWarp):
        values = warp.table.values
        table = f"{values.shape[0]:,} × {values.shape[1]:,} nodes"
    else:
        values = warp.bricks.values
        table = f"{len(values):,} bricks of 8³ cells"
    size = file.stat().st_size
    goals = {name: goal.tolist() for name, goal in meta.goals.items()}
    facts = {
        "props": list(meta.prop_names),
        "screening_per_m2": meta.screening,
        "tolerance_mm": meta.tolerance_mm,
        "edge_radius_mm": meta.edge_radius_mm,
        "estimated_error_max_mm": meta.estimated_error_max_mm,
        "estimated_error_rms_mm": meta.estimated_error_rms_mm,
        "storage_error_mm": meta.storage_error_mm,
        "outer_box_m": None if meta.outer_box is None else meta.outer_box.tolist(),
        "values": str(values.dtype),
        "values_shape": list(values.shape),
        "bytes": size,
        "mesh_digests": dict(meta.mesh_digests),
        "goals": goals,
        "notes": dict(meta.notes),
    }
    rows = [
        ("props", ", ".join(meta.prop_names) or "–"),
        ("mismatch weight λ/L²", f"{meta.screening:g} 1/m²"),
        ("tolerance", f"{meta.tolerance_mm:g} mm"),
        ("estimated error, greatest", _mm(meta.estimated_error_max_mm)),
        ("estimated error, rms", _mm(meta.estimated_error_rms_mm)),
    ]
    if meta.storage_error_mm:
        rows.append(("error added by float16", _mm(meta.storage_error_mm)))
    if meta.outer_box is not None:
        rows += [
            ("outer box from", _point(meta.outer_box[0])),
            ("outer box to", _point(meta.outer_box[1])),
        ]
    rows += [
        ("table", f"{table}, {values.dtype}"),
        ("file", in_bytes(size)),
        *((f"mesh of {name}", f"SHA-256 {digest}") for name, digest in meta.mesh_digests.items()),
    ]
    if meta.kind == "bases":
        rows.append(("range", f"|t| ≤ {meta.range_shift:g} m, ‖A − I‖ ≤ {meta.range_stretch:g}"))
        facts |= {"range_shift_m": meta.range_shift, "range_stretch": meta.range_stretch}
    return ("set of bases" if meta.kind == "bases" else "warp"), rows, facts


def _mm(length: float | None) -> str:
    return "unknown" if length is None else f"{length:.3g} mm"


def _point(coordinates: Iterable[float]) -> str:
    return "(" + ", ".join(f"{c:.4g}" for c in coordinates) + ") m"
