"""A draft reads back as it was meant, and a pose takes the place of an older one."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from touchwarp.errors import OutputError, SceneError
from touchwarp.scan.mesh_output import mesh_format, write_mesh
from touchwarp.scan.reading import plausible_unit, plausible_up, propose_reading
from touchwarp.scan.scene_draft import SceneDraft, posed_scene
from touchwarp.scene import read_mesh
from touchwarp.scene.shapes import cylinder, make_shape

GOAL = {"kind": "match", "virtual_mesh": "a/cup.glb", "pose": {"position": [1, 2, 3]}}


def test_a_draft_is_toml_with_its_notes() -> None:
    notes = {"goal": ["because"], "pose": ["found by search"]}
    draft = SceneDraft("a mug", {"name": "mug", "mesh": "mug.stl"}, GOAL, notes)
    text = draft.text("mug.toml")
    read = tomllib.loads(text)
    assert read["prop"][0]["goal"] == GOAL
    assert "# because\n[prop.goal]" in text
    assert "# found by search\npose" in text
    assert "touchwarp solve mug.toml -o mug.warp" in text


def test_a_pose_is_replaced_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "mug.toml"
    path.write_text(SceneDraft("a mug", {"name": "mug", "mesh": "m.stl"}, GOAL).text("mug.toml"))
    before = tomllib.loads(path.read_text())
    after = tomllib.loads(posed_scene(path, Path("cup.glb"), {"pose": {"position": [4, 5, 6]}}))
    assert after["prop"][0]["goal"].pop("pose") == {"position": [4, 5, 6]}
    before["prop"][0]["goal"].pop("pose")
    assert after == before


def test_a_pose_is_replaced_however_it_is_written(tmp_path: Path) -> None:
    path = tmp_path / "mug.toml"
    path.write_text(
        "# mine\n[[prop]]\nname = 'mug'\n[prop.goal]\nkind = 'match'\n"
        "virtual_mesh = 'a/cup.glb'  # \"the cup\"\n[prop.goal.pose]\nposition = [1, 2, 3]  # old\n"
    )
    text = posed_scene(path, Path("cup.glb"), {"pose": {"position": [4, 5, 6]}, "unit": 0.5})
    goal = tomllib.loads(text)["prop"][0]["goal"]
    assert (goal["pose"], goal["unit"]) == ({"position": [4, 5, 6]}, 0.5)
    assert text.startswith("# mine\n")
    assert '# "the cup"' in text


@pytest.mark.parametrize("content", [b"[[prop\n", b"# caf\xe9\n"])
def test_a_scene_that_cannot_be_read_is_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "mug.toml"
    path.write_bytes(content)
    with pytest.raises(SceneError, match=r"mug\.toml cannot be read as a scene file"):
        posed_scene(path, Path("cup.glb"), {})


def test_a_scene_without_that_mesh_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="does not exist; `touchwarp new`"):
        posed_scene(tmp_path / "none.toml", Path("cup.glb"), {})
    path = tmp_path / "mug.toml"
    path.write_text("[[prop]]\n")
    with pytest.raises(SceneError, match=r"0 goals with virtual_mesh = 'cup\.glb'"):
        posed_scene(path, Path("cup.glb"), {})


@pytest.mark.parametrize(
    ("longest", "unit"), [(95.0, "mm"), (9.5, "cm"), (0.095, "m"), (240.0, "mm"), (4.0, "cm")]
)
def test_a_unit_is_proposed_by_size(longest: float, unit: str) -> None:
    assert plausible_unit(longest) == unit


def test_up_is_where_the_foot_is_not() -> None:
    assert plausible_up(make_shape("mug", {})) == "z"
    assert plausible_up(cylinder(0.03, 0.1)) == "z"  # both ends alike: no clear foot


@pytest.mark.parametrize("ending", ["stl", "ply", "obj", "glb"])
def test_a_mesh_is_written_and_read_back(ending: str, tmp_path: Path) -> None:
    cup = make_shape("tea_cup", {})
    path = tmp_path / f"cup.{ending}"
    write_mesh(path, cup, 1e-3)
    again = read_mesh(path, None if ending == "glb" else "mm")
    assert len(again.faces) == len(cup.faces)
    assert abs(again.bounds - cup.bounds).max() < 1e-7
    read = propose_reading(path)
    assert (read.unit, read.unit_known) == (("m", True) if ending == "glb" else ("mm", False))
    assert read.plausible


def test_an_unknown_mesh_format_is_refused() -> None:
    with pytest.raises(OutputError, match=r"the ending '\.blend'"):
        mesh_format(Path("cup.blend"))
