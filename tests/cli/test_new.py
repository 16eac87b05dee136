"""`touchwarp new`, `repair` and `align`: from files to a scene that solves."""

from __future__ import annotations

import io
import tomllib
from pathlib import Path

import numpy as np
import pytest

from tests.scan.scans import beaker, fine_mug, holed, on_table, stool
from touchwarp.cli.main import main
from touchwarp.errors import SceneError
from touchwarp.scan.deviation import sample
from touchwarp.scan.mesh_output import write_mesh
from touchwarp.scan.remesh import remesh
from touchwarp.scan.soundness import inspect
from touchwarp.scene import load_scene, read_mesh
from touchwarp.scene.pose import pose_matrix
from touchwarp.scene.shapes import box, cylinder, ellipsoid, make_shape, sphere
from touchwarp.scene.surface import Surface

Told = pytest.CaptureFixture[str]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_scan_on_a_table_and_a_model_become_a_scene(folder: Path, capsys: Told) -> None:
    scan = on_table(fine_mug(4e-3)).transformed(pose_matrix((0.3, 0.1, 0.05), (6, -4, 20)))
    write_mesh(folder / "scan.stl", scan, 1e-3)
    cup = make_shape("tea_cup", {}).transformed(pose_matrix((1, 2, 3), (90, 0, 0)))
    write_mesh(folder / "cup.glb", cup)
    assert main(["new", "scan.stl", "cup.glb", "--yes", "-o", "mug.toml"]) == 0
    told = capsys.readouterr().out
    assert "Its unit: mm (proposed)" in told
    assert "Goal    match: both surfaces are closed and have 1 handle." in told
    entries = tomllib.loads((folder / "mug.toml").read_text())
    assert entries["prop"][0]["goal"]["kind"] == "match"
    assert entries["prop"][0]["goal"]["base"] == [0, 0, -1]
    assert entries["fixed"][0]["plane"] == {"point": [0, 0, 0], "normal": [0, 0, 1]}
    scene = load_scene(folder / "mug.toml")
    assert inspect(scene.props[0].surface).genus == 1
    shown = scene.props[0].goal.virtual  # type: ignore[union-attr]
    # it lay on its side in its file, and stands on the table in the scene
    assert shown.bounds[0, 2] == pytest.approx(0, abs=1e-4)
    assert np.ptp(shown.bounds, axis=0)[2] == pytest.approx(0.058, abs=1e-3)


@pytest.mark.parametrize(("virtual", "held"), [(beaker(), True), (stool(), False)])
def test_a_virtual_foot_is_closed_where_the_scan_has_a_flat_one(
    virtual: Surface, held: bool, folder: Path
) -> None:
    scan = on_table(remesh(cylinder(0.04, 0.09), 4e-3)).transformed(
        pose_matrix((0.3, 0.1, 0.05), (6, -4, 20))
    )
    write_mesh(folder / "scan.stl", scan, 1e-3)
    write_mesh(folder / "seen.glb", virtual)
    assert main(["new", "scan.stl", "seen.glb", "--unit", "mm", "--yes", "-o", "can.toml"]) == 0
    text = (folder / "can.toml").read_text()
    goal = tomllib.loads(text)["prop"][0]["goal"]
    assert goal["kind"] == "match"
    assert "# Areas are evened out to a spread of 0.15; area_weight = 0.5 lets them" in text
    assert ("a hollow 4 mm deep below it is closed" in text) == held
    # what stands on three legs has no one foot to keep on the table, and that is told
    assert (goal.get("base") == [0, 0, -1]) == held
    assert ("do not both stand on one flat face" in text) == (not held)
    shown = load_scene(folder / "can.toml").props[0].goal.virtual  # type: ignore[union-attr]
    on = np.abs(shown.vertices[:, 2]) < 5e-6
    assert on[shown.faces].all(axis=1).any()
    assert inspect(shown).genus == 0
    # what stands on the table is a whole disc, or three apart from the middle
    spread = np.linalg.norm(shown.vertices[on][:, :2] - shown.vertices[on][:, :2].mean(0), axis=1)
    assert (spread.min() < 0.005) == held


def test_where_handles_differ_a_transform_is_written_that_solves(
    folder: Path, capsys: Told
) -> None:
    write_mesh(folder / "block.ply", box([0.08, 0.08, 0.09]))
    write_mesh(folder / "mug.ply", make_shape("mug", {}))
    units = ["--unit", "m", "--virtual-unit", "m"]
    assert main(["new", "block.ply", "mug.ply", *units, "--yes", "-o", "block.toml"]) == 0
    goal = tomllib.loads((folder / "block.toml").read_text())["prop"][0]["goal"]
    assert goal["kind"] == "transform"
    assert "no handle and the virtual object 1 handle" in (folder / "block.toml").read_text()
    scene = load_scene(folder / "block.toml")
    box_now = scene.props[0].goal.affine(scene.props[0].surface.bounds)  # type: ignore[union-attr]
    stretched = scene.props[0].surface.transformed(box_now).bounds
    assert np.ptp(stretched, axis=0)[2] == pytest.approx(0.095, rel=1e-3)
    told = capsys.readouterr().out
    assert "So the prop is stretched to the box around mug" in told
    assert "is not closed" not in told
    assert main(["solve", "block.toml", "-o", "block.warp", "--tolerance-mm", "5"]) == 0


def test_a_scan_that_cannot_be_closed_is_told_of(
    folder: Path, capsys: Told, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(surface: Surface, **options: object) -> None:
        raise SceneError("no repair keeps the topology. Ask for another genus (--genus).")

    monkeypatch.setattr("touchwarp.scan.preparation.repair", refused)
    can = remesh(cylinder(0.03, 0.1), 5e-3)
    write_mesh(folder / "can.ply", holed(can, np.array([[0.03, 0, 0.05]]), 0.01))
    write_mesh(folder / "ball.glb", sphere(0.04))
    assert main(["new", "can.ply", "ball.glb", "--unit", "m", "--yes", "-o", "can.toml"]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "Note: can is not closed: no repair keeps the topology. Ask for another genus" in told
    assert "options of `touchwarp repair`; give what it writes to `touchwarp new`" in told


@pytest.mark.parametrize(("size", "told"), [(0.4, True), (0.12, False)])
def test_a_virtual_object_of_another_size_is_told_of(
    size: float, told: bool, folder: Path, capsys: Told
) -> None:
    write_mesh(folder / "a.ply", box([0.1, 0.05, 0.05]))
    write_mesh(folder / "b.glb", box([size, size / 2, size / 2]))
    assert main(["new", "a.ply", "b.glb", "--unit", "m", "--yes", "-o", "a.toml"]) == 0
    assert ("Note: b is 4 times as long as a, and hands" in capsys.readouterr().out) == told


def test_measured_points_become_a_shape(folder: Path, capsys: Told) -> None:
    can = cylinder(0.03, 0.12).transformed(pose_matrix((0.2, 0.1, 0), (0, 0, 0)))
    points = sample(can, 60, np.random.default_rng(0))[0]
    np.savetxt(folder / "touched.csv", points, delimiter=",")
    write_mesh(folder / "egg.glb", ellipsoid([0.06, 0.06, 0.13], 0.2))
    arguments = ["new", "--fit", "cylinder", "touched.csv", "egg.glb", "--yes", "-o", "can.toml"]
    assert main(arguments) == 0
    assert "Fitted a cylinder fitted to 60 points" in capsys.readouterr().out
    scene = load_scene(folder / "can.toml")
    assert abs(scene.props[0].surface.bounds - can.bounds).max() < 5e-4
    text = (folder / "can.toml").read_text()
    # its caps are fans of many triangles, which a map of surfaces does not bear
    assert "remeshed to" in text
    assert tomllib.loads(text)["prop"][0]["goal"]["kind"] == "match"


def test_questions_need_a_terminal_or_an_option(
    folder: Path, capsys: Told, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO(""))
    write_mesh(folder / "a.stl", box([0.1, 0.1, 0.1]), 1e-3)
    write_mesh(folder / "b.glb", sphere(0.05, 0.5))
    assert main(["new", "a.stl", "b.glb", "-o", "a.toml"]) == 2
    assert "--unit, or --yes" in capsys.readouterr().err
    assert not (folder / "a.toml").exists()


def test_an_answer_that_makes_no_sense_is_asked_for_again(
    folder: Path, capsys: Told, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO("milli\n-2\nmm\n"))
    write_mesh(folder / "a.stl", box([0.1, 0.1, 0.1]), 1e-3)
    assert main(["new", "a.stl", "gone.glb", "-o", "a.toml"]) == 2
    told = capsys.readouterr()
    assert told.out.count("Its unit") == 3
    assert "Error: unknown unit 'milli'" in told.out
    assert "gone.glb does not exist" in told.err  # the third answer was taken


def test_sizes_are_told_as_people_say_them(
    folder: Path, capsys: Told, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO(""))
    write_mesh(folder / "a.stl", box([0.26, 0.1, 0.1]), 1e-3)
    write_mesh(folder / "b.glb", sphere(0.05, 0.5))
    assert main(["new", "a.stl", "b.glb", "-o", "a.toml"]) == 2
    sizes = "260 mm if it is in mm, 2.6 m if it is in cm, 260 m if it is in m, 6.6 m if it is in in"
    assert f"a.stl is {sizes}. Its unit" in capsys.readouterr().err


def test_both_files_are_opened_before_any_long_work(
    folder: Path, capsys: Told, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("touchwarp.scan.preparation.prepare", lambda *a, **k: pytest.fail("worked"))
    write_mesh(folder / "a.stl", box([0.1, 0.1, 0.1]), 1e-3)
    assert main(["new", "a.stl", "gone.glb", "--unit", "mm", "-o", "a.toml"]) == 2
    assert "gone.glb does not exist" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["new", "a.stl", "b.glb", "-o", "a.scene"], "a scene file (.toml) is needed"),
        (["new", "a.stl", "c.glb", "--unit", "mm", "-o", "a.toml"], "c.glb does not exist"),
        (["new", "--fit", "box", "none.csv", "b.glb", "-o", "a.toml"], "cannot be read as a table"),
        (["repair", "a.stl", "-o", "out.ply"], "the unit is missing"),
        (["repair", "a.stl", "--unit", "mm", "-o", "out.blend"], "no mesh can be written"),
        (["repair", "none.stl", "--unit", "mm", "-o", "out.stl"], "Error: mesh file none.stl"),
        (["align", "a.stl", "b.glb", "--unit", "mm", "-o", "no.toml"], "does not exist"),
    ],
)
def test_bad_input(arguments: list[str], message: str, folder: Path, capsys: Told) -> None:
    write_mesh(folder / "a.stl", box([0.1, 0.1, 0.1]), 1e-3)
    write_mesh(folder / "b.glb", sphere(0.05, 0.5))
    assert main(arguments) == 2
    assert message in capsys.readouterr().err


def test_repair_tells_what_it_did(folder: Path, capsys: Told) -> None:
    open_box = holed(sphere(0.05, 0.1), np.array([[0, 0, 0.05]]), 0.01)
    write_mesh(folder / "scan.stl", open_box, 1e-3)
    assert main(["repair", "scan.stl", "--unit", "mm", "-o", "whole.stl"]) == 0
    told = capsys.readouterr().out
    assert "one closed surface, genus 0" in told
    assert "1 hole capped" in told
    whole = read_mesh(folder / "whole.stl", "mm")
    assert inspect(whole).sound


def test_align_keeps_upright_what_fits_about_as_well(folder: Path, capsys: Told) -> None:
    write_mesh(folder / "egg.ply", ellipsoid([0.1, 0.1, 0.108], 0.5))
    write_mesh(folder / "die.ply", box([0.086, 0.08, 0.08]))
    turned = {}
    for rotation in ("auto", "any"):
        arguments = ["align", "egg.ply", "die.ply", "--unit", "m", "--virtual-unit", "m"]
        assert main([*arguments, "--rotation", rotation]) == 0
        pose = tomllib.loads(capsys.readouterr().out.splitlines()[0])["pose"]
        turned[rotation] = pose_matrix((0, 0, 0), pose["rotation_deg"])[2, 2]
    assert turned["auto"] == pytest.approx(1, abs=1e-9)
    assert abs(turned["any"]) < 0.5  # the twin: the nearest pose is tilted by more than 60°


def test_align_prints_a_pose_and_puts_it_into_a_scene(folder: Path, capsys: Told) -> None:
    brick = box([0.1, 0.06, 0.03])
    write_mesh(folder / "a.ply", brick)
    write_mesh(folder / "b.ply", brick.transformed(pose_matrix((0.1, 0, 0), (0, 0, 30))), 1e-2)
    arguments = ["align", "a.ply", "b.ply", "--unit", "m", "--virtual-unit", "cm"]
    arguments += ["--rotation", "any"]
    assert main([*arguments, "-o", "there.ply"]) == 0
    told = capsys.readouterr().out
    pose = tomllib.loads(told.splitlines()[0])["pose"]
    assert "4 poses fit equally well" in told
    moved = read_mesh(folder / "b.ply", "cm").transformed(
        pose_matrix(pose["position"], pose["rotation_deg"])
    )
    assert abs(moved.bounds - brick.bounds).max() < 1e-5
    assert abs(read_mesh(folder / "there.ply", "m").bounds - brick.bounds).max() < 1e-5
    scene = folder / "s.toml"
    scene.write_text(
        '[[prop]]\nname = "a"\nmesh = "a.ply"\nunit = "m"\n[prop.goal]\nkind = "match"\n'
        'virtual_mesh = "b.ply"\nunit = "cm"\n'
    )
    assert main([*arguments, "-o", "s.toml"]) == 0
    shown = load_scene(scene).props[0].goal.virtual  # type: ignore[union-attr]
    assert abs(shown.bounds - brick.bounds).max() < 1e-5
