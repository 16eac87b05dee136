"""Scans and models from elsewhere are read as their manifest describes them."""

from __future__ import annotations

import json
import time
from pathlib import Path

import numpy as np
import pytest

from touchwarp.scene import inspect_mesh, read_mesh

pytestmark = pytest.mark.needs_shared_data

NAMES = [
    "banana_ycb.obj",
    "cup_blue.obj",
    "duck.glb",
    "fuze_bottle.ply",
    "hammer.obj",
    "mug_ycb_scan_dirty.obj",
    "mustard_ycb.obj",
    "pitcher_rawscan_dirty.stl",
    "pitcher_ycb.obj",
]


def manifest(shared_data: Path, name: str) -> dict:
    entries = json.loads((shared_data / "data" / "manifest.json").read_text())
    return next(entry for entry in entries if entry["name"] == name)


@pytest.mark.parametrize("name", NAMES)
def test_counts_agree_with_an_independent_reading(shared_data: Path, name: str) -> None:
    known = manifest(shared_data, name)
    facts = inspect_mesh(shared_data / "data" / name, "m")
    assert facts.vertices == known["vertices"]
    assert facts.faces == known["faces"]
    assert facts.watertight == known["watertight"]
    assert facts.bodies == known["components"]
    assert facts.boundary_loops == known["boundary_loops"]
    assert facts.nonmanifold_edges == known["nonmanifold_edges"]
    assert facts.duplicate_faces == known["duplicate_faces"]
    genus = known["genus_of_largest"]
    assert facts.genus == (None if genus is None else round(genus))


@pytest.mark.parametrize("name", NAMES)
def test_sizes_agree_with_an_independent_reading(shared_data: Path, name: str) -> None:
    known = np.array(manifest(shared_data, name)["bbox"])
    surface = read_mesh(shared_data / "data" / name, "m", up="z")
    assert surface.bounds == pytest.approx(known, abs=2e-6)
    in_mm = read_mesh(shared_data / "data" / name, "mm", up="z")
    assert in_mm.bounds != pytest.approx(known, abs=2e-6)


def test_a_scan_reads_quickly(shared_data: Path) -> None:
    path = shared_data / "data" / "cup_blue.obj"
    read_mesh(path, "m")
    start = time.perf_counter()
    read_mesh(path, "m")
    assert time.perf_counter() - start < 0.5  # 0.06 s on an idle core
