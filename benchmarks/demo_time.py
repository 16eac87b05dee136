"""The demo's mug from mesh file to saved table, its check, and the file's size.

    python benchmarks/demo_time.py [--repeats 5] [--json FILE]

Compiled code is warm: a first run is not counted. The median of the others is.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from pathlib import Path

from figures import Figure, print_figures, save_json

import touchwarp as tw
from touchwarp.cli.demo_files import write_input


def measure(folder: Path, repeats: int) -> list[Figure]:
    """Times and size."""
    write_input(folder)
    file = folder / "mug.warp"
    solving, checking = [], []
    for _ in range(repeats + 1):
        started = time.perf_counter()
        scene = tw.load_scene(folder / "mug.toml")
        warp = tw.solve(scene)
        warp.save(file)
        saved = time.perf_counter()
        solving.append(saved - started)
    for _ in range(2):
        started = time.perf_counter()
        report = tw.check(scene, warp)
        checking.append(time.perf_counter() - started)
    failed = [check.name for check in report.checks if check.status == "fail"]
    if failed:
        print(f"the certificate fails: {', '.join(failed)}")
    solve_time = statistics.median(solving[1:])
    nodes = warp.solution.nodes if warp.solution else 0
    return [
        Figure(f"mesh file to saved table, {nodes:,} nodes", solve_time, "s", at_most=1.5),
        Figure("first of these runs", solving[0], "s"),
        Figure("check", checking[-1], "s", at_most=10.0),
        Figure("failed checks", float(len(failed)), "", at_most=0.0),
        Figure("table file, float32", file.stat().st_size / 1e6, "MB", at_most=25.0),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        figures = measure(Path(folder), options.repeats)
    print_figures("the demo's mug", figures)
    if options.json:
        save_json(options.json, figures)


if __name__ == "__main__":
    main()
