"""A second solve with another λ or goal takes at most a third of the first.

    python benchmarks/resolve.py [--json FILE]

The demo's mug on its table; the WarpSolver is kept.
"""

from __future__ import annotations

import argparse
import dataclasses
import tempfile
import time
from pathlib import Path
from typing import Any

import igl
import numpy as np
from figures import Figure, print_figures, save_json

import touchwarp as tw
from touchwarp.cli.demo_files import write_input

OTHER = tw.TransformGoal(scale=[1.1, 1.25, 0.7], rotation_deg=[0, 0, 20], translation=[0, 0.01, 0])


def measure(scene: tw.Scene) -> list[Figure]:
    """Times of a first and of later solves."""
    tw.WarpSolver(scene, tolerance_mm=1.0).solve({"mug": OTHER}, mismatch_weight=1.0)  # compiles
    started = time.perf_counter()
    solver = tw.WarpSolver(scene)
    before = solver.solve()
    first = time.perf_counter() - started
    figures = [Figure(f"first solve, {before.bricks.slot.shape[0]:,} bricks", first, "s")]
    changes: list[tuple[str, dict[str, Any]]] = [
        ("λ = 0.1", {"mismatch_weight": 0.1}),
        ("λ = 1", {"mismatch_weight": 1.0}),
        ("λ = 0 again", {"mismatch_weight": 0.0}),
        ("another goal", {"changed_goals": {"mug": OTHER}}),
    ]
    bricks = len(before.bricks.slot)
    random = np.random.default_rng(0)
    low, high = before.outer_box
    points = random.uniform(low, high, (400_000, 3))
    surface = scene.props[0].surface
    inside = igl.fast_winding_number(np.array(surface.vertices), np.array(surface.faces), points)
    points = points[(points[:, 2] > 0.0) & (inside < 0.5)]  # Ω: elsewhere nothing is solved for
    for what, change in changes:
        started = time.perf_counter()
        warp = solver.solve(**change)
        seconds = time.perf_counter() - started
        kept = "grid kept" if len(warp.bricks.slot) == bricks else "grid grown"
        bricks = len(warp.bricks.slot)
        figures.append(Figure(f"{what}, {kept}: time", seconds, "s"))
        share = seconds / first
        limit = 1 / 3 if bricks == len(before.bricks.slot) else None
        figures.append(Figure(f"{what}: share of the first solve", share, "", at_most=limit))
    # the solver keeps its ∂Ω1, while `box_scale` follows the virtual object
    fresh = tw.solve(dataclasses.replace(solver.scene, outer=tw.Outer(box=before.outer_box)))
    gap = np.linalg.norm(warp.displacement(points) - fresh.displacement(points), axis=1)
    gap_mm = 1e3 * float(gap.max())
    figures.append(Figure("the last differs from a fresh solve by", gap_mm, "mm", at_most=0.2))
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        write_input(Path(folder))
        figures = measure(tw.load_scene(Path(folder) / "mug.toml"))
    print_figures("solving again", figures)
    if options.json:
        save_json(options.json, figures)


if __name__ == "__main__":
    main()
