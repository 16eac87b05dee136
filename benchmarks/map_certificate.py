"""How long it takes to measure a map from shape to shape, by CPU and by clock.

python benchmarks/map_certificate.py
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from time import perf_counter, process_time

import numpy as np
from figures import Figure, print_figures, save_json

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tests.goals.hand_made_maps import cube_map, ellipsoid_map, identity_map
from touchwarp.goals import Goal
from touchwarp.goals.measure import measure_map
from touchwarp.scene.shapes import make_shape

MAPS = {
    "ball to ellipsoid": lambda: ellipsoid_map(0.03),
    "cube to ball": lambda: cube_map(edge=4e-3),
    "cup to itself": lambda: identity_map(make_shape("tea_cup", {})),
}
CLAIM_S = 3.0
"""For maps of about 10,000 faces."""


def seconds(goal: Goal, repeats: int) -> tuple[float, float]:
    """Least CPU and clock time, s; the first run, which may compile, is not counted."""
    measure_map(goal)
    times = []
    for _ in range(repeats):
        cpu, clock = process_time(), perf_counter()
        measure_map(goal)
        times.append((process_time() - cpu, perf_counter() - clock))
    least = np.min(times, axis=0)
    return float(least[0]), float(least[1])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    figures = []
    for name, make in MAPS.items():
        goal = make()
        cpu, clock = seconds(goal, options.repeats)
        title = f"{name}, {len(goal.faces):,} faces"
        figures.append(Figure(f"{title}: CPU", cpu, "s", at_most=CLAIM_S))
        figures.append(Figure(f"{title}: clock", clock, "s", at_most=CLAIM_S))
    print_figures("measuring a map", figures)
    if options.json:
        save_json(options.json, figures)


if __name__ == "__main__":
    main()
