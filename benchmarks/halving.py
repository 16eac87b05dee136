"""Halving the finest spacing multiplies time and nodes by at most 4.6: surfaces, not volume.

    python benchmarks/halving.py [--json FILE]

The finest cells are halved from one solve to the next, in two ways: on a box of side 0.1 m by half
the edge radius at the same tolerance, which leaves cells away from its edges as they are; on that
box and a sphere by half of it and a quarter of the tolerance, with finer cells everywhere.
"""

from __future__ import annotations

import argparse
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

from figures import Figure, print_figures, save_json

import touchwarp as tw
from touchwarp.scene.shapes import make_shape

Steps = list[tuple[float, float]]

SAME_TOLERANCE: Steps = [(0.1, 4.0), (0.1, 2.0), (0.1, 1.0)]
QUARTERED: Steps = [(0.4, 4.0), (0.1, 2.0), (0.025, 1.0)]
"""tolerance_mm and edge_radius_mm of each solve."""

SHAPES: dict[str, dict[str, Any]] = {"box": {"size": [0.1, 0.1, 0.1]}, "sphere": {"radius": 0.05}}


def measure(kind: str, series: str, steps: Steps) -> list[Figure]:
    """Ratios between one solve of the series and the next."""
    surface = make_shape(kind, SHAPES[kind])
    goal = tw.TransformGoal(scale=[1.15, 0.9, 1.1], rotation_deg=[0, 0, 8])
    runs = []
    for tolerance, radius in steps:
        objective = tw.Objective(tolerance_mm=tolerance, edge_radius_mm=radius)
        scene = tw.Scene([tw.Prop(kind, surface, goal)], tw.Outer(), objective)
        tw.solve(scene, tolerance_mm=1.0)  # compiles
        started = time.perf_counter()
        record = tw.solve(scene).solution
        seconds = time.perf_counter() - started
        assert record is not None
        runs.append((1e3 * record.spacing, record.nodes, seconds))
    figures = []
    for (coarse, before, slow), (fine, after, slower) in pairwise(runs):
        halvings = coarse / fine
        what = f"{kind}, {series}, {coarse:.3g} to {fine:.3g} mm"
        limit = 4.6 if halvings == 2.0 else None
        figures += [
            Figure(f"{what}: spacing", halvings, "×"),
            Figure(f"{what}: nodes, {before:,} to {after:,}", after / before, "×", limit),
            Figure(f"{what}: time, {slow:.2f} to {slower:.2f} s", slower / slow, "×", limit),
        ]
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    figures = measure("box", "same tolerance", SAME_TOLERANCE)
    for kind in SHAPES:
        figures += measure(kind, "a quarter of the tolerance", QUARTERED)
    print_figures("halving the finest spacing", figures)
    if options.json:
        save_json(options.json, figures)


if __name__ == "__main__":
    main()
