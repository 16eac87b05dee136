"""Peak memory: at most 150 bytes a node beyond a fixed base.

    python benchmarks/memory.py [--json FILE]

Each solve runs in a process of its own. The base is the peak of a solve at 1 mm tolerance, which
loads and compiles everything.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
from pathlib import Path

from figures import Figure, print_figures, save_json

import touchwarp as tw
from touchwarp.scene import parse_scene

SCENE = """
[[prop]]
name = "prop"
shape = { kind = "KIND"SIZE }
[prop.goal]
kind = "transform"
scale = [1.15, 0.9, 1.1]
rotation_deg = [0, 0, 8]
translation = [0.014, 0, 0]
"""
SIZES = {"mug": "", "box": ", size = [0.1, 0.1, 0.1]"}
PER_KIB = 1024.0


def peak_of(kind: str, tolerance_mm: float) -> tuple[int, float]:
    """Nodes, and the peak resident bytes of a process that solves once."""
    command = [sys.executable, __file__, "--one", kind, str(tolerance_mm)]
    output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    nodes, peak = json.loads(output)
    return int(nodes), float(peak)


def solve_one(kind: str, tolerance_mm: float) -> None:
    """Solve, print nodes and peak."""
    scene = parse_scene(SCENE.replace("KIND", kind).replace("SIZE", SIZES[kind]))
    warp = tw.solve(scene, tolerance_mm=tolerance_mm)
    assert warp.solution is not None
    # ru_maxrss is in KiB on Linux, in bytes on macOS
    unit = 1.0 if sys.platform == "darwin" else PER_KIB
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit
    print(json.dumps([warp.solution.nodes, peak]))


def measure(kind: str, tolerances: list[float]) -> list[Figure]:
    """Bytes a node beyond the base."""
    least, base = peak_of(kind, 1.0)
    figures = [Figure(f"{kind}: base, {least:,} nodes", base / 1e6, "MB")]
    for tolerance in tolerances:
        nodes, peak = peak_of(kind, tolerance)
        what = f"{kind}, tolerance {tolerance:g} mm, {nodes:,} nodes"
        figures.append(Figure(f"{what}: peak", peak / 1e6, "MB"))
        grown = (peak - base) / max(nodes - least, 1)
        figures.append(Figure(f"{what}: beyond the base", grown, "bytes a node", at_most=150.0))
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--one", nargs=2, metavar=("KIND", "TOLERANCE"), help=argparse.SUPPRESS)
    parser.add_argument("--tolerance-mm", type=float, nargs="*", default=[0.1, 0.05])
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    if options.one:
        solve_one(options.one[0], float(options.one[1]))
        return
    figures = [figure for kind in SIZES for figure in measure(kind, options.tolerance_mm)]
    print_figures("peak memory", figures)
    if options.json:
        save_json(options.json, figures)


if __name__ == "__main__":
    main()
