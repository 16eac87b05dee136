"""A box of side 0.1 m shown at 0.63 of its size, against a high-order finite-element solution.

    python benchmarks/cube_reference.py CUBE.npz [--tolerance-mm 0.1] [--json FILE]

CUBE.npz holds `V`, `F`, `points`, `displacement`, `distance`; outer box of side 1 m, λ = 0.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
from figures import Figure, print_figures, save_json

import touchwarp as tw

HALF = 0.5


def solve_space(scene: tw.Scene, tolerance_mm: float) -> tw.TableWarp:
    """The table of a scene in space."""
    warp = tw.solve(scene, tolerance_mm=tolerance_mm)
    assert isinstance(warp, tw.TableWarp)
    return warp


def measure(file: Path, tolerance_mm: float) -> list[Figure]:
    """Errors at the reference's points, and times."""
    with np.load(file) as true:
        surface = tw.Surface(true["V"], true["F"].astype(np.int64))
        points, expected, distance = true["points"], true["displacement"], true["distance"]
    goal = tw.TransformGoal(pivot="centre", scale=0.63)
    middle = (surface.vertices.min(axis=0) + surface.vertices.max(axis=0)) / 2
    scene = tw.Scene(
        [tw.Prop("box", surface, goal)],
        tw.Outer(box=[middle - HALF, middle + HALF]),
        tw.Objective(tolerance_mm=tolerance_mm),
    )
    solve_space(scene, 1.0).resample((8, 8, 8))  # compiles
    started = time.perf_counter()
    warp = solve_space(scene, tolerance_mm)
    solved = time.perf_counter()
    warp.resample((128, 128, 128))
    sampled = time.perf_counter()
    error = 1e3 * np.linalg.norm(warp.displacement(points) - expected, axis=1)
    worst = int(error.argmax())
    record = warp.solution
    assert record is not None
    return [
        Figure("root mean square error", float(np.sqrt((error**2).mean())), "mm", at_most=0.05),
        Figure("greatest error", float(error[worst]), "mm", at_most=0.3),
        Figure("its distance from the box", 1e3 * float(distance[worst]), "mm"),
        Figure("estimated greatest error", record.estimated_error_max_mm, "mm"),
        Figure(f"solve, {record.nodes:,} nodes", solved - started, "s"),
        Figure("resampled to 128³", sampled - solved, "s"),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("reference", type=Path)
    parser.add_argument("--tolerance-mm", type=float, default=0.1)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    figures = measure(options.reference, options.tolerance_mm)
    print_figures(f"box 0.1 m to 0.063 m, tolerance {options.tolerance_mm:g} mm", figures)
    if options.json:
        save_json(options.json, figures)


if __name__ == "__main__":
    main()
