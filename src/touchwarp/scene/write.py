"""Writing a scene as TOML, for scenes built in code."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from touchwarp.scene.goal_spec import GoalSpec
from touchwarp.scene.interaction import TRACKING_PRESETS, Tracking
from touchwarp.scene.scene import Outer, Scene
from touchwarp.scene.surface import Surface, surface_digest


def scene_text(scene: Scene) -> str:
    """The scene as TOML.

    Surfaces read from a scene file keep the keys that they came from. Those given as arrays are
    described by digest and counts: such a text says what the scene was, but cannot be read back.
    """
    lines = [] if scene.dimension == 3 else [f"dimension = {scene.dimension}", ""]
    objective = scene.objective
    lines += [
        "[objective]",
        f"mismatch_weight = {toml_value(objective.mismatch_weight)}",
        f"length_scale = {toml_value(objective.length_scale)}",
        f"tolerance_mm = {toml_value(objective.tolerance_mm)}",
        f"edge_radius_mm = {toml_value(objective.edge_radius_mm)}",
        "",
        "[outer]",
        *_keys(_outer(scene.outer)),
    ]
    for prop in scene.props:
        lines += ["", "[[prop]]", *_keys({"name": prop.name, **_origin(prop)})]
        lines += ["", "[prop.goal]", *_keys(_goal(prop.goal))]
    for fixed in scene.fixed:
        entries: dict[str, Any] = {"name": fixed.name}
        if fixed.plane is not None:
            entries["plane"] = {"point": fixed.plane[0], "normal": fixed.plane[1]}
        else:
            entries |= _origin(fixed)
        entries |= {"contact": fixed.contact, "blend_mm": fixed.blend_mm}
        lines += ["", "[[fixed]]", *_keys(entries)]
    tracking = scene.interaction.tracking
    assert isinstance(tracking, Tracking)
    spelt: Any = tracking.name
    if tracking.name not in TRACKING_PRESETS:
        spelt = {k: v for k, v in vars(tracking).items() if k != "name"}
    lines += ["", "[interaction]", *_keys({"mode": scene.interaction.mode, "tracking": spelt})]
    return "\n".join(lines) + "\n"


def _outer(outer: Outer) -> dict[str, Any]:
    if outer.box is not None:
        box = np.asarray(outer.box)
        return {"box": {"min": box[0], "max": box[1]}}
    if outer.surface is not None:
        return _origin(outer)
    return {"box_scale": outer.box_scale}


def _goal(goal: Any) -> dict[str, Any]:
    if isinstance(goal, GoalSpec):
        return {"kind": goal.kind, **goal.entries()}
    return {
        "kind": "arrays",
        "prop_digest": surface_digest(Surface(goal.prop_points, goal.faces)),
        "virtual_digest": surface_digest(Surface(goal.virtual_points, goal.faces)),
    }


def _origin(item: Any) -> dict[str, Any]:
    if item.origin:
        return dict(item.origin)
    surface: Surface = item.surface
    return {
        "mesh": {
            "digest": surface_digest(surface),
            "vertices": len(surface.vertices),
            "faces": len(surface.faces),
        }
    }


def _keys(entries: Mapping[str, Any]) -> list[str]:
    return [f"{key} = {toml_value(value)}" for key, value in entries.items()]


def toml_value(value: Any) -> str:
    """A value as TOML spells it."""
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, str):
        return '"' + "".join(_escape(c) for c in value) + '"'
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    if isinstance(value, Mapping):
        return "{ " + ", ".join(_keys(value)) + " }"
    return "[" + ", ".join(toml_value(entry) for entry in value) + "]"


def _escape(character: str) -> str:
    if character in '"\\':
        return "\\" + character
    if ord(character) < 32 or ord(character) == 127:
        return f"\\u{ord(character):04x}"
    return character
