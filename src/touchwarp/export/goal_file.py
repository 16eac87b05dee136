"""A goal as a file of the kind that its name's ending asks for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from touchwarp.errors import GoalError
from touchwarp.export.morph_target import write_atlas, write_morph_target
from touchwarp.export.shape_texture import ShapeTexture, paint_texture
from touchwarp.export.texture_image import write_exr, write_png
from touchwarp.goals.goal import Goal
from touchwarp.outputs import replacing

GOAL_SUFFIXES = (".npz", ".glb", ".exr", ".png")


def goal_files(path: str | Path) -> tuple[Path, ...]:
    """The files that `write_goal` writes for this name: a texture has its atlas beside it.

    Raises:
        GoalError: the ending is another.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in GOAL_SUFFIXES:
        raise GoalError(
            f"the goal's file {path.name} has the ending '{path.suffix}'; .npz (arrays), .glb (a "
            "morph target), .exr or .png (a displacement texture, its atlas as .glb) is needed."
        )
    return (path, path.with_suffix(".glb")) if suffix in (".exr", ".png") else (path,)


def write_goal(
    path: str | Path,
    goal: Goal,
    name: str = "prop",
    size: int | None = None,
) -> dict[str, Any]:
    """Write a goal as arrays, as glTF with a morph target, or as a displacement texture.

    Args:
        path: ends in .npz, .glb, .exr or .png.
        goal: to write.
        name: the prop's, for glTF.
        size: of a texture, in texels; by default as the goal's points need.

    Returns:
        What there is to tell of a texture: `width`, `height`, `texture_error` and
        `texture_error_between` (m, the greatest difference from the goal when it is read back, at
        the goal's points and on its faces), and for PNG `scale` and `step` (m). Empty for the
        others.

    Raises:
        GoalError: the ending is another, or the goal is of a plane scene (.npz can hold it).
        OutputError: a file cannot be written.
    """
    path = Path(path)
    suffix = goal_files(path)[0].suffix.lower()
    if suffix == ".npz":
        with replacing(path) as temporary, temporary.open("wb") as file:
            np.savez(
                file,
                prop_points=goal.prop_points,
                virtual_points=goal.virtual_points,
                faces=goal.faces,
            )
        return {}
    if suffix == ".glb":
        write_morph_target(path, goal, name)
        return {}
    return _write_texture(path, paint_texture(goal, size), name)


def _write_texture(path: Path, texture: ShapeTexture, name: str) -> dict[str, Any]:
    height, width, _ = texture.displacement.shape
    facts = {
        "width": width,
        "height": height,
        "texture_error": texture.error,
        "texture_error_between": texture.error_between,
    }
    if path.suffix.lower() == ".exr":
        write_exr(path, texture.displacement)
    else:
        facts["step"] = write_png(path, texture.displacement)
        facts["scale"] = facts["step"] * (2**15 - 1)
        # Each component is off by half a step at most.
        for error in ("texture_error", "texture_error_between"):
            facts[error] += 3**0.5 / 2 * facts["step"]
    write_atlas(path.with_suffix(".glb"), texture.atlas, texture.at_vertices, name)
    return facts
