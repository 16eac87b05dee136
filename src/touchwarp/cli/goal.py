"""`touchwarp goal`: the map from a prop to its virtual object, as a file for other tools."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from touchwarp.goals import Goal
    from touchwarp.scene import Scene

TELLING = 5e-5  # m: the default tolerance_mm of a goal


@click.command(
    "goal",
    epilog="\b\nExamples:\n"
    "  touchwarp goal mug.toml -o mug.glb\n"
    "  touchwarp goal desk.toml --prop mug -o mug.exr\n"
    "  touchwarp goal mug.toml -o mug.npz --json",
)
@click.argument("scene", type=click.Path(path_type=Path))
@click.option("--prop", "name", metavar="NAME", help="Which prop; needed where there are several.")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    required=True,
    help="The file to write: .glb, .exr, .png or .npz.",
)
@click.option(
    "--size",
    type=int,
    metavar="N",
    help="Texels along the texture's sides, about; by default as the goal's points need.",
)
@click.option("--json", "as_json", is_flag=True, help="Tell the result as JSON on stdout.")
def goal_command(
    scene: Path, name: str | None, output: Path, size: int | None, as_json: bool
) -> None:
    """Make the goal of one prop of SCENE and write it as a file for other tools.

    \b
    .glb   the prop's surface with the virtual shape as a morph target (Blender, three.js)
    .exr   a displacement texture, x, y, z in 32-bit red, green, blue, metres; its atlas as .glb
    .png   the same in 16 bits, with the scale told; its atlas as .glb
    .npz   arrays: prop_points, virtual_points (n, 3) m, faces (m, 3)

    A texture can be painted elsewhere and read again: see kind = "texture" in docs/goals.md.
    """
    from touchwarp.cli import terminal
    from touchwarp.export.goal_file import goal_files, write_goal
    from touchwarp.outputs import claim

    files = goal_files(output)
    for file in files:
        claim(file, scene)
    from touchwarp.goals import goals
    from touchwarp.scene import load_scene

    loaded = load_scene(scene)
    name = _chosen(loaded, name)
    with terminal.progress_bar("making the goal") as progress:
        goal = goals(loaded.only(name), progress)[name]
        progress("writing", 0.9)
        facts = goal_facts(goal) | write_goal(output, goal, name, size)
    if as_json:
        click.echo(json.dumps({"prop": name, "files": [str(f) for f in files], **facts}, indent=2))
        return
    click.echo(
        f"{' and '.join(str(f) for f in files)}: {facts['kind']} of '{name}', {facts['points']:,} "
        f"points, {facts['faces']:,} faces; displaces by {facts['displacement_mean'] * 1e3:.3g} mm "
        f"on average, {facts['displacement_max'] * 1e3:.3g} mm at most."
    )
    if "area_weight" in goal.report:
        click.echo(
            f"Areas spread by {goal.report['area_std']:.2g} at area_weight "
            f"{goal.report['area_weight']:.3g} ({goal.report['area_weight_reason']})."
        )
    if goal.report.get("subdivision_capped"):
        click.echo(
            "Note: that many faces are not enough for the goal's tolerance_mm; their image strays "
            f"from the virtual surface by up to {goal.report['image_distance_max'] * 1e3:.2g} mm."
        )
    if "width" in facts:
        click.echo(_texture_text(facts, output))


def _chosen(scene: Scene, name: str | None) -> str:
    from touchwarp.errors import SceneError

    if name is not None:
        return scene.prop(name).name
    if len(scene.props) > 1:
        names = ", ".join(f"'{prop.name}'" for prop in scene.props)
        raise SceneError(f"the scene has {len(scene.props)} props: {names}; say which with --prop.")
    return scene.props[0].name


def goal_facts(goal: Goal) -> dict[str, Any]:
    """What there is to tell of a goal, as JSON values; lengths in m."""
    import numpy as np

    length = np.linalg.norm(goal.displacement, axis=1)
    return {
        "kind": goal.kind,
        "points": len(goal.prop_points),
        "faces": len(goal.faces),
        "displacement_mean": float(length.mean()),
        "displacement_max": float(length.max()),
        "report": {key: _plain(value) for key, value in goal.report.items()},
    }


def _plain(value: Any) -> Any:
    """A value as JSON can hold it: arrays as lists, null for what is not finite."""
    import numpy as np

    if isinstance(value, (list, tuple, np.ndarray)):
        return [_plain(entry) for entry in value]
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        return float(value) if np.isfinite(value) else None
    return str(value)


def _texture_text(facts: dict[str, Any], output: Path) -> str:
    size = f"{facts['width']} × {facts['height']} texels"
    points, faces = (1e3 * facts[key] for key in ("texture_error", "texture_error_between"))
    lines = [
        f"The texture has {size}; read back, it differs from the goal's points by {points:.2g} mm "
        f"at most, and by {faces:.2g} mm on its faces."
    ]
    if facts["texture_error"] > TELLING:
        lines.append("That is where points crowd one texel; a larger --size lessens it.")
    if "scale" in facts:
        lines.append(
            f"Its greatest number stands for {facts['scale']:.9g} m, a step for "
            f"{facts['step'] * 1e3:.2g} mm."
        )
    atlas = output.with_suffix(".glb").name
    lines += [
        "To read it as a goal:",
        "  [prop.goal]",
        '  kind = "texture"',
        f'  texture = "{output.name}"',
        f'  uv_mesh = "{atlas}"',
    ]
    return "\n".join(lines)
