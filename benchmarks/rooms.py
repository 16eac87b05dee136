"""A 3 cm knob beside a 60 cm crate, 0.9 m apart, at 0.1 mm: time and peak memory.

python benchmarks/rooms.py [--json FILE]
"""

from __future__ import annotations

import argparse
import resource
import sys
import time
from pathlib import Path

from figures import Figure, print_figures, save_json

import touchwarp as tw
from touchwarp.scene import parse_scene

SCENE = """
[outer]
box = { min = [-1, -1, -1], max = [2, 1, 1] }

[[prop]]
name = "knob"
shape = { kind = "sphere", radius = 0.015 }
pose = { position = [1.215, 0, 0] }
goal = { kind = "transform", pivot = "centre", scale = 1.3, translation = [0.005, 0, 0] }

[[prop]]
name = "crate"
shape = { kind = "box", size = [0.6, 0.6, 0.6] }
goal = { kind = "transform", pivot = "centre", scale = [0.95, 1.05, 1], translation = [0, 0.01, 0] }
"""


def measure() -> list[Figure]:
    """Time of a solve with warm code, and the peak of this process."""
    scene = parse_scene(SCENE)
    tw.solve(scene, tolerance_mm=2.0)  # compiles
    started = time.perf_counter()
    warp = tw.solve(scene, tolerance_mm=0.1)
    seconds = time.perf_counter() - started
    unit = 1.0 if sys.platform == "darwin" else 1024.0  # ru_maxrss: bytes on macOS, KiB on Linux
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit
    record = warp.solution
    assert record is not None
    return [
        Figure(f"solve, {record.nodes:,} nodes", seconds, "s", at_most=10.0),
        Figure("peak memory of the process", peak / 1e9, "GB", at_most=2.0),
        Figure("finest spacing", 1e3 * record.spacing, "mm"),
        Figure("estimated greatest error", record.estimated_error_max_mm, "mm", at_most=0.1),
        Figure("contact, 99th percentile", record.contact_p99_mm, "mm", at_most=0.1),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    figures = measure()
    print_figures("a knob and a crate in one room", figures)
    if options.json:
        save_json(options.json, figures)


if __name__ == "__main__":
    main()
