"""A scene file while it is being changed: its text is the truth, and comments are kept."""

from __future__ import annotations

from collections.abc import Mapping, MutableMapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

from touchwarp.errors import OutputError, SceneError
from touchwarp.live.messages import Placement, Pose
from touchwarp.outputs import replacing
from touchwarp.scene import Scene, load_scene
from touchwarp.scene.read import parse_scene
from touchwarp.scene.table import within

# What a drag sets is rounded to what a person may want to read: 10 µm, 0.001°, 10⁻⁴.
_DIGITS = {"scale": 4, "rotation_deg": 3, "translation": 5, "position": 5}


@dataclass(frozen=True)
class SceneDocument:
    """The text of a scene file, and where it came from.

    Attributes:
        text: TOML.
        directory: where its relative paths start from.
        path: the scene file; None for the scene inside a warp file.
        saved: the text that the file had when it was last read or written.
    """

    text: str
    directory: Path
    path: Path | None
    saved: str

    @classmethod
    def open(cls, path: Path) -> SceneDocument:
        """Read a scene file.

        Raises:
            SceneError, GoalError: as `load_scene`.
        """
        text = load_scene(path).text
        return cls(text, path.parent, path, text)

    @classmethod
    def inside(cls, text: str, warp_path: Path) -> SceneDocument:
        """The scene text inside a warp file; meshes are looked for beside that file."""
        return cls(text, warp_path.parent, None, text)

    @property
    def unsaved(self) -> bool:
        """Whether it was changed since it was read or saved."""
        return self.text != self.saved

    @cached_property
    def scene(self) -> Scene:
        """The scene that the text describes.

        Raises:
            SceneError, GoalError: it does not describe one, or a mesh is missing.
        """
        with within(self.path.name if self.path else "the scene in the warp file"):
            return parse_scene(self.text, self.directory)

    def changed(
        self,
        *,
        mismatch_weight: float | None = None,
        goals: Mapping[str, Placement] | None = None,
        poses: Mapping[str, Pose] | None = None,
    ) -> SceneDocument:
        """The same document with some values changed; comments and everything else are kept.

        Args:
            mismatch_weight: λ.
            goals: by prop; the prop's goal must be of kind "transform", without a matrix.
            poses: by prop, for instance as measured.

        Raises:
            SceneError: a prop is unknown, or its goal is written in another way.
            GoalError: the changed goal is no usable map.
        """
        document = tomlkit.parse(self.text)
        if mismatch_weight is not None:
            if "objective" not in document:
                document["objective"] = tomlkit.table()
            _set(_table(document["objective"]), "mismatch_weight", float(mismatch_weight), 0.0)
        for name, placement in (goals or {}).items():
            prop = _prop(document, name)
            goal = _table(prop.setdefault("goal", tomlkit.inline_table()))
            if goal.setdefault("kind", "transform") != "transform" or "matrix" in goal:
                raise SceneError(
                    f"the goal of prop '{name}' is not written as scale, rotation_deg and "
                    "translation, so it cannot be dragged; rewrite it so in the scene file."
                )
            _set(goal, "scale", placement.scale, (1.0, 1.0, 1.0))
            _set(goal, "rotation_deg", placement.rotation_deg, (0.0, 0.0, 0.0))
            _set(goal, "translation", placement.translation, (0.0, 0.0, 0.0))
        for name, pose in (poses or {}).items():
            prop = _prop(document, name)
            table = _table(prop.setdefault("pose", tomlkit.inline_table()))
            _set(table, "position", pose.position, (0.0, 0.0, 0.0))
            _set(table, "rotation_deg", pose.rotation_deg, (0.0, 0.0, 0.0))
        result = SceneDocument(tomlkit.dumps(document), self.directory, self.path, self.saved)
        result.scene  # noqa: B018  raises now what would be raised later
        return result

    def save(self) -> SceneDocument:
        """Write the text back to the scene file.

        Raises:
            SceneError: there is no scene file, or it has changed on disk since it was read.
            OutputError: it cannot be written; the old file stays.
        """
        if self.path is None:
            raise SceneError(
                "a warp file was opened, which has no scene file to save to; "
                "open the scene file itself."
            )
        try:
            on_disk = self.path.read_text(encoding="utf-8")
        except OSError as error:
            raise OutputError(
                f"{self.path} cannot be read any more ({error.strerror}), so it is not overwritten."
            ) from error
        if on_disk != self.saved:
            raise SceneError(
                f"{self.path.name} was changed on disk since it was opened, so it is not "
                "overwritten; open the page's scene anew and repeat the change."
            )
        with replacing(self.path) as temporary:
            temporary.write_text(self.text, encoding="utf-8")
        return SceneDocument(self.text, self.directory, self.path, self.text)


def _prop(document: Any, name: str) -> MutableMapping[str, Any]:
    for prop in document.get("prop", []):
        if prop.get("name") == name:
            return _table(prop)
    names = ", ".join(f"'{prop.get('name')}'" for prop in document.get("prop", []))
    raise SceneError(f"no prop is named '{name}'; the scene has {names}.")


def _table(value: Any) -> MutableMapping[str, Any]:
    assert isinstance(value, MutableMapping), "the scene was read, so this is a table"
    return value


def _set(
    table: MutableMapping[str, Any], key: str, value: float | Sequence[float], default: Any
) -> None:
    """Set a number or a list of three, unless the file says the same already."""
    new: Any
    if isinstance(value, (int, float)):
        new, old = value, table.get(key, default)
    else:
        new = [round(float(v), _DIGITS[key]) + 0.0 for v in value]
        old = np.broadcast_to(np.asarray(table.get(key, default), dtype=float), 3).tolist()
    if new != old:
        table[key] = new
