"""What `touchwarp view` is given, opened: a scene file, a warp or bases."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from touchwarp.check.belonging import require_belonging
from touchwarp.errors import SceneError, TouchwarpError, WarpFileError
from touchwarp.goals import goals
from touchwarp.live.document import SceneDocument
from touchwarp.live.messages import FromServer
from touchwarp.live.workbench import Workbench
from touchwarp.scene import Scene
from touchwarp.warp import AffineBases, TableWarp, load_warp

_log = logging.getLogger("touchwarp")

Table = TypeVar("Table", TableWarp, AffineBases)


def open_workbench(
    path: Path, folder: Path, publish: Callable[[FromServer], None], recording: bool = True
) -> Workbench:
    """The workbench for a scene file, a warp file or a file of bases.

    A scene file's warp is looked for beside it, under the same name with the ending .warp, and its
    bases with .bases; what does not belong to the scene as it now stands is passed over.

    Args:
        path: the file.
        folder: an existing one, for files to be served.
        publish: told of progress and of every new state.
        recording: whether recordings are kept.

    Raises:
        SceneError, GoalError, WarpFileError: the file is none, or of a plane scene.
    """
    if path.suffix.lower() == ".toml" or path.is_dir() or not path.exists():
        document = SceneDocument.open(path)
        scene = document.scene
        warp = _beside(path.with_suffix(".warp"), TableWarp, scene)
        bases = _beside(path.with_suffix(".bases"), AffineBases, scene)
        return Workbench(document, warp, bases, folder, publish, recording)
    loaded = load_warp(path)
    if not isinstance(loaded, (TableWarp, AffineBases)):
        raise SceneError(
            f"{path} is the warp of a plane scene; the page shows scenes in space only. Look at it "
            "by 'touchwarp check SCENE WARP --html report.html'."
        )
    document = SceneDocument.inside(loaded.meta.scene_text, path)
    if isinstance(loaded, AffineBases):
        return Workbench(document, None, loaded, folder, publish, recording)
    return Workbench(document, loaded, None, folder, publish, recording)


def _beside(path: Path, kind: type[Table], scene: Scene) -> Table | None:
    if not path.exists():
        return None
    try:
        loaded = load_warp(path)
        if not isinstance(loaded, kind):
            raise WarpFileError("it holds something else.")
        # Bases are of no goal, and so belong to any.
        own = goals(scene) if isinstance(loaded, TableWarp) else None
        require_belonging(scene, own or {}, replace(loaded.meta, kind="warp"))
        if not math.isclose(loaded.meta.screening, scene.objective.screening):
            raise WarpFileError("it was solved with another λ.")
    except TouchwarpError as error:
        _log.warning("%s is not used: %s", path.name, error)
        return None
    return loaded
