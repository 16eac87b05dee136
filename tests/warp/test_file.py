"""Warp files: what is saved is loaded, whole; what is damaged is told."""

from __future__ import annotations

import json
import os
import signal
import struct
import subprocess
import sys
import time
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from safetensors import safe_open
from safetensors.numpy import save_file

import touchwarp.warp.file as warp_file
from tests.warp.tables import (
    META,
    environment,
    points_in,
    sliding_bricks,
    sphere_bricks,
    sphere_table,
    turned,
    turned_bricks,
)
from touchwarp.errors import OutputError, WarpFileError
from touchwarp.warp.bricks import Bricks
from touchwarp.warp.file import coarse_first, load_table, load_warp
from touchwarp.warp.meta import WarpMeta
from touchwarp.warp.table import TableWarp
from touchwarp.warp.topology import validate_bricks


def loaded(path: Path) -> TableWarp:
    warp = load_warp(path)
    assert isinstance(warp, TableWarp)
    return warp


def same(a: Any, b: Any) -> bool:
    if isinstance(a, dict):
        return list(a) == list(b) and all(same(a[key], b[key]) for key in a)
    if hasattr(a, "__dataclass_fields__"):
        return all(same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
    return bool(np.array_equal(a, b)) if isinstance(a, np.ndarray) else bool(a == b)


TABLES = {"plain": sphere_bricks, "turned": turned_bricks, "sliding": sliding_bricks}


@pytest.mark.parametrize("table", TABLES)
def test_a_loaded_warp_is_the_saved_one(table: str, tmp_path: Path) -> None:
    bricks = TABLES[table]()
    TableWarp(bricks, META, solution="record").save(tmp_path / "a.warp")
    warp = loaded(tmp_path / "a.warp")
    assert same(warp.bricks, bricks)
    assert same(warp.meta, META)
    assert warp.solution is None
    x = points_in(bricks, 200)
    np.testing.assert_array_equal(warp(x), TableWarp(bricks, META)(x))
    assert os.listdir(tmp_path) == ["a.warp"]


def test_sameness_rejects_a_changed_meta() -> None:
    for change in (
        {"goals": {}},
        {"T_room_scene": turned()},
        {"notes": {"cycles": 4}},
        {"outlines": {}},
        {"outer_surface": None},
    ):
        assert not same(replace(META, **change), META)


def test_a_bare_meta_and_a_carried_warp_are_kept(tmp_path: Path) -> None:
    TableWarp(sphere_bricks(), WarpMeta()).at(turned()).save(tmp_path / "a.warp")
    warp = loaded(tmp_path / "a.warp")
    assert same(warp.meta, WarpMeta(T_room_scene=turned()))
    np.testing.assert_array_equal(
        warp.bricks.T_scene_table, turned() @ sphere_bricks().T_scene_table
    )


def shuffled(bricks: Bricks) -> Bricks:
    """The same table with bricks and values in any order."""
    random = np.random.default_rng(0)
    order, rows = random.permutation(len(bricks.slot)), random.permutation(len(bricks.values))
    new = np.full(len(order) + 1, -1, np.int32)
    new[order] = np.arange(len(order))
    new_row = np.full(len(rows) + 1, -1, np.int32)
    new_row[rows] = np.arange(len(rows))
    return replace(
        bricks,
        root=new[bricks.root],
        child=new[bricks.child[order]],
        slot=new_row[bricks.slot[order]],
        values=bricks.values[rows],
    )


def test_bricks_are_stored_coarse_first_in_whatever_order_they_come(tmp_path: Path) -> None:
    bricks = shuffled(sphere_bricks())
    TableWarp(bricks, META).save(tmp_path / "a.warp")
    warp = loaded(tmp_path / "a.warp")
    x = points_in(bricks, 300)
    np.testing.assert_array_equal(warp(x), TableWarp(bricks, META)(x))
    level = validate_bricks(warp.bricks).level
    assert (np.diff(level) >= 0).all()
    assert (np.diff(warp.bricks.slot[warp.bricks.slot >= 0]) == 1).all()
    assert not (np.diff(validate_bricks(bricks).level) >= 0).all()
    in_order = sphere_bricks()
    assert coarse_first(in_order, validate_bricks(in_order))[0] is in_order


def test_level_starts_let_a_reader_fetch_coarse_levels_first(tmp_path: Path) -> None:
    bricks = sphere_bricks()
    TableWarp(bricks, META).save(tmp_path / "a.warp")
    with safe_open(tmp_path / "a.warp", "numpy") as file:
        meta = json.loads(file.metadata()["meta"])
        coarse = file.get_slice("values")[: meta["level_slots"][1]]
    level = validate_bricks(bricks).level
    assert meta["level_bricks"] == [0, 8, 8 + (level == 1).sum(), len(level)]
    rows = bricks.slot[(level == 0) & (bricks.slot >= 0)]
    np.testing.assert_array_equal(coarse, bricks.values[rows])


def test_float16_costs_what_it_tells(tmp_path: Path) -> None:
    warp = sphere_table()
    warp.save(tmp_path / "whole.warp")
    warp.save(tmp_path / "half.warp", dtype="float16")
    half = loaded(tmp_path / "half.warp")
    assert half.bricks.values.dtype == np.float16
    x = points_in(sphere_bricks(), 5000)
    lost = np.linalg.norm(half(x) - warp(x), axis=1).max() * 1e3
    assert 0.3 * half.meta.storage_error_mm < lost <= half.meta.storage_error_mm < 0.02
    assert 0.0 < half.meta.storage_jump < 2e-5
    size = [(tmp_path / f"{name}.warp").stat().st_size for name in ("half", "whole")]
    assert size[0] < 0.55 * size[1]
    half.save(tmp_path / "again.warp", dtype="float16")
    assert same(loaded(tmp_path / "again.warp").bricks, half.bricks)


def test_values_too_large_for_float16_are_not_stored_so(tmp_path: Path) -> None:
    large = replace(sphere_bricks(), values=sphere_bricks().values + np.float32(1e5))
    with pytest.raises(ValueError, match="too large for float16; store the warp as float32"):
        TableWarp(large, META).save(tmp_path / "a.warp", dtype="float16")
    with pytest.raises(ValueError, match="cannot be stored as 'float64'; float32 or float16"):
        sphere_table().save(tmp_path / "a.warp", dtype="float64")  # type: ignore[arg-type]
    assert os.listdir(tmp_path) == []


def parts(tmp_path: Path) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Tensors and document of a sound file."""
    sphere_table().save(tmp_path / "sound.warp")
    with safe_open(tmp_path / "sound.warp", "numpy") as file:
        tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        return tensors, json.loads(file.metadata()["meta"])


def spoil(tensors: dict[str, Any], meta: dict[str, Any], what: str) -> None:
    """Damage the parts of a file in one way."""
    if what == "cycle":
        tensors["child"][-1, 0] = 0
    elif what == "index out of range":
        tensors["child"][0, 0] = 99_999
    elif what == "NaN":
        tensors["values"][2, 1, 1, 1, 1] = np.nan
    elif what == "frame type":
        tensors["spacing"] = tensors["spacing"].astype(np.float32)
    elif what == "frame sheared":
        tensors["T_scene_table"][0, 1] = 0.5
    elif what == "channels":
        tensors["values"] = tensors["values"][..., :2].copy()
    elif what == "order":
        meta["level_bricks"][1] += 1
    elif what == "outline":
        tensors["outline.0.faces"][0, 0] = 77
    elif what == "box":
        meta["outer_box"] = [[0, 0, 0]]
    elif what == "kind":
        meta["kind"] = "wrap"
    elif what == "dimension":
        meta["dimension"] = 4
    elif what == "bases":
        meta["kind"] = "bases"
    elif what.startswith("no "):
        (tensors if what[3:] in tensors else meta).pop(what[3:])


@pytest.mark.parametrize(
    ("what", "told"),
    [
        ("cycle", "names a brick of depth .* twice"),
        ("index out of range", "names bricks -1 to 99999"),
        ("NaN", "hold NaN or infinity"),
        ("frame type", "spacing is of type float32; float64 is needed"),
        ("frame sheared", "T_scene_table is not rigid"),
        ("channels", "have 2 channels; the 3 components of u are needed"),
        ("order", "not in order of level, as level_bricks tells it"),
        ("outline", "Faces refer to vertices 1 to 77"),
        ("box", r"Its outer_box has shape \(1, 3\); finite \(2, 3\) is needed"),
        ("kind", "It holds 'wrap'; 'warp' or 'bases' is needed"),
        ("dimension", "It has 4 dimensions"),
        ("bases", "one for each prop is needed"),
        ("no slot", "'slot' is missing"),
        ("no outline.0.virtual", r"'outline\.0\.virtual' is missing"),
        ("no screening", "'screening' is missing"),
        ("no mirror_depth", "'mirror_depth' is missing"),
    ],
)
def test_an_inconsistent_file_is_told(what: str, told: str, tmp_path: Path) -> None:
    tensors, meta = parts(tmp_path)
    spoil(tensors, meta, what)
    path = tmp_path / "bad.warp"
    metadata = {"format": "touchwarp-warp", "version": "1", "meta": json.dumps(meta)}
    save_file(tensors, path, metadata)
    with pytest.raises(WarpFileError, match=rf"bad\.warp is inconsistent: .*{told}"):
        load_warp(path)


def test_an_undamaged_copy_is_not_refused(tmp_path: Path) -> None:
    tensors, meta = parts(tmp_path)
    path = tmp_path / "copy.warp"
    tensors["of a later maker"] = np.zeros(3)
    meta["of a later maker"] = "is ignored"
    save_file(tensors, path, {"format": "touchwarp-warp", "version": "1", "meta": json.dumps(meta)})
    assert same(loaded(path).bricks, sphere_bricks())


@pytest.mark.parametrize(
    ("metadata", "told"),
    [
        (None, "is a safetensors file, but no warp file"),
        ({"format": "pt"}, r"its format is 'pt', not 'touchwarp-warp'"),
        ({"format": "touchwarp-warp", "version": "2", "meta": "{}"}, "version '2' .*update"),
        ({"format": "touchwarp-warp", "version": "new", "meta": "{}"}, "version 'new'"),
        ({"format": "touchwarp-warp", "version": "1", "meta": "{"}, "truncated, damaged"),
        ({"format": "touchwarp-warp", "version": "1"}, "truncated, damaged"),
        ({"format": "touchwarp-warp", "version": "1", "meta": "{}"}, "'dimension' is missing"),
        ({"format": "touchwarp-warp", "version": "1", "meta": "[]"}, "inconsistent"),
    ],
)
def test_foreign_and_newer_files_are_told(metadata, told: str, tmp_path: Path) -> None:
    path = tmp_path / "other.safetensors"
    save_file({"values": np.zeros(3, np.float32)}, path, metadata)
    with pytest.raises(WarpFileError, match=told):
        load_warp(path)


@pytest.mark.parametrize("kept", [0, 4, 100, 3000, -1])
def test_a_truncated_file_is_told(kept: int, tmp_path: Path) -> None:
    sphere_table().save(tmp_path / "a.warp")
    data = (tmp_path / "a.warp").read_bytes()
    (tmp_path / "cut.warp").write_bytes(data[:kept])
    with pytest.raises(WarpFileError, match=r"cut\.warp cannot be read .*truncated, damaged"):
        load_warp(tmp_path / "cut.warp")


def test_what_is_no_safetensors_file_is_told(tmp_path: Path) -> None:
    (tmp_path / "a.warp").write_bytes(b"solid cube\n" * 50)
    with pytest.raises(WarpFileError, match="truncated, damaged or no warp file"):
        load_warp(tmp_path / "a.warp")
    (tmp_path / "b.warp").write_bytes(struct.pack("<Q", 10) + b"not json! ")
    with pytest.raises(WarpFileError, match="truncated, damaged or no warp file"):
        load_warp(tmp_path / "b.warp")
    for path in (tmp_path, tmp_path / "missing.warp"):
        with pytest.raises(WarpFileError, match=r"There is no warp file .*; give the path"):
            load_warp(path)


def test_bases_are_no_table(tmp_path: Path) -> None:
    from tests.warp.basis_tables import sphere_bases

    sphere_bases().save(tmp_path / "bases.warp")
    with pytest.raises(WarpFileError, match=r"holds bases, .* a warp is needed"):
        load_table(tmp_path / "bases.warp")
    sphere_table().save(tmp_path / "a.warp")
    assert isinstance(load_table(tmp_path / "a.warp"), TableWarp)


def test_a_place_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="cannot be written"):
        sphere_table().save(tmp_path / "nowhere" / "a.warp")


@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError(28, "No space left on device")])
def test_what_stops_halfway_leaves_the_old_file(error, tmp_path: Path, monkeypatch) -> None:
    path = tmp_path / "a.warp"
    sphere_table().save(path)
    before = path.read_bytes()

    def stopped(tensors: Any, file: Path, metadata: Any) -> None:
        Path(file).write_bytes(b"half of it")
        raise error

    monkeypatch.setattr(warp_file, "save_file", stopped)
    with pytest.raises((KeyboardInterrupt, OutputError)):
        sphere_table().save(path)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["a.warp"]


def test_ctrl_c_while_saving_leaves_a_whole_file_or_none(tmp_path: Path) -> None:
    script = (
        "import os, sys; from pathlib import Path\n"
        "from tests.warp.tables import sphere_table\n"
        "parent = os.getppid()\n"
        "warp = sphere_table(); print('ready', flush=True)\n"
        "while os.getppid() == parent: warp.save(Path(sys.argv[1]))\n"
    )
    path = tmp_path / "a.warp"
    running = subprocess.Popen(
        [sys.executable, "-c", script, str(path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env=environment(),
    )
    assert running.stdout is not None
    with running.stdout:
        assert running.stdout.readline() == b"ready\n"
        time.sleep(0.12)
        running.send_signal(signal.SIGINT)
        running.wait(timeout=120)
    assert set(os.listdir(tmp_path)) <= {"a.warp"}
    if path.exists():
        assert same(loaded(path).bricks, sphere_bricks())
