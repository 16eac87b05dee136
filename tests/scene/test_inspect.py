"""A mesh's facts against meshes whose faults are known by construction."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from touchwarp.errors import SceneError
from touchwarp.scene import Surface, inspect_mesh
from touchwarp.scene.shapes import box, make_shape


def written(path: Path, *surfaces: Surface) -> Path:
    offsets = np.cumsum([0] + [len(s.vertices) for s in surfaces])
    mesh = trimesh.Trimesh(
        np.concatenate([s.vertices for s in surfaces]) * 1e3,
        np.concatenate([s.faces + o for s, o in zip(surfaces, offsets, strict=False)]),
        process=False,
    )
    mesh.export(path)
    return path


def test_a_clean_mug(tmp_path: Path) -> None:
    facts = inspect_mesh(written(tmp_path / "mug.stl", make_shape("mug", {})), "mm")
    assert (facts.watertight, facts.bodies, facts.genus) == (True, 1, 1)
    assert (facts.boundary_loops, facts.nonmanifold_edges, facts.duplicate_faces) == (0, 0, 0)
    assert facts.size_mm == pytest.approx((114.5, 80, 95), abs=0.01)
    rows = dict(facts.rows())
    assert rows["size"] == "114.5 × 80 × 95 mm"
    assert rows["genus"] == "1"
    assert rows["watertight"] == "yes"


def test_every_fault_is_counted(tmp_path: Path) -> None:
    cube = box((0.1, 0.1, 0.1))
    holed = Surface(cube.vertices, cube.faces[[0, 2, 3, 4, 5, 6, 7, 8, 9, 11]])
    doubled = Surface(cube.vertices + 1, np.concatenate([cube.faces, cube.faces[:1, [1, 2, 0]]]))
    facts = inspect_mesh(written(tmp_path / "faulty.ply", holed, doubled), "mm")
    assert not facts.watertight
    assert facts.genus is None
    assert facts.bodies == 2
    assert facts.boundary_loops == 2
    assert facts.duplicate_faces == 1
    assert facts.nonmanifold_edges == 3
    assert dict(facts.rows())["watertight"] == "no"


def test_dropped_faces_are_counted(tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n")
    assert inspect_mesh(path, "m").dropped_faces == 1


def test_without_a_unit_every_size_is_shown(tmp_path: Path) -> None:
    facts = inspect_mesh(written(tmp_path / "box.obj", box((0.1, 0.2, 0.3))))
    assert facts.size_mm is None
    assert facts.size_by_unit_mm["cm"] == pytest.approx((1000, 2000, 3000))
    rows = dict(facts.rows())
    assert rows["size if in mm"] == "100 × 200 × 300 mm"
    assert "size" not in rows


def test_a_format_with_a_unit_needs_none(tmp_path: Path) -> None:
    facts = inspect_mesh(written(tmp_path / "box.3mf", box((0.1, 0.2, 0.3))))
    assert facts.size_mm == pytest.approx((100, 200, 300))
    assert facts.size_by_unit_mm == {}


def test_an_unknown_unit_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path / "box.obj", box((0.1, 0.2, 0.3)))
    with pytest.raises(SceneError, match=r"box.obj: unknown unit 'inch'. Did you mean 'in'?"):
        inspect_mesh(path, "inch")
