"""Repair, remeshing and alignment on scanned meshes.

    python benchmarks/scans.py --data DIR [--json FILE]

Distances are over samples uniform in area; times are CPU time of a second run, compiled code warm.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import numpy as np
from figures import Figure, print_figures, save_json
from scipy.spatial.transform import Rotation

from touchwarp.scan.align import align
from touchwarp.scan.deviation import deviation
from touchwarp.scan.remesh import edge_length_for, remesh
from touchwarp.scan.repair import repair
from touchwarp.scan.soundness import inspect
from touchwarp.scene import read_mesh
from touchwarp.scene.pose import pose_matrix

REPAIRS = {
    "raw pitcher": ("pitcher_rawscan_dirty.stl", None, 1),
    "dirty mug": ("mug_ycb_scan_dirty.obj", None, 3),
    "dirty mug, genus 1 asked for": ("mug_ycb_scan_dirty.obj", 1, 1),
}
CLEAN = ("cup_blue.obj", "pitcher_ycb.obj", "banana_ycb.obj", "mustard_ycb.obj", "fuze_bottle.ply")
Result = TypeVar("Result")


def timed(work: Callable[[], Result]) -> tuple[Result, float]:
    start = time.process_time()
    return work(), time.process_time() - start


def repairs(data: Path) -> list[Figure]:
    """Genus, distances and time of each repair."""
    figures = []
    for name, (file, genus, expected) in REPAIRS.items():
        surface = read_mesh(data / file, "m")
        done, seconds = timed(lambda surface=surface, genus=genus: repair(surface, genus=genus))
        print(f"{name}: {done.before.faults()} → {'; '.join(done.steps)}")
        figures += [
            Figure(f"{name}: genus off by", abs(done.genus - expected), "", 0),
            Figure(f"{name}: scan to result, mean", done.from_input.mean_mm, "mm"),
            Figure(f"{name}: scan to result, p99", done.from_input.p99_mm, "mm", done.bound_mm),
            Figure(f"{name}: result to scan, p99", done.to_input.p99_mm, "mm"),
            Figure(f"{name}: area that spans holes", 100 * done.new_share, "%"),
            Figure(f"{name}: CPU time", seconds, "s"),
        ]
    return figures


def remeshings(data: Path) -> list[Figure]:
    """20,000 faces on each clean mesh."""
    figures = []
    for file in CLEAN:
        surface = read_mesh(data / file, "m")
        length = edge_length_for(surface, 20_000)
        remesh(surface, length, iterations=1)
        even, seconds = timed(lambda surface=surface, length=length: remesh(surface, length))
        genus = inspect(surface).genus, inspect(even).genus
        assert genus[0] is not None
        assert genus[1] is not None
        figures += [
            Figure(f"{file}: genus off by", abs(genus[0] - genus[1]), "", 0),
            Figure(f"{file}: p99 distance", deviation(surface, even).p99_mm, "mm"),
            Figure(f"{file}: {len(even.faces):,} faces, CPU time", seconds, "s"),
        ]
    return figures


def alignments(data: Path) -> list[Figure]:
    """Each clean mesh found again after a turn and a move."""
    figures = []
    T = pose_matrix([0.3, -0.2, 0.1], [90, 20, 130])
    for file in CLEAN[:4]:
        surface = read_mesh(data / file, "m")
        moved = surface.transformed(T)
        found, seconds = timed(lambda surface=surface, moved=moved: align(surface, moved))
        R = (found.T_prop_virtual @ T)[:3, :3]
        turn = float(np.degrees(Rotation.from_matrix(R).magnitude()))
        figures += [
            Figure(f"{file}: turn left over", turn, "°", 0.1),
            Figure(f"{file}: distance left over, p95", found.to_prop.p95_mm, "mm", 0.1),
            Figure(f"{file}: CPU time", seconds, "s"),
        ]
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--data", type=Path, default=Path())
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    figures = []
    for title, measure in [
        ("repair", repairs),
        ("remeshing", remeshings),
        ("alignment", alignments),
    ]:
        some = measure(options.data)
        print_figures(title, some)
        figures += some
    if options.json:
        save_json(options.json, figures)


if __name__ == "__main__":
    main()
