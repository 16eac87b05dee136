"""Reading the scene file (TOML)."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from touchwarp.errors import SceneError
from touchwarp.scene.goal_spec import GoalSpec, read_goal
from touchwarp.scene.interaction import MODES, TRACKING_PRESETS, Interaction, Tracking
from touchwarp.scene.objective import Objective
from touchwarp.scene.scene import CONTACTS, Fixed, Outer, Prop, Scene
from touchwarp.scene.surface_reader import SURFACE_KEYS, SurfaceReader, origin_of
from touchwarp.scene.table import Table, spell, within
from touchwarp.scene.transform_goal import TransformGoal

_OBJECTIVE_KEYS = ("mismatch_weight", "length_scale", "tolerance_mm", "edge_radius_mm")
_TRACKING_KEYS = ("bias_mm", "noise_mm", "latency_ms", "pose_mm", "pose_deg")


def load_scene(path: str | Path) -> Scene:
    """Read a scene file.

    Raises:
        SceneError: the file or one of its meshes is missing or unreadable; a key or kind is
            unknown, a type wrong, a value out of range. The message begins with the file's name.
        GoalError: a goal is singular, or mirrors without allow_mirror.
    """
    path = Path(path)
    if path.is_dir():
        raise SceneError(f"{path} is a folder; a scene file (.toml) is needed.")
    if not path.exists():
        raise SceneError(f"scene file {path} does not exist; check the name and folder.")
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise SceneError(f"{path} is not UTF-8 text, so it is no scene file (.toml).") from error
    except OSError as error:
        raise SceneError(f"scene file {path} cannot be read: {error.strerror or error}.") from error
    with within(path.name):
        return parse_scene(text, path.parent)


def parse_scene(text: str, directory: str | Path = ".") -> Scene:
    """The scene that a TOML text describes; relative paths start from `directory`."""
    try:
        entries = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(f"not valid TOML: {error}{_line_of(text, str(error))}.") from error
    directory = Path(directory)
    top = Table(entries, "", ("dimension", "objective", "outer", "prop", "fixed", "interaction"))
    dimension = top.raw("dimension", 3)
    if isinstance(dimension, bool) or dimension not in (2, 3):
        raise SceneError(f"dimension is {spell(dimension)}; 2 or 3 is needed.")
    reader = _Reader(dimension, directory)
    objective = top.table("objective", _OBJECTIVE_KEYS)
    scene = Scene(
        objective=Objective(**{key: objective.number(key) for key in objective.entries}),
        outer=reader.outer(top.table("outer", ("box_scale", "box", *SURFACE_KEYS))),
        props=[reader.prop(entries, where) for where, entries in top.tables("prop")],
        fixed=[reader.fixed(entries, where) for where, entries in top.tables("fixed")],
        interaction=_interaction(top.table("interaction", ("mode", "tracking"))),
        dimension=dimension,
        directory=directory,
    )
    scene.__dict__["text"] = text
    return scene


class _Reader:
    """Reads what depends on the scene's dimension and folder."""

    def __init__(self, dimension: int, directory: Path) -> None:
        self.dimension = dimension
        self.surfaces = SurfaceReader(dimension, directory)

    def prop(self, entries: Any, where: str) -> Prop:
        table = Table(entries, where, ("name", *SURFACE_KEYS, "goal"))
        name = table.text("name")
        surface = self.surfaces.surface(table)
        goal: GoalSpec = TransformGoal()
        if "goal" in table:
            with within(where):
                goal = read_goal(table.raw("goal"), "goal", self.surfaces)
        return Prop(name, surface, goal, origin_of(table))

    def outer(self, table: Table) -> Outer:
        box = surface = None
        if "box" in table:
            corners = table.table("box", ("min", "max"))
            d = self.dimension
            box = np.array([corners.vector("min", d), corners.vector("max", d)])
        if any(key in table for key in SURFACE_KEYS):
            surface = self.surfaces.surface(table)
        return Outer(table.number("box_scale", None), box, surface, origin_of(table))

    def fixed(self, entries: Any, where: str) -> Fixed:
        table = Table(entries, where, ("name", "plane", *SURFACE_KEYS, "contact", "blend_mm"))
        plane = surface = None
        if "plane" in table:
            parts = table.table("plane", ("point", "normal"))
            d = self.dimension
            plane = (parts.vector("point", d), parts.vector("normal", d))
        if any(key in table for key in SURFACE_KEYS):
            surface = self.surfaces.surface(table)
        return Fixed(
            table.text("name"),
            plane,
            surface,
            table.choice("contact", CONTACTS, None),
            table.number("blend_mm", 10.0),
            origin_of(table),
        )


def _line_of(text: str, message: str) -> str:
    """The line that the TOML reader's message names, to be shown after it."""
    match = re.search(r"at line (\d+)", message)
    lines = text.splitlines()
    if match is None or not 0 < int(match[1]) <= len(lines):
        return ""
    return f": '{lines[int(match[1]) - 1].strip()}'"


def _interaction(table: Table) -> Interaction:
    tracking: Tracking | str = "markers"
    if "tracking" in table:
        if isinstance(table.raw("tracking"), dict):
            given = table.table("tracking", _TRACKING_KEYS)
            tracking = Tracking(**{key: given.number(key) for key in given.entries})
        else:
            tracking = table.choice("tracking", TRACKING_PRESETS)
    return Interaction(table.choice("mode", MODES, "slide"), tracking)
