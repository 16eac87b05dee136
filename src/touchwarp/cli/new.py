"""`touchwarp new`: two files in, a scene out."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from touchwarp.cli.answers import Answers, settle_reading
from touchwarp.cli.new_parts import Part, fitted_part, mesh_part, rounded, with_equal_handles

if TYPE_CHECKING:
    from touchwarp.scene import Surface

MOST_TIMES = 2.5
"""A virtual object so many times as long as its prop, or as short, is told of."""


@click.command(
    "new",
    epilog="\b\nExamples:\n"
    "  touchwarp new scan.stl cup.glb -o mug.toml\n"
    "  touchwarp new scan.stl cup.obj --unit mm --virtual-unit cm --yes -o mug.toml\n"
    "  touchwarp new --fit cylinder touched.csv bottle.glb -o bottle.toml",
)
@click.argument("prop", type=click.Path(path_type=Path))
@click.argument("virtual", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    required=True,
    help="The scene file to write (.toml).",
)
@click.option("--unit", metavar="U", help="The prop's unit: mm, cm, m, in, ft.")
@click.option("--up", metavar="A", help="The prop's up axis: x, y, z, -x, …")
@click.option("--virtual-unit", metavar="U", help="The virtual object's unit.")
@click.option("--virtual-up", metavar="A", help="The virtual object's up axis.")
@click.option("--scale", is_flag=True, help="Scale the virtual object to the prop's size.")
@click.option("--no-table", is_flag=True, help="Do not look for a tabletop in the scan.")
@click.option(
    "--fit",
    type=click.Choice(["box", "cylinder", "sphere", "ellipsoid"]),
    help="PROP is a .csv of points touched on the prop (x,y,z in m): fit this shape to them.",
)
@click.option("--yes", is_flag=True, help="Ask nothing; take what is proposed.")
def new_command(
    prop: Path,
    virtual: Path,
    output: Path,
    unit: str | None,
    up: str | None,
    virtual_unit: str | None,
    virtual_up: str | None,
    scale: bool,
    no_table: bool,
    fit: str | None,
    yes: bool,
) -> None:
    """Write a scene in which the real thing PROP feels like VIRTUAL.

    Reads units and axes where the files define them and asks where they do not; cuts away the table
    of a scan; repairs what needs it; finds the pose; picks the kind of goal. Every choice stands in
    the scene with its reason.
    """
    from touchwarp.errors import OutputError
    from touchwarp.outputs import claim

    if output.suffix != ".toml":
        raise OutputError(f"the output is {output.name}; a scene file (.toml) is needed.")
    answers = Answers(yes)
    prop_file = output.with_name(f"{output.stem}-prop.ply")
    virtual_file = output.with_name(f"{output.stem}-virtual.ply")
    for path in (output, prop_file, virtual_file):
        claim(path, prop, virtual)
    if fit is not None:
        felt = fitted_part(prop, fit, prop_file)
        seen = settle_reading(virtual, virtual_unit, virtual_up, answers, "virtual-")
    else:
        # both files are opened, and what they do not tell is asked, before any long work
        scan = settle_reading(prop, unit, up, answers, "")
        seen = settle_reading(virtual, virtual_unit, virtual_up, answers, "virtual-")
        felt = mesh_part(scan, answers, prop_file, crop=not no_table)
    shown = mesh_part(seen, answers, virtual_file)
    felt, shown = with_equal_handles(felt, shown, answers)
    write_scene(felt, shown, scale, output)


def write_scene(felt: Part, shown: Part, scale: bool, output: Path) -> None:
    """Align, pick the goal, write what is needed, and make sure that the scene can be read."""
    import touchwarp as tw
    from touchwarp.cli.align import alignment_rows, pose_keys
    from touchwarp.cli.repair import repair_rows
    from touchwarp.cli.terminal import progress_bar, show_facts
    from touchwarp.errors import GoalError
    from touchwarp.goals import goals
    from touchwarp.outputs import replacing
    from touchwarp.scan.mesh_output import write_mesh
    from touchwarp.scan.preparation import choose_goal, place
    from touchwarp.scan.scene_draft import SceneDraft
    from touchwarp.scene.units import metres_per_unit

    table = felt.ready.table is not None
    with progress_bar("aligning") as progress:
        found = place(
            felt.ready.surface, shown.ready.surface, scale=scale, on_table=table, progress=progress
        )
    if table:
        shown = replace(shown, ready=shown.ready.standing(found.T_prop_virtual))
    kind, why = choose_goal(felt.ready.found, shown.ready.found)
    prop = {"name": felt.name, **_entries(felt)}
    source = _entries(shown)
    metres = metres_per_unit(source["unit"])
    goal = {"kind": kind, "virtual_mesh": source.pop("mesh"), **source}
    goal |= pose_keys(found, metres if scale else None)
    if kind == "match" and table:
        if _stand_alike(felt, shown, found.T_prop_virtual):
            goal["base"] = [0, 0, -1]
        else:
            shown = replace(shown, notes=[*shown.notes, _NO_BASE])
    for part in (felt, shown):
        if part.ready.changed:
            write_mesh(part.file, part.ready.surface)
    draft = SceneDraft(
        title=f"{felt.name}, felt as {shown.name}.",
        prop=prop,
        goal=goal,
        notes={
            "prop": _prop_notes(felt),
            "goal": [
                f"{kind}: {why}.",
                *([_AREAS] if kind == "match" else []),
                *(f"{shown.name}: {note}." for note in _notes(shown)),
            ],
            "pose": [f"{label}: {text}" for label, text in alignment_rows(found)],
            "base": ["the flat foot that both stand on; it stays on the table"],
            "table": ["the table that the scan showed; a hand on it is shown on it"],
        },
        table={"name": "table", "plane": _TABLE, "contact": "slide"} if table else None,
    )
    if kind == "direction":
        try:
            goals(_scene(draft, output))
        except GoalError as error:
            draft = _by_transform(draft, felt, shown, found.T_prop_virtual, why, str(error))
    with replacing(output) as temporary:
        temporary.write_text(draft.text(output.name), encoding="utf-8")
    tw.load_scene(output)
    for part in (felt, shown):
        if part.ready.repair is not None and part.ready.repair.steps:
            show_facts(f"{part.name}: repaired", repair_rows(part.ready.repair))
    show_facts(f"{shown.name} on {felt.name}", alignment_rows(found))
    times = _longest(shown.ready.surface) * found.scale / _longest(felt.ready.surface)
    if not 1 / MOST_TIMES < times < MOST_TIMES:
        click.echo(
            f"Note: {shown.name} is {times:.2g} times as long as {felt.name}, and hands are to be "
            f"displaced by up to {found.to_prop.max_mm:.0f} mm or more; if that is not meant, "
            "--scale brings it to the prop's size."
        )
    for part in (felt, shown):
        if part.ready.refusal:
            click.echo(
                f"Note: {part.name} is not closed: {part.ready.refusal} These are options of "
                "`touchwarp repair`; give what it writes to `touchwarp new`."
            )
    reasons = draft.notes["goal"] if draft.goal["kind"] == "transform" else draft.notes["goal"][:1]
    click.echo(f"Goal    {' '.join(reason.strip() for reason in reasons)}")
    click.echo(f"Next: touchwarp solve {output} -o {output.with_suffix('.warp')}")


_TABLE = {"point": [0, 0, 0], "normal": [0, 0, 1]}
_AREAS = "Areas are evened out to a spread of 0.15; area_weight = 0.5 lets them, and moves less."
_NO_BASE = (
    "it and the prop do not both stand on one flat face, so the prop's foot may show above the "
    "table, where the warp then misses it: fill what is hollow there in a modelling tool"
)


def _longest(surface: Surface) -> float:
    """m: the longest side of the box around it."""
    low, high = surface.bounds
    return float((high - low).max())


def _stand_alike(felt: Part, shown: Part, T_prop_virtual: Any) -> bool:
    """Whether both stand on the table by one flat face, which the map can then keep there."""
    import numpy as np

    from touchwarp.errors import GoalError
    from touchwarp.goals.maps.base import find_base

    feet = felt.ready.foot, shown.ready.foot
    if any(foot is None or foot.pieces > 1 for foot in feet):
        return False
    virtual = shown.ready.surface.transformed(T_prop_virtual)
    try:
        find_base(felt.ready.surface, virtual, np.array([0.0, 0.0, -1.0]))
    except GoalError:
        return False
    return True


def _scene(draft: Any, output: Path) -> Any:
    from touchwarp.scene import parse_scene

    return parse_scene(draft.text(output.name), output.parent)


def _by_transform(draft: Any, felt: Part, shown: Part, T: Any, why: str, refusal: str) -> Any:
    """The draft with the prop stretched to the virtual object's box: the goal that always works."""
    import numpy as np

    low, high = felt.ready.surface.bounds
    to_low, to_high = shown.ready.surface.transformed(T).bounds
    shift = 0.5 * (to_low + to_high - low - high)
    shift[2] = to_low[2] - low[2]
    goal = {
        "kind": "transform",
        "pivot": "base",
        "scale": rounded(np.ptp([to_low, to_high], axis=0) / np.ptp([low, high], axis=0), 5),
        "translation": rounded(shift),
    }
    reasons = [
        f"transform: {why}; and not by direction either:",
        f"  {refusal}",
        f"So the prop is stretched to the box around {shown.name}: the sizes are right, the shape",
        "is the prop's. Cut or fill the meshes and run touchwarp new again for more.",
    ]
    return replace(draft, goal=goal, notes={**draft.notes, "goal": reasons})


def _entries(part: Part) -> dict[str, Any]:
    if part.ready.changed:
        return {"mesh": part.file.name, "unit": "m", "up": "z"}
    return dict(part.entries)


def _prop_notes(felt: Part) -> list[str]:
    notes = [f"{note}." for note in _notes(felt)]
    if felt.ready.table is not None:
        rows = ", ".join(
            "[" + ", ".join(f"{v:.6g}" for v in row) + "]" for row in felt.ready.T_scene_file
        )
        notes += [
            f"cut from its table ({felt.ready.table.share:.0%} of the scan), which is now z = 0;",
            f"from the scan's frame (m, {felt.entries['up']} up) to the scene's: [{rows}]",
        ]
    return notes


def _notes(part: Part) -> list[str]:
    repaired = part.ready.repair
    notes = list(part.notes)
    if repaired is not None and repaired.steps:
        notes.append("repaired: " + "; ".join(repaired.steps))
        notes.append(f"the scan lies {repaired.from_input} from the repaired surface")
    if part.ready.evened:
        notes.append(f"remeshed to {len(part.ready.surface.faces):,} even triangles, for the map")
    if part.ready.foot is not None and part.ready.foot.drawn > 0:
        notes.append(f"its foot: {part.ready.foot}, where no hand comes while it stands")
    if part.ready.refusal:
        notes.append(f"not closed: {part.ready.refusal}".rstrip("."))
    return notes
