"""`touchwarp solve`: from a scene file to a warp file, or one message and nothing at all."""

from __future__ import annotations

import json
import shutil
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from touchwarp.cli.main import main
from touchwarp.cli.solve import solved_facts
from touchwarp.warp.file import load_table
from touchwarp.warp.record import SolveRecord
from touchwarp.warp.table import TableWarp

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@pytest.fixture
def plane_scene(tmp_path: Path) -> Path:
    """A plane scene, which solves in no time."""
    return Path(shutil.copy(EXAMPLES / "coaster.toml", tmp_path))


def test_a_warp_is_written_and_told_of(
    plane_scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output = plane_scene.with_suffix(".warp")
    assert main(["solve", str(plane_scene), "-o", str(output)]) == 0
    told = capsys.readouterr().out
    assert f"{output}: " in told
    assert f"Next: touchwarp check {plane_scene} {output}" in told
    corner = load_table(output)([0.05, 0.05])
    np.testing.assert_allclose(corner, [0.085, 0.06], atol=2e-4)


def test_json_tells_what_the_file_holds(
    plane_scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output = plane_scene.with_suffix(".warp")
    options = ["--tolerance-mm", "0.5", "--lambda", "4", "--json"]
    assert main(["solve", str(plane_scene), "-o", str(output), *options]) == 0
    told = json.loads(capsys.readouterr().out)
    meta = load_table(output).meta
    assert told["tolerance_mm"] == meta.tolerance_mm == 0.5
    assert told["screening_per_m2"] == meta.screening == pytest.approx(400.0)
    assert told["estimated_error_max_mm"] == pytest.approx(meta.estimated_error_max_mm)
    assert told["bytes"] == output.stat().st_size
    assert told["nodes"] > 100


def test_float16_halves_the_file(plane_scene: Path) -> None:
    sizes = []
    for options in ([], ["--float16"]):
        output = plane_scene.with_suffix(".warp")
        assert main(["solve", str(plane_scene), "-o", str(output), *options]) == 0
        sizes.append(output.stat().st_size)
    assert sizes[1] < 0.7 * sizes[0]


def test_a_prop_that_is_not_displaced_is_told_of(
    plane_scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = plane_scene.read_text()
    output = plane_scene.with_suffix(".warp")
    note = "prop 'coaster' is shown as and where it is"
    for scene, told in ((text, False), (text.split("[prop.goal]")[0], True)):
        plane_scene.write_text(scene)
        assert main(["solve", str(plane_scene), "-o", str(output)]) == 0
        assert (note in capsys.readouterr().out) == told


def test_a_tolerance_that_was_missed_is_told_of(ball_table: TableWarp, tmp_path: Path) -> None:
    record = SolveRecord(1000, 0.002, (1e-3,), (1e-6,), 0.9, 0.1, 2.0, 0.1, 0.2, False, 0.0)
    output = tmp_path / "ball.warp"
    ball_table.save(output)
    notes = []
    for error in (0.9, 1.1):
        solved = TableWarp(
            ball_table.bricks, ball_table.meta, replace(record, estimated_error_max_mm=error)
        )
        notes.append(solved_facts(solved, output, 1.0)["notes"])
    assert notes[0] == []
    assert "stayed above the tolerance" in notes[1][0]


@pytest.mark.parametrize(("error", "holds"), [(0.9, True), (1.1, False)])
def test_a_grid_that_is_capped_at_edges_is_told_of(
    error: float, holds: bool, ball_table: TableWarp, tmp_path: Path
) -> None:
    record = SolveRecord(1000, 0.002, (1e-3,), (1e-6,), error, 0.1, 2.0, 0.1, 0.2, True, 0.0)
    output = tmp_path / "ball.warp"
    ball_table.save(output)
    solved = TableWarp(ball_table.bricks, ball_table.meta, record)
    note = solved_facts(solved, output, 1.0)["notes"][-1]
    assert note.startswith("within 2 mm of sharp edges the grid is coarser")
    assert note.endswith("beyond, the tolerance holds.") == holds


BALL = """
[outer]
box = { min = [-0.2, -0.2, -0.2], max = [0.2, 0.2, 0.2] }
[[prop]]
name = "ball"
shape = { kind = "box", size = [0.1, 0.1, 0.1] }
[prop.goal]
kind = "transform"
scale = [1, 1, 1.1]
"""
SECOND = """
[[prop]]
name = "NAME"
shape = { kind = "box", size = [0.02, 0.02, 0.02] }
pose = { position = [X, 0, 0] }
"""
TABLE = """
[[fixed]]
name = "table"
plane = { point = [0, 0, Z], normal = [0, 0, 1] }
"""


def changed(old: str, new: str) -> str:
    assert old in BALL
    return BALL.replace(old, new)


def mesh(keys: str) -> str:
    return changed('shape = { kind = "box", size = [0.1, 0.1, 0.1] }', keys)


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        ("[outer]\nbox_scale = 4\n", "no props"),
        ("[[prop]\n", "not valid TOML"),
        (mesh('mesh = "gone.stl"\nunit = "mm"'), "gone.stl does not exist"),
        (mesh('mesh = "text.stl"\nunit = "mm"'), "text.stl"),
        (mesh('mesh = "empty.obj"\nunit = "mm"'), "no faces"),
        (mesh('mesh = "nan.obj"\nunit = "mm"'), "NaN or infinite"),
        (mesh('mesh = "one.obj"'), "the unit is missing"),
        (mesh('mesh = "one.obj"\nunit = "inch"'), "'inch'"),
        (mesh('shape = { kind = "cube", size = [1, 1, 1] }'), "'cube'"),
        (changed("scale", "scal"), "'scale'"),
        (changed('"transform"', '"transfrom"'), "'transform'"),
        (changed('"ball"', "7"), "7"),
        (changed("[1, 1, 1.1]", "[1, 1, 0]"), "singular"),
        (changed("[1, 1, 1.1]", "[1, 1, -1]"), "allow_mirror"),
        (changed("[1, 1, 1.1]", "[1, 1, 9]"), "virtual object"),
        (changed("size = [0.1, 0.1, 0.1]", "size = [0.4, 0.1, 0.1]"), "prop 'ball'"),
        (changed("min = [-0.2", "min = [0.3"), "inverted"),
        (BALL + SECOND.replace("NAME", "ball").replace("X", "0.15"), "used 2 times"),
        (BALL + SECOND.replace("NAME", "other").replace("X", "0.05"), "overlap or touch"),
        (BALL + TABLE.replace("Z", "0"), "table"),
        (BALL + "[objective]\nmismatch_weight = -1\n", "mismatch_weight is -1"),
        (BALL + "[objective]\nmismatch_weight = nan\n", "mismatch_weight is nan"),
        (BALL + "[objective]\ntolerance_mm = 0\n", "tolerance_mm is 0"),
    ],
)
def test_bad_input_is_one_message_and_nothing_written(
    scene: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "text.stl").write_text("this is no mesh")
    (tmp_path / "empty.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n")
    (tmp_path / "nan.obj").write_text("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (tmp_path / "one.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    path = tmp_path / "scene.toml"
    path.write_text(scene)
    before = sorted(tmp_path.iterdir())
    assert main(["solve", str(path), "-o", str(tmp_path / "out.warp")]) == 2
    told = capsys.readouterr()
    assert told.err.startswith("Error: ")
    assert message in told.err
    assert "Traceback" not in told.err
    assert told.out == ""
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("--tolerance-mm 0", "tolerance_mm is 0.0"),
        ("--tolerance-mm -1", "tolerance_mm is -1.0"),
        ("--tolerance-mm nan", "tolerance_mm is nan"),
        ("--tolerance-mm much", "'much' is not a valid float"),
        ("--lambda -1", "mismatch_weight is -1.0"),
        ("--lambda nan", "mismatch_weight is nan"),
        ("--memory-limit-gb 0", "memory_limit_gb is 0.0"),
        ("--tolerance-mm 0.001 --memory-limit-gb 0.1", "over the limit of 0.1 GB"),
    ],
)
def test_bad_options_are_bad_input(
    options: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(BALL)
    assert main(["solve", str(path), "-o", str(tmp_path / "out.warp"), *options.split()]) == 2
    told = capsys.readouterr().err
    assert message in told
    assert "Traceback" not in told
    assert sorted(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("output", "message"),
    [("nowhere/out.warp", "does not exist"), (".", "is a folder"), ("scene.toml", "also an input")],
)
def test_the_output_is_tried_before_the_scene_is_read(
    output: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "scene.toml"
    path.write_text("no scene at all")
    assert main(["solve", str(path), "-o", str(tmp_path / output)]) == 2
    assert message in capsys.readouterr().err
    assert path.read_text() == "no scene at all"


@pytest.mark.parametrize(
    ("sent", "code", "message"),
    [
        (signal.SIGINT, 130, "Interrupted; nothing half-written was left behind"),
        (signal.SIGTERM, 143, ""),
    ],
)
def test_interrupting_leaves_nothing(
    sent: signal.Signals, code: int, message: str, tmp_path: Path
) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(BALL)
    command = [sys.executable, "-m", "touchwarp", "-v", "solve", str(path)]
    with subprocess.Popen(
        [*command, "-o", str(tmp_path / "out.warp")], stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr is not None
        process.stderr.readline()  # the first step of the solve
        process.send_signal(sent)
        told = process.stderr.read()
        assert process.wait() == code
    assert message in told
    assert "Traceback" not in told
    assert sorted(tmp_path.iterdir()) == [path]
