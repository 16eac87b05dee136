"""Warp files as the page fetches them: float16, coarse levels first, named by their content."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from touchwarp.live.messages import WarpFile
from touchwarp.warp import AffineBases, TableWarp
from touchwarp.warp.bases import combined_error
from touchwarp.warp.coarse_values import level_errors, with_coarse_values
from touchwarp.warp.file import read, write_warp


@dataclass(frozen=True)
class Published:
    """A file and what the page is told of it."""

    path: Path
    file: WarpFile


def publish_warp(warp: TableWarp, folder: Path) -> Published:
    """Write a warp into `folder` as float16."""
    return _publish(warp, folder, "warp", warp.meta.estimated_error_max_mm)


def publish_bases(bases: AffineBases, folder: Path) -> Published:
    """Write bases into `folder` as float16."""
    return _publish(bases, folder, "bases", bases.meta.estimated_error_max_mm)


def greatest_length(lost: NDArray[np.float64]) -> float:
    """The greatest |u| of rows (n, 3)."""
    return float(np.sqrt((lost**2).sum(axis=-1).max(initial=0.0)))


def _publish(
    table: TableWarp | AffineBases, folder: Path, ending: str, estimate: float | None
) -> Published:
    path = folder / f"new.{ending}"
    bricks = with_coarse_values(table.bricks)
    if isinstance(table, AffineBases):
        errors = level_errors(bricks, lambda lost: combined_error(lost, table.meta))
    else:
        errors = level_errors(bricks, greatest_length)
    notes = table.meta.notes | {"level_errors_mm": [1e3 * error for error in errors]}
    write_warp(path, bricks, replace(table.meta, notes=notes), "float16")
    with path.open("rb") as file:
        identity = hashlib.file_digest(file, "sha256").hexdigest()[:16]
    document, _ = read(path)
    named = path.replace(folder / f"{identity}.{ending}")
    return Published(
        named,
        WarpFile(
            identity=identity,
            url=f"./tables/{identity}.{ending}",
            size=named.stat().st_size,
            estimated_error_max_mm=estimate,
            storage_error_mm=document["storage_error_mm"],
        ),
    )
