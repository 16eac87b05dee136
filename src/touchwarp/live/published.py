"""Warp files as the page fetches them: float16, coarse levels first, named by their content."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from touchwarp.live.messages import WarpFile
from touchwarp.warp import AffineBases, TableWarp
from touchwarp.warp.file import read


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


def _publish(
    table: TableWarp | AffineBases, folder: Path, ending: str, estimate: float | None
) -> Published:
    path = folder / f"new.{ending}"
    table.save(path, "float16")
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
