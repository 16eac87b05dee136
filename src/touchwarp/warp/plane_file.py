"""Plane warps in warp files: dimension 2, and lines and values in place of bricks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from touchwarp.warp.file import write
from touchwarp.warp.meta import WarpMeta
from touchwarp.warp.meta_file import from_file, to_document, to_tensors
from touchwarp.warp.plane_table import PlaneTableWarp
from touchwarp.warp.plane_values import PlaneTable


def write_plane(
    path: str | Path, table: PlaneTable, meta: WarpMeta, dtype: Literal["float32", "float16"]
) -> None:
    """Write one warp file, whole or not at all.

    Raises:
        OutputError: the file cannot be written; nothing is left behind.
        ValueError: dtype is unknown, or the values are too large for it.
    """
    if dtype not in ("float32", "float16"):
        raise ValueError(f"A warp cannot be stored as {dtype!r}; float32 or float16 is needed.")
    if dtype == "float16" and table.values.dtype != np.float16:
        if float(np.abs(table.values).max(initial=0.0)) > float(np.finfo(np.float16).max):
            raise ValueError("The values are too large for float16; store the warp as float32.")
        halved = table.values.astype(np.float16)
        lost = np.linalg.norm(table.values.astype(np.float64) - halved, axis=-1)
        meta = replace(meta, storage_error_mm=1e3 * float(lost.max(initial=0.0)))
        table = replace(table, values=halved)
    document = to_document(meta) | {"dimension": 2, "mirror_depth": table.mirror_depth}
    write(path, document, table.to_tensors() | to_tensors(meta))


def plane_warp_of(document: dict[str, Any], tensors: Mapping[str, NDArray[Any]]) -> PlaneTableWarp:
    """The warp of a file's JSON document and tensors.

    Raises:
        KeyError, TypeError, ValueError, AttributeError, SceneError, WarpFileError: something is
            missing or not what it should be.
    """
    depth = document["mirror_depth"]
    table = PlaneTable.from_tensors(tensors, None if depth is None else float(depth))
    return PlaneTableWarp(table, from_file(document, tensors, 2))
