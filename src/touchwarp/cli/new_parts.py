"""The prop and the virtual object of `touchwarp new`: read, cut from a table, repaired."""

from __future__ import annotations

import os
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from touchwarp.cli.answers import Answers, Settled

if TYPE_CHECKING:
    from touchwarp.scan.preparation import Prepared
    from touchwarp.scene import Surface


@dataclass(frozen=True)
class Part:
    """The prop or the virtual object on its way into the scene.

    Attributes:
        name: for the scene and for messages.
        raw: as its file has it, in m, z up.
        ready: cleaned; in the scene's frame for a prop.
        entries: the keys that say it in the scene.
        file: where its mesh is written if the file's own will not do.
        notes: comments for the scene.
    """

    name: str
    raw: Surface
    ready: Prepared
    entries: dict[str, Any]
    file: Path
    notes: list[str] = field(default_factory=list)


def mesh_part(settled: Settled, answers: Answers, file: Path, crop: bool = False) -> Part:
    """A mesh file read, its table cut away if `crop`, and repaired."""
    from touchwarp.cli.terminal import progress_bar
    from touchwarp.scan.preparation import prepare
    from touchwarp.scene.mesh_file import read_mesh

    path = settled.path
    raw = read_mesh(path, settled.unit, settled.up)
    with progress_bar(f"looking at {path.name}") as progress:
        ready = prepare(raw, crop=crop, progress=progress)
    if ready.table is not None and not answers.confirm(
        f"{path.name} stands on a table ({ready.table.share:.0%} of the scan). Cut it away",
        "--no-table",
    ):
        ready = prepare(raw, crop=False)
    entries = {"mesh": _relative(path, file.parent), "unit": settled.unit, "up": settled.up}
    return Part(path.stem, raw, ready, entries, file, settled.notes)


def fitted_part(path: Path, kind: str, file: Path) -> Part:
    """A shape fitted to the points of a CSV file."""
    import numpy as np

    from touchwarp.cli.points import read_points
    from touchwarp.errors import SceneError
    from touchwarp.scan.preparation import prepare
    from touchwarp.scan.primitives import fit_primitive
    from touchwarp.scene.pose import angles_deg
    from touchwarp.scene.shapes import make_shape

    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError(
            f"{path} cannot be read as a table of points ({error}); a .csv of x,y,z in m is needed."
        ) from error
    points = read_points(text, 3, path.name).points
    found = fit_primitive(kind, points[np.isfinite(points).all(axis=1)])
    T = found.T_points_shape
    note = (
        f"a {kind} fitted to {len(points)} points of {path.name}: they lie {found.rms_mm:.2g} mm "
        f"(rms), at most {found.max_mm:.2g} mm, from it, and tell where it ends to "
        f"{found.known_mm:.2g} mm or better"
    )
    if found.standing:
        note += "; none tells its lower end, so it is taken to stand at its lowest point"
    click.echo(f"Fitted {note}.")
    shape = {key: rounded(value) for key, value in found.shape.items()}
    entries = {
        "shape": {"kind": kind, **shape},
        "pose": {
            "position": rounded(T[:3, 3]),
            "rotation_deg": rounded(angles_deg(T[:3, :3]), 4),
        },
    }
    raw = make_shape(kind, found.shape).transformed(T)
    return Part(path.stem, raw, prepare(raw, crop=False), entries, file, [note])


def with_equal_handles(felt: Part, shown: Part, answers: Answers) -> tuple[Part, Part]:
    """Both, the one with more handles mended to the other's number, if that is possible and wanted.

    Scans have tunnels that the thing has not, where the scanner saw too little. A mesh that was
    closed already is believed.
    """
    from touchwarp.cli.terminal import progress_bar
    from touchwarp.scan.preparation import prepare

    a, b = felt.ready.found, shown.ready.found
    if not (a.sound and b.sound) or a.genus is None or b.genus is None or a.genus == b.genus:
        return felt, shown
    more, genus = (felt, b.genus) if a.genus > b.genus else (shown, a.genus)
    if more.ready.repair is None or more.ready.repair.genus_before is not None:
        return felt, shown  # its mesh is closed, so its handles are meant
    with progress_bar(f"closing tunnels of {more.name}") as progress:
        fewer = prepare(more.raw, crop=more.ready.table is not None, genus=genus, progress=progress)
    if fewer.repair is None:
        click.echo(
            f"Note: {more.name} has {more.ready.found.genus} handles, the other {genus}, and keeps "
            f"them: {fewer.refusal} The goal is then one that needs no equal handles."
        )
        return felt, shown
    if not answers.confirm(
        f"{more.name} has {more.ready.found.genus} handles, the other {genus}. "
        f"{fewer.repair.steps[-1].capitalize()} would leave {genus}; do that",
        "another mesh",
    ):
        return felt, shown
    mended = replace(more, ready=fewer)
    return (mended, shown) if more is felt else (felt, mended)


def _relative(path: Path, folder: Path) -> str:
    try:
        return Path(os.path.relpath(path, folder)).as_posix()
    except ValueError:  # another drive
        return path.resolve().as_posix()


def rounded(value: Any, digits: int = 7) -> Any:
    """A number or an array as a person may read it: 0.1 µm, as lists."""
    import numpy as np

    numbers = np.round(np.asarray(value, dtype=float), digits) + 0.0
    return numbers.tolist()
