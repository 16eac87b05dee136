"""Layouts kept on disk by the content of their mesh, in the user's cache folder."""

from __future__ import annotations

import hashlib
import logging
import os
import zipfile
from pathlib import Path

import numpy as np

from touchwarp.errors import OutputError
from touchwarp.goals.maps.closed_mesh import ClosedMesh
from touchwarp.goals.maps.layout import Layout
from touchwarp.outputs import replacing

METHOD = "3"
"""Changes whenever layouts would come out otherwise."""
MOST_KEPT = 100
FOLDER_VARIABLE = "TOUCHWARP_CACHE"
"""Names another folder; empty: nothing is kept."""

_log = logging.getLogger("touchwarp.goals")


def cache_folder() -> Path | None:
    """Where layouts are kept, or None."""
    named = os.environ.get(FOLDER_VARIABLE)
    if named is not None:
        return Path(named) if named else None
    from platformdirs import user_cache_path

    return user_cache_path("touchwarp") / "layouts"


def load_layout(mesh: ClosedMesh) -> Layout | None:
    """The layout kept of this very mesh; None where there is none, or it is damaged."""
    path = _path_of(mesh)
    if path is None or not path.is_file():
        return None
    try:
        with np.load(path, allow_pickle=False) as arrays:
            points = np.asarray(arrays["points"], dtype=np.float64)
            corner_shift = np.asarray(arrays["corner_shift"], dtype=np.float64)
        os.utime(path)
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None
    if points.shape != mesh.vertices.shape or corner_shift.shape != (*mesh.faces.shape, 2):
        return None
    layout = Layout(mesh, points, corner_shift)
    sound = bool(np.isfinite(points).all() and (layout.shares > 0).all())
    return layout if sound else None


def keep_layout(layout: Layout) -> None:
    """Keep a layout; the oldest ones make room. Where that fails, nothing is kept."""
    path = _path_of(layout.mesh)
    if path is None:
        return
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path) as temporary:
            np.savez(
                temporary, points=layout.points, corner_shift=layout.corner_shift.astype(np.int8)
            )
        kept = sorted(path.parent.glob("*.npz"), key=lambda p: p.stat().st_mtime)
        for old in kept[:-MOST_KEPT]:
            old.unlink(missing_ok=True)
    except (OSError, OutputError) as error:
        _log.info("the layout of a mesh was not kept: %s", error)


def _path_of(mesh: ClosedMesh) -> Path | None:
    folder = cache_folder()
    if folder is None:
        return None
    digest = hashlib.sha256(METHOD.encode())
    digest.update(mesh.vertices.astype("<f8").tobytes())
    digest.update(mesh.faces.astype("<i8").tobytes())
    return folder / f"{digest.hexdigest()[:40]}.npz"
