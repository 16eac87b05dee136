"""The glTF of a goal: the prop, and the virtual shape at weight 1 of its morph target."""

from __future__ import annotations

import json
import shutil
import struct
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from touchwarp.errors import GoalError
from touchwarp.export import write_goal, write_morph_target
from touchwarp.goals import Goal
from touchwarp.scene import read_mesh, read_uv_mesh
from touchwarp.scene.shapes import make_shape, polygon

VALIDATOR = "gltf-validator@2.0.0-dev.3.10"

MUG = make_shape("mug", {})
SHOWN = MUG.vertices * [1.2, 1.2, 0.6] + [0.015, 0, 0]
GOAL = Goal(MUG.vertices, SHOWN, MUG.faces)


def parts(path: Path) -> tuple[dict[str, Any], list[np.ndarray]]:
    """The document and the arrays of its accessors, read by the specification's section 4.4."""
    data = path.read_bytes()
    assert struct.unpack("<4sII", data[:12]) == (b"glTF", 2, len(data))
    length, kind = struct.unpack("<I4s", data[12:20])
    assert kind == b"JSON"
    document = json.loads(data[20 : 20 + length])
    start = 20 + length + 8
    assert struct.unpack("<I4s", data[start - 8 : start]) == (len(data) - start, b"BIN\0")
    arrays = []
    for accessor in document["accessors"]:
        view = document["bufferViews"][accessor["bufferView"]]
        dtype = {5126: "<f4", 5125: "<u4"}[accessor["componentType"]]
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}[accessor["type"]]
        assert view["byteOffset"] % 4 == 0
        assert view["byteLength"] == 4 * width * accessor["count"]
        at = start + view["byteOffset"]
        array = np.frombuffer(data[at : at + view["byteLength"]], dtype).reshape(-1, width)
        assert accessor["min"] == array.min(axis=0).tolist()
        assert accessor["max"] == array.max(axis=0).tolist()
        arrays.append(array)
    return document, arrays


def test_the_file_holds_prop_and_virtual_shape(tmp_path: Path) -> None:
    path = tmp_path / "mug.glb"
    write_morph_target(path, GOAL, "mug")
    document, arrays = parts(path)
    (mesh,) = document["meshes"]
    (primitive,) = mesh["primitives"]
    assert mesh["extras"] == {"targetNames": ["virtual"]}
    assert mesh["weights"] == [0.0]
    points = arrays[primitive["attributes"]["POSITION"]]
    morph = arrays[primitive["targets"][0]["POSITION"]]
    faces = arrays[primitive["indices"]].reshape(-1, 3)
    to_z_up = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])  # glTF's y is the scene's z
    np.testing.assert_allclose(points @ to_z_up.T, MUG.vertices, atol=1e-8)
    np.testing.assert_allclose((points + morph) @ to_z_up.T, SHOWN, atol=2e-8)
    np.testing.assert_array_equal(faces, MUG.faces)


def test_another_reader_finds_the_prop(tmp_path: Path) -> None:
    write_morph_target(tmp_path / "mug.glb", GOAL, "mug")
    came = read_mesh(tmp_path / "mug.glb")
    np.testing.assert_allclose(came.vertices[came.faces], MUG.vertices[MUG.faces], atol=1e-8)


def test_unused_points_are_left_out(tmp_path: Path) -> None:
    extra = np.concatenate([[[9.0, 9, 9]], MUG.vertices])
    goal = Goal(extra, extra, MUG.faces + 1)
    write_morph_target(tmp_path / "mug.glb", goal, "mug")
    _, arrays = parts(tmp_path / "mug.glb")
    assert len(arrays[0]) == len(MUG.vertices)


def test_an_atlas_has_coordinates_and_the_morph_target(tmp_path: Path) -> None:
    write_goal(tmp_path / "mug.exr", GOAL, "mug", size=1024)
    document, arrays = parts(tmp_path / "mug.glb")
    (primitive,) = document["meshes"][0]["primitives"]
    uv = arrays[primitive["attributes"]["TEXCOORD_0"]]
    mesh = read_uv_mesh(tmp_path / "mug.glb")
    # (0, 0) is the upper left corner in glTF, the lower left one here.
    np.testing.assert_allclose(mesh.uv, np.c_[uv[:, 0], 1 - uv[:, 1]], atol=1e-7)
    morph = arrays[primitive["targets"][0]["POSITION"]].astype(float)
    shown = mesh.vertices + morph[:, [0, 2, 1]] * [1, -1, 1]
    expected = mesh.vertices * [1.2, 1.2, 0.6] + [0.015, 0, 0]
    np.testing.assert_allclose(shown, expected, atol=1e-7)


def test_plane_goals_are_refused(tmp_path: Path) -> None:
    square = polygon([(0, 0), (1, 0), (1, 1)])
    flat = Goal(square.vertices, square.vertices, square.faces)
    with pytest.raises(GoalError, match="glTF holds surfaces in space, but the goal is of a plane"):
        write_morph_target(tmp_path / "flat.glb", flat, "flat")


@pytest.fixture(scope="session")
def validator(request: pytest.FixtureRequest) -> Path:
    """The folder where the Khronos validator is installed, got once and kept in pytest's cache."""
    npm = shutil.which("npm")
    if npm is None or shutil.which("node") is None:
        pytest.skip("Node.js and npm are not here, which the Khronos validator needs")
    assert request.config.cache is not None
    cache = Path(request.config.cache.mkdir("gltf-validator"))
    folder = cache / "whole"
    if not folder.exists():
        # made aside and renamed: several processes may run these tests at once
        made = Path(tempfile.mkdtemp(dir=cache))
        command = [npm, "install", "--no-audit", "--no-fund", "--prefix", str(made), VALIDATOR]
        done = subprocess.run(command, capture_output=True, text=True, timeout=600)
        if done.returncode:
            pytest.fail(f"the Khronos validator cannot be got from npm:\n{done.stderr[-500:]}")
        try:
            made.rename(folder)
        except OSError:  # another was first
            shutil.rmtree(made)
    return folder


def verdict(validator: Path, path: Path) -> dict[str, Any]:
    script = (
        "const v = require('gltf-validator'); const fs = require('fs');"
        "v.validateBytes(new Uint8Array(fs.readFileSync(process.argv[1])))"
        ".then(r => console.log(JSON.stringify(r)));"
    )
    done = subprocess.run(
        ["node", "-e", script, str(path)],
        cwd=validator,
        check=True,
        capture_output=True,
        timeout=600,
    )
    report: dict[str, Any] = json.loads(done.stdout)
    return report


@pytest.mark.parametrize("name", ["mug.glb", "mug.exr"])
def test_the_khronos_validator_finds_nothing_wrong(
    validator: Path, name: str, tmp_path: Path
) -> None:
    write_goal(tmp_path / name, GOAL, "mug", size=1024)
    report = verdict(validator, tmp_path / "mug.glb")
    assert report["issues"]["numErrors"] == 0, report["issues"]["messages"]
    assert report["issues"]["numWarnings"] == 0, report["issues"]["messages"]
    assert report["info"]["hasMorphTargets"]
    assert report["info"]["totalTriangleCount"] == len(MUG.faces)


def test_the_validator_rejects_a_spoilt_file(validator: Path, tmp_path: Path) -> None:
    path = tmp_path / "mug.glb"
    write_morph_target(path, GOAL, "mug")
    path.write_bytes(path.read_bytes().replace(b'"VEC3"', b'"VEC2"', 1))
    assert verdict(validator, path)["issues"]["numErrors"] > 0
