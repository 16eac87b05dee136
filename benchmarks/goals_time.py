"""`match` and `area_preserving` at 10,000 faces a side: seconds from mesh files to the goal.

    NUMBA_NUM_THREADS=2 python benchmarks/goals_time.py --data DIR [--only NAME ...] [--json FILE]

Both surfaces are remeshed to triangles of one size, at least 10,000 of them, and written to files;
what is timed begins with reading these. Nothing is cached but compiled code: the first of `RUNS`
is not counted. Seconds are those of a clock on the wall, so they mean nothing beside other work.
What is claimed of the maps themselves is measured on the same goals.
"""

from __future__ import annotations

import argparse
import math
import os
import time
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from figures import Figure, print_figures, save_json
from goals_maps import aligned, goal_of, judged, pairs

from touchwarp.scan.mesh_output import write_mesh
from touchwarp.scan.remesh import edge_length_for, remesh
from touchwarp.scene import Surface, read_mesh

FACES = 10_000
PAIRS = ("mug → tea cup", "mustard → banana", "cube → sphere", "cup → pitcher")
SECONDS = {"area_preserving": 5.0, "match": 20.0}
RUNS = 4


def of_size(surface: Surface) -> Surface:
    """The surface in triangles of one size, `FACES` or a few more."""
    length = edge_length_for(surface, FACES)
    while True:
        even = remesh(surface, length)
        if len(even.faces) >= FACES:
            return even
        length *= 0.995 * math.sqrt(len(even.faces) / FACES)


def timed(kind: str, files: tuple[Path, Path], name: str) -> list[Figure]:
    """The figures of one kind between two mesh files."""
    seconds = []
    for _ in range(RUNS):
        start = time.perf_counter()
        prop, virtual = (read_mesh(file, "m") for file in files)
        goal = goal_of(kind, prop, virtual)
        seconds.append(time.perf_counter() - start)
    claim = f"{name}, {kind}: wall, median of {RUNS - 1}"
    wall = Figure(claim, median(seconds[1:]), "s", at_most=SECONDS[kind])
    figures = [wall, *judged(name, kind, goal)]
    sides = f"{len(prop.faces)} and {len(virtual.faces)} faces"
    print_figures(f"{name}: {sides}, the goal {len(goal.faces)}", figures)
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--only", nargs="*", default=PAIRS)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    os.environ["TOUCHWARP_CACHE"] = ""
    figures: list[Figure] = []
    for name in options.only:
        prop, virtual = pairs(options.data)[name]()
        virtual = aligned(name, prop, virtual)
        with TemporaryDirectory() as folder:
            files = Path(folder, "prop.ply"), Path(folder, "virtual.ply")
            for file, surface in zip(files, (prop, virtual), strict=True):
                write_mesh(file, of_size(surface))
            for kind in SECONDS:
                figures += timed(kind, files, name)
    if options.json:
        save_json(options.json, figures)


if __name__ == "__main__":
    main()
