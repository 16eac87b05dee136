"""A goal as binary glTF: the prop's surface, with the virtual shape as its morph target."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.goal import Goal
from touchwarp.outputs import replacing
from touchwarp.scene.units import up_rotation
from touchwarp.scene.uv_mesh import UvMesh

# Numbers of the glTF 2.0 specification.
_FLOAT, _UNSIGNED_INT = 5126, 5125
_VERTEX_DATA, _INDEX_DATA = 34962, 34963
_MAGIC, _JSON, _BINARY = 0x46546C67, 0x4E4F534A, 0x004E4942

_MATERIAL = {
    "name": "prop",
    "doubleSided": True,
    "pbrMetallicRoughness": {
        "baseColorFactor": [0.8, 0.8, 0.78, 1.0],
        "metallicFactor": 0.0,
        "roughnessFactor": 0.7,
    },
}


def write_morph_target(path: str | Path, goal: Goal, name: str) -> None:
    """Write a goal as GLB; the morph target "virtual" at weight 1 is the virtual shape.

    Metres, y up, as glTF defines: the scene's (x, y, z) is (x, z, −y) there.

    Args:
        path: of the .glb file.
        goal: in space.
        name: of the node and the mesh.

    Raises:
        GoalError: the goal is of a plane scene.
    """
    if goal.prop_points.shape[1] != 3:
        raise GoalError("glTF holds surfaces in space, but the goal is of a plane scene.")
    used, faces = np.unique(goal.faces, return_inverse=True)
    _write_morph(
        path, goal.prop_points[used], goal.displacement[used], faces.reshape(-1, 3), None, name
    )


def write_atlas(
    path: str | Path, atlas: UvMesh, displacement: NDArray[np.float64], name: str
) -> None:
    """Write an atlas as GLB with its texture coordinates and the morph target.

    Args:
        path: of the .glb file.
        atlas: the prop's surface, m, scene frame.
        displacement: (n, 3) m, scene axes, of the atlas's vertices.
        name: of the node and the mesh.
    """
    # In glTF (0, 0) is the texture's upper left corner.
    uv = np.stack([atlas.uv[:, 0], 1 - atlas.uv[:, 1]], axis=1)
    _write_morph(path, atlas.vertices, displacement, atlas.faces, uv, name)


def _write_morph(
    path: str | Path,
    points: NDArray[np.float64],
    displacement: NDArray[np.float64],
    faces: NDArray[np.int64],
    uv: NDArray[np.float64] | None,
    name: str,
) -> None:
    """Write the parts as one GLB mesh: m, scene frame; uv as glTF has it."""
    to_gltf = up_rotation("y").T
    buffer = _Buffer()
    attributes = {"POSITION": buffer.add(points @ to_gltf.T, "VEC3")}
    if uv is not None:
        attributes["TEXCOORD_0"] = buffer.add(uv, "VEC2")
    primitive = {
        "attributes": attributes,
        "indices": buffer.add_indices(faces),
        "targets": [{"POSITION": buffer.add(displacement @ to_gltf.T, "VEC3")}],
        "material": 0,
    }
    mesh = {
        "name": name,
        "primitives": [primitive],
        "weights": [0.0],
        "extras": {"targetNames": ["virtual"]},
    }
    document = {
        "asset": {"version": "2.0", "generator": "touchwarp"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": name}],
        "meshes": [mesh],
        "materials": [_MATERIAL],
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": len(buffer.data)}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    length = 12 + 8 + len(text) + 8 + len(buffer.data)
    with replacing(Path(path)) as temporary, temporary.open("wb") as file:
        file.write(struct.pack("<III", _MAGIC, 2, length))
        file.write(struct.pack("<II", len(text), _JSON) + text)
        file.write(struct.pack("<II", len(buffer.data), _BINARY) + buffer.data)


class _Buffer:
    """The binary part of a GLB, and what describes it; every part is a multiple of 4 bytes."""

    def __init__(self) -> None:
        self.data = b""
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, rows: NDArray[np.float64], kind: str) -> int:
        """Rows of single-precision numbers; returns the accessor's number."""
        single = np.ascontiguousarray(rows, dtype="<f4")
        limits = {"min": single.min(axis=0).tolist(), "max": single.max(axis=0).tolist()}
        return self._put(single, _VERTEX_DATA, len(single), _FLOAT, kind, limits)

    def add_indices(self, faces: NDArray[np.int64]) -> int:
        """Corners of triangles; returns the accessor's number."""
        indices = np.ascontiguousarray(faces, dtype="<u4").ravel()
        limits = {"min": [int(indices.min())], "max": [int(indices.max())]}
        return self._put(indices, _INDEX_DATA, len(indices), _UNSIGNED_INT, "SCALAR", limits)

    def _put(
        self,
        array: NDArray[Any],
        target: int,
        count: int,
        component: int,
        kind: str,
        limits: dict[str, Any],
    ) -> int:
        data = array.tobytes()
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)}
        self.views.append({**view, "target": target})
        self.accessors.append(
            {
                "bufferView": len(self.views) - 1,
                "componentType": component,
                "count": count,
                "type": kind,
                **limits,
            }
        )
        self.data += data
        return len(self.accessors) - 1
