"""Plane scenes: greatest error between concentric circles, and the time of a solve.

python benchmarks/plane.py [--json FILE]
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from figures import Figure, print_figures, save_json

import touchwarp as tw
from tests.exact import circles

CENTRE, INNER, OUTER, MOVED = (0.0012, 0.0023), 0.05, 0.18, (0.02, -0.01)


def measure(mismatch_weight: float, tolerance_mm: float) -> list[Figure]:
    """Error and time of one solve."""
    disc = tw.Surface(*circles.outline(CENTRE, INNER))
    scene = tw.Scene(
        [tw.Prop("disc", disc, tw.TransformGoal(translation=MOVED))],
        tw.Outer(surface=tw.Surface(*circles.outline(CENTRE, OUTER))),
        tw.Objective(mismatch_weight=mismatch_weight, tolerance_mm=tolerance_mm),
        dimension=2,
    )
    started = time.perf_counter()
    warp = tw.solve(scene)
    seconds = time.perf_counter() - started
    x = circles.points_between(np.random.default_rng(0), 1_000_000, CENTRE, INNER, OUTER)
    screening = scene.objective.screening
    truth = circles.displacement(x, CENTRE, INNER, OUTER, MOVED, screening)
    error = 1e3 * float(np.linalg.norm(warp.displacement(x) - truth, axis=1).max())
    what = f"circles, λ = {screening:g} m⁻², tolerance {tolerance_mm:g} mm"
    return [
        Figure(f"{what}: greatest error", error, "mm", at_most=tolerance_mm),
        Figure(f"{what}: solve, {warp.solution.nodes:,} nodes", seconds, "s"),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    figures = [f for w in (0.0, 1.0, 100.0) for t in (0.5, 0.1, 0.02) for f in measure(w, t)]
    print_figures("plane scenes", figures)
    if options.json:
        save_json(options.json, figures)


if __name__ == "__main__":
    main()
