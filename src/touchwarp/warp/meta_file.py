"""`WarpMeta` as the JSON document and the side tensors of a warp file; see docs/warp-file.md."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.scene.surface import Surface
from touchwarp.warp.meta import BasisProp, Outline, WarpMeta

Tensors = Mapping[str, NDArray[Any]]

_NUMBERS = (
    "screening",
    "tolerance_mm",
    "edge_radius_mm",
    "range_shift",
    "range_stretch",
    "storage_error_mm",
    "storage_jump",
)
_ESTIMATES = ("estimated_error_max_mm", "estimated_error_rms_mm")


def to_document(meta: WarpMeta) -> dict[str, Any]:
    """The JSON document of `meta`, but for what is kept in tensors."""
    document: dict[str, Any] = {
        "kind": meta.kind,
        "scene": meta.scene_text,
        "prop_names": list(meta.prop_names),
        "mesh_digests": meta.mesh_digests,
        "outlines": list(meta.outlines),
        "outer_box": None if meta.outer_box is None else np.asarray(meta.outer_box).tolist(),
        "goals": {name: np.asarray(matrix).tolist() for name, matrix in meta.goals.items()},
        "basis": {
            name: {"centre": list(basis.centre), "half_diagonal": basis.half_diagonal}
            for name, basis in meta.basis.items()
        },
        "T_room_scene": np.asarray(meta.T_room_scene).tolist(),
        "notes": meta.notes,
    }
    for name in (*_NUMBERS, *_ESTIMATES):
        value = getattr(meta, name)
        document[name] = None if value is None else float(value)
    return document


def to_tensors(meta: WarpMeta) -> dict[str, NDArray[Any]]:
    """The outlines and the outer surface of `meta`, for a file."""
    tensors: dict[str, NDArray[Any]] = {}
    for n, outline in enumerate(meta.outlines.values()):
        tensors[f"outline.{n}.prop"] = outline.prop.vertices.astype(np.float32)
        tensors[f"outline.{n}.virtual"] = outline.virtual.vertices.astype(np.float32)
        tensors[f"outline.{n}.faces"] = outline.prop.faces.astype(np.int32)
    if meta.outer_surface is not None:
        tensors["outer.vertices"] = meta.outer_surface.vertices.astype(np.float32)
        tensors["outer.faces"] = meta.outer_surface.faces.astype(np.int32)
    return tensors


def from_file(document: dict[str, Any], tensors: Tensors, dimension: int) -> WarpMeta:
    """The meta that `to_document` and `to_tensors` wrote.

    Raises:
        KeyError: something is missing.
        TypeError, ValueError, AttributeError, SceneError: something is not what it should be.
    """
    if document["kind"] not in ("warp", "bases"):
        raise ValueError(f"It holds {document['kind']!r}; 'warp' or 'bases' is needed.")
    outlines = {}
    for n, name in enumerate(document["outlines"]):
        faces = tensors[f"outline.{n}.faces"]
        outlines[str(name)] = Outline(
            Surface(tensors[f"outline.{n}.prop"], faces),
            Surface(tensors[f"outline.{n}.virtual"], faces),
        )
    outer = None
    if "outer.vertices" in tensors:
        outer = Surface(tensors["outer.vertices"], tensors["outer.faces"])
    square = (dimension + 1, dimension + 1)
    box = document["outer_box"]
    numbers: dict[str, float] = {name: float(document[name]) for name in _NUMBERS}
    estimates = {
        name: None if document[name] is None else float(document[name]) for name in _ESTIMATES
    }
    return WarpMeta(
        kind=document["kind"],
        scene_text=str(document["scene"]),
        mesh_digests={str(k): str(v) for k, v in document["mesh_digests"].items()},
        outlines=outlines,
        outer_box=None if box is None else _matrix(box, (2, dimension), "outer_box"),
        outer_surface=outer,
        prop_names=tuple(str(name) for name in document["prop_names"]),
        goals={str(k): _matrix(v, square, "goals") for k, v in document["goals"].items()},
        basis={str(k): _basis(entry) for k, entry in document["basis"].items()},
        T_room_scene=_matrix(document["T_room_scene"], square, "T_room_scene"),
        notes=dict(document["notes"]),
        estimated_error_max_mm=estimates["estimated_error_max_mm"],
        estimated_error_rms_mm=estimates["estimated_error_rms_mm"],
        **numbers,
    )


def _basis(entry: dict[str, Any]) -> BasisProp:
    x, y, z = _matrix(entry["centre"], (3,), "basis centre").tolist()
    return BasisProp((x, y, z), float(entry["half_diagonal"]))


def _matrix(value: Any, shape: tuple[int, ...], name: str) -> NDArray[np.float64]:
    matrix = np.array(value, dtype=np.float64)
    if matrix.shape != shape or not np.isfinite(matrix).all():
        raise ValueError(f"Its {name} has shape {matrix.shape}; finite {shape} is needed.")
    return matrix
