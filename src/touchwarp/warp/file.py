"""Warp files: one safetensors file that stands alone; the format is told in docs/warp-file.md."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save_file

from touchwarp.errors import SceneError, WarpFileError
from touchwarp.outputs import replacing
from touchwarp.warp.bases import AffineBases, combined_error
from touchwarp.warp.bricks import Bricks
from touchwarp.warp.meta import WarpMeta
from touchwarp.warp.meta_file import from_file, to_document, to_tensors
from touchwarp.warp.plane_table import PlaneTableWarp
from touchwarp.warp.quantise import Conformer
from touchwarp.warp.table import TableWarp
from touchwarp.warp.topology import Placement, validate_bricks

FORMAT = "touchwarp-warp"
VERSION = 1

_TENSORS = ("T_scene_table", "spacing", "root", "child", "slot", "values")


def load_warp(path: str | Path) -> TableWarp | PlaneTableWarp | AffineBases:
    """A warp, or bases, from the file that `save` wrote.

    Raises:
        WarpFileError: the file is missing, truncated, no warp file, newer or inconsistent.
    """
    document, tensors = read(path)
    try:
        if document["dimension"] == 2:
            from touchwarp.warp.plane_file import plane_warp_of

            return plane_warp_of(document, tensors)
        if document["dimension"] != 3:
            raise ValueError(f"It has {document['dimension']!r} dimensions; 2 or 3 are needed.")
        bricks = _bricks_of(document, tensors)
        meta = from_file(document, tensors, 3)
        return TableWarp(bricks, meta) if meta.kind == "warp" else AffineBases(bricks, meta)
    except (KeyError, TypeError, ValueError, AttributeError, SceneError) as error:
        what = f"{error} is missing." if isinstance(error, KeyError) else str(error)
        raise WarpFileError(f"{path} is inconsistent: {what} Save the warp again.") from error


def load_table(path: str | Path) -> TableWarp | PlaneTableWarp:
    """As `load_warp`, where bases will not do.

    Raises:
        WarpFileError: as for `load_warp`, or the file holds bases.
    """
    warp = load_warp(path)
    if isinstance(warp, AffineBases):
        raise WarpFileError(
            f"{path} holds bases, for goals still to be chosen; a warp is needed: "
            "load it with load_warp(), then save bases.table({...})."
        )
    return warp


def write_warp(
    path: str | Path, bricks: Bricks, meta: WarpMeta, dtype: Literal["float32", "float16"]
) -> None:
    """Write one warp file, whole or not at all; bricks are put in order, coarse first.

    Raises:
        OutputError: the file cannot be written; nothing is left behind.
        ValueError: the bricks are inconsistent, or dtype is unknown.
    """
    if dtype not in ("float32", "float16"):
        raise ValueError(f"A warp cannot be stored as {dtype!r}; float32 or float16 is needed.")
    bricks, where = coarse_first(bricks, validate_bricks(bricks))
    if dtype == "float16" and bricks.values.dtype != np.float16:
        bricks, meta = _halved(bricks, meta)
    document = to_document(meta) | {
        "dimension": 3,
        "mirror_depth": bricks.mirror_depth,
        **_level_starts(bricks, where),
    }
    tensors = {name: getattr(bricks, name) for name in _TENSORS} | to_tensors(meta)
    write(path, document, tensors)


def write(path: str | Path, document: dict[str, Any], tensors: Mapping[str, NDArray[Any]]) -> None:
    """Write a JSON document and tensors as a warp file, whole or not at all.

    Raises:
        OutputError: the file cannot be written; nothing is left behind.
    """
    text = json.dumps(document, ensure_ascii=False, allow_nan=False)
    metadata = {"format": FORMAT, "version": str(VERSION), "meta": text}
    contiguous = {name: np.ascontiguousarray(tensor) for name, tensor in tensors.items()}
    with replacing(Path(path)) as temporary:
        try:
            save_file(contiguous, temporary, metadata)
        except SafetensorError as error:
            raise OSError(str(error)) from error


def read(path: str | Path) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """The JSON document and the tensors of a warp file of a version known here.

    Raises:
        WarpFileError: the file is missing, truncated, no warp file or newer.
    """
    path = Path(path)
    if not path.is_file():
        raise WarpFileError(
            f"There is no warp file {path}; give the path that a warp was saved to."
        )
    try:
        with safe_open(path, framework="numpy") as file:
            metadata = file.metadata() or {}
            _check_format(path, metadata)
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        document = json.loads(metadata["meta"])
    except (SafetensorError, OSError, KeyError, ValueError, TypeError) as error:
        raise WarpFileError(
            f"{path} cannot be read ({error}): it is truncated, damaged or no warp file; "
            "save the warp again, or copy the file again whole."
        ) from error
    return document, tensors


def coarse_first(bricks: Bricks, where: Placement) -> tuple[Bricks, Placement]:
    """The same table with bricks, and the rows of their values, in order of level."""
    order = np.argsort(where.level, kind="stable")
    slots = bricks.slot[order]
    value_order = slots[slots >= 0]
    in_order = np.array_equal(order, np.arange(len(order)))
    if in_order and np.array_equal(value_order, np.arange(len(value_order))):
        return bricks, where
    renamed = np.full(len(order) + 1, -1, np.int32)
    renamed[order] = np.arange(len(order), dtype=np.int32)
    slot = np.full(len(order), -1, np.int32)
    slot[slots >= 0] = np.arange(len(value_order), dtype=np.int32)
    # an index -1 finds the extra last entry, which is -1
    ordered = replace(
        bricks,
        root=renamed[bricks.root],
        child=renamed[bricks.child[order]],
        slot=slot,
        values=bricks.values[value_order],
    )
    return ordered, Placement(where.level[order], where.position[order])


def _halved(bricks: Bricks, meta: WarpMeta) -> tuple[Bricks, WarpMeta]:
    """The table as float16, with what that costs."""
    if float(np.abs(bricks.values).max(initial=0.0)) > float(np.finfo(np.float16).max):
        raise ValueError("The values are too large for float16; store the warp as float32.")
    values = bricks.values.astype(np.float16)
    lost = bricks.values.astype(np.float64) - values
    conformer = Conformer(bricks.root, bricks.child, bricks.slot, bricks.mirror_depth is not None)
    if meta.kind == "bases":
        greatest = combined_error(lost, meta)
    else:
        greatest = float(np.sqrt((lost**2).sum(axis=-1).max(initial=0.0)))
    meta = replace(
        meta,
        storage_error_mm=1e3 * greatest,
        storage_jump=conformer.jump(values),
    )
    return replace(bricks, values=values), meta


def _check_format(path: Path, metadata: dict[str, str]) -> None:
    if metadata.get("format") != FORMAT:
        raise WarpFileError(
            f"{path} is a safetensors file, but no warp file (its format is "
            f"{metadata.get('format')!r}, not {FORMAT!r}); give a file that touchwarp saved."
        )
    version = metadata.get("version", "")
    if not version.isdecimal() or int(version) > VERSION:
        raise WarpFileError(
            f"{path} is of version {version!r} of the warp file; this touchwarp reads versions up "
            f"to {VERSION}: update touchwarp, or save the warp with this one."
        )


def _level_starts(bricks: Bricks, where: Placement) -> dict[str, list[int]]:
    levels = np.arange(int(where.level.max(initial=0)) + 2)
    stored = where.level[bricks.slot >= 0]
    return {
        "level_bricks": np.searchsorted(where.level, levels).tolist(),
        "level_slots": np.searchsorted(stored, levels).tolist(),
    }


def _bricks_of(document: dict[str, Any], tensors: Mapping[str, NDArray[Any]]) -> Bricks:
    T_scene_table, spacing, root, child, slot, values = (tensors[name] for name in _TENSORS)
    for name in ("T_scene_table", "spacing"):
        if tensors[name].dtype != np.float64:
            raise ValueError(f"{name} is of type {tensors[name].dtype}; float64 is needed.")
    depth = document["mirror_depth"]
    depth = None if depth is None else float(depth)
    bricks = Bricks(T_scene_table, spacing, root, child, slot, values, depth)
    where = validate_bricks(bricks)
    stored = bricks.slot[bricks.slot >= 0]
    in_order = (np.diff(where.level) >= 0).all() and (np.diff(stored) > 0).all()
    starts = _level_starts(bricks, where)
    if not in_order or any(document[name] != starts[name] for name in starts):
        raise ValueError("Its bricks are not in order of level, as level_bricks tells it.")
    return bricks
