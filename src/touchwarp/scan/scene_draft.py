"""The text of a scene file: a first draft with comments, or one whose pose is replaced."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from touchwarp.errors import SceneError
from touchwarp.scene.write import toml_value


@dataclass(frozen=True)
class SceneDraft:
    """What a scene file of one prop shall say, and why.

    Attributes:
        title: the first comment.
        prop: keys of [[prop]] and their values.
        goal: keys of [prop.goal].
        notes: comments by the key that they stand above: "prop", "goal", "table", or a key's name.
        table: keys of [[fixed]], if something is.
    """

    title: str
    prop: Mapping[str, Any]
    goal: Mapping[str, Any]
    notes: Mapping[str, Sequence[str]] = field(default_factory=dict)
    table: Mapping[str, Any] | None = None

    def text(self, file: str) -> str:
        """The TOML; `file` is its name, for the commands in its head."""
        stem = Path(file).stem
        lines = [
            f"# {self.title}",
            "# Solve and check it:",
            f"#   touchwarp solve {file} -o {stem}.warp",
            f"#   touchwarp check {file} {stem}.warp --html {stem}.html",
            "# Lengths are metres, angles degrees, z is up. docs/scene-file.md explains every key.",
            "",
            "[objective]",
            "# greatest error of the warp, mm; 0.1 is exact and slower, 1 a quick look",
            "tolerance_mm = 0.5",
            "",
            *self._comments("prop"),
            "[[prop]]",
            *self._lines(self.prop),
            "",
            *self._comments("goal"),
            "[prop.goal]",
            *self._lines(self.goal),
        ]
        if self.table is not None:
            lines += ["", *self._comments("table"), "[[fixed]]", *self._lines(self.table)]
        return "\n".join(lines) + "\n"

    def _lines(self, entries: Mapping[str, Any]) -> list[str]:
        lines = []
        for key, value in entries.items():
            lines += [*self._comments(key), f"{key} = {toml_value(value)}"]
        return lines

    def _comments(self, key: str) -> list[str]:
        return [f"# {note}" for note in self.notes.get(key, ())]


def posed_scene(path: Path, virtual: Path, keys: Mapping[str, Any]) -> str:
    """The text of a scene file with other keys in the goal whose virtual_mesh names a file.

    Args:
        path: the scene file.
        virtual: the virtual object's mesh; matched by its file name.
        keys: of [prop.goal], such as `pose` and `unit`; they take the place of those there.

    Raises:
        SceneError: the scene is missing or unreadable, or not exactly one goal names that mesh.
    """
    if not path.exists():
        raise SceneError(
            f"scene file {path} does not exist; `touchwarp new` writes one, or give the name of a "
            "mesh to write (.ply, .glb)."
        )
    import tomlkit
    from tomlkit.exceptions import TOMLKitError

    try:
        document: Any = tomlkit.parse(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, TOMLKitError) as error:
        raise SceneError(f"{path.name} cannot be read as a scene file: {error}.") from error
    goals = [prop.get("goal", {}) for prop in document.get("prop", [])]
    found = [g for g in goals if Path(str(g.get("virtual_mesh", ""))).name == virtual.name]
    if len(found) != 1:
        raise SceneError(
            f"{path.name} has {len(found)} goals with virtual_mesh = '{virtual.name}'; one is "
            "needed, which then gets the pose: write it, or put the printed lines in by hand."
        )
    for key, value in keys.items():
        found[0][key] = value
    return tomlkit.dumps(document)
