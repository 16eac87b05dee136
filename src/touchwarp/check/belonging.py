"""Do a scene and a warp belong together? A certificate of the wrong pair would be worthless."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from typing import Any

import numpy as np

from touchwarp.errors import WarpFileError
from touchwarp.goals.goal import Goal
from touchwarp.scene.scene import Scene
from touchwarp.scene.write import scene_text
from touchwarp.warp.meta import WarpMeta

_PARTS_THAT_MAY_DIFFER = ("interaction", "objective", "prop")
"""How the hand touches changes no warp; λ and tolerance are the warp's own; props are compared
by their surfaces and goals."""

GOAL_TOLERANCE = 1e-9


def require_belonging(scene: Scene, goals: Mapping[str, Goal], meta: WarpMeta) -> None:
    """Compare props, goals, outer boundary and fixed surfaces with what the warp says of itself.

    Raises:
        WarpFileError: they differ, or the warp is still a set of bases.
    """
    if meta.kind == "bases":
        raise WarpFileError(
            "The warp file holds bases, not a warp; make one of them with bases.table(goals), or "
            "solve the scene."
        )
    _require_same_props(scene.digests, meta.mesh_digests)
    _require_same_goals(scene, goals, meta)
    if meta.scene_text:
        _require_same_surroundings(scene, meta.scene_text)


def _require_same_props(came: Mapping[str, str], needed: Mapping[str, str]) -> None:
    if set(came) != set(needed):
        raise WarpFileError(
            f"The scene has the props {_names(came)}, but the warp was made for {_names(needed)}; "
            "give the scene that it was made from, or solve this one."
        )
    changed = [name for name in came if came[name] != needed[name]]
    if changed:
        raise WarpFileError(
            f"The surface of {_names(changed)} is not the one that the warp was made for (its "
            "mesh, unit, pose or up axis has changed since); solve the scene again."
        )


def _require_same_goals(scene: Scene, goals: Mapping[str, Goal], meta: WarpMeta) -> None:
    for name, goal in goals.items():
        made_for = meta.goals.get(name)
        if made_for is None:
            same = goal.matrix is None and _same_spec(name, scene, meta.scene_text)
        elif goal.matrix is None:
            same = False
        else:
            same = np.allclose(goal.matrix, made_for, rtol=0.0, atol=GOAL_TOLERANCE)
        if not same:
            raise WarpFileError(
                f"The goal of '{name}' is not the one that the warp was made for; solve the scene "
                "again, or give the scene with that goal."
            )


def _same_spec(name: str, scene: Scene, needed: str) -> bool:
    """Whether a goal that is no matrix is written as it was; its surfaces are compared apart."""
    if not needed:
        return True
    made_for = _goal_tables(needed).get(name)
    return made_for in (_goal_tables(text).get(name) for text in (scene.text, scene_text(scene)))


def _goal_tables(text: str) -> dict[str, Any]:
    props = _tables(text).get("prop", [])
    return {str(p.get("name")): p.get("goal") for p in props if isinstance(p, dict)}


def _require_same_surroundings(scene: Scene, needed: str) -> None:
    # A scene changed in code is written anew, with its defaults: either text will do.
    came, written = _surroundings(scene.text), _surroundings(scene_text(scene))
    made_for = _surroundings(needed)
    for part in sorted({*came, *made_for}):
        if made_for.get(part) not in (came.get(part), written.get(part)):
            raise WarpFileError(
                f"[{part}] of the scene is {came.get(part, 'absent')}, but the warp was made for "
                f"{made_for.get(part, 'none')}; solve the scene again."
            )


def _surroundings(text: str) -> dict[str, Any]:
    return {k: v for k, v in _tables(text).items() if k not in _PARTS_THAT_MAY_DIFFER}


def _tables(text: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise WarpFileError(
            f"The warp's scene text is no TOML ({error}); the file is damaged: solve again."
        ) from error


def _names(names: Any) -> str:
    return ", ".join(f"'{name}'" for name in sorted(names)) or "none"
