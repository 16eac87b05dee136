"""Concentric spheres: the greatest error at any point of Ω is at most the tolerance.

    python benchmarks/spheres.py [--only 0.1] [--json FILE]

A sphere of radius 5 cm, stretched, turned and moved, in a sphere of radius 30 cm, both as meshes;
λ = 0 and 100 m⁻²; tolerances 0.5, 0.1 and 0.02 mm; against the closed form.
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
from tests.exact.spheres import SphereWarp
from touchwarp.scene.shapes import sphere

CENTRE = np.array([0.0012, 0.0023, -0.0017])
INNER, OUTER = 0.05, 0.3
GOAL = tw.TransformGoal(
    pivot=CENTRE.tolist(), scale=[1.15, 0.9, 1.1], rotation_deg=[0, 0, 8], translation=[0.014, 0, 0]
)
LENGTH_SCALE = 0.1
FACET_SHARE = 0.05
"""Facets stand off the inner sphere by this share of the tolerance."""

OUTER_FACET_SHARE = 0.5
"""The same of the outer sphere, where |∇u| is about 0.01."""


def points_between(count: int) -> np.ndarray:
    """(n, 3) m, half of them evenly in volume, half within 1 cm of the inner sphere."""
    random = np.random.default_rng(0)
    direction = random.normal(size=(count, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    far = np.cbrt(random.uniform(INNER**3, OUTER**3, count - count // 2))
    near = random.uniform(INNER, INNER + 0.01, count // 2)
    return CENTRE + np.concatenate([far, near])[:, None] * direction


def measure(screening: float, tolerance_mm: float) -> list[Figure]:
    """Error and time of one solve; λ = `screening` in m⁻²."""
    ball = sphere(INNER, FACET_SHARE * tolerance_mm)
    around = sphere(OUTER, OUTER_FACET_SHARE * tolerance_mm)
    scene = tw.Scene(
        [tw.Prop("ball", tw.Surface(ball.vertices + CENTRE, ball.faces), GOAL)],
        tw.Outer(surface=tw.Surface(around.vertices + CENTRE, around.faces)),
        tw.Objective(screening * LENGTH_SCALE**2, LENGTH_SCALE, tolerance_mm),
    )
    matrix = tw.goals(scene)["ball"].matrix
    assert matrix is not None
    shift = matrix[:3, :3] @ CENTRE + matrix[:3, 3] - CENTRE
    stretch = matrix[:3, :3] - np.eye(3)
    exact = SphereWarp(INNER, OUTER, CENTRE, shift, stretch, screening)
    started = time.perf_counter()
    warp = tw.solve(scene)
    seconds = time.perf_counter() - started
    x = points_between(2_000_000)
    error = 1e3 * np.linalg.norm(warp.displacement(x) - exact.displacement(x), axis=1)
    worst = int(error.argmax())
    away = 1e3 * (float(np.linalg.norm(x[worst] - CENTRE)) - INNER)
    what = f"λ = {screening:g} m⁻², tolerance {tolerance_mm:g} mm"
    record = warp.solution
    assert record is not None
    return [
        Figure(f"{what}: greatest error", float(error.max()), "mm", at_most=tolerance_mm),
        Figure(f"{what}: its distance from the ball", away, "mm"),
        Figure(f"{what}: root mean square error", float(np.sqrt((error**2).mean())), "mm"),
        Figure(f"{what}: estimated greatest error", record.estimated_error_max_mm, "mm"),
        Figure(f"{what}: solve, {record.nodes:,} nodes", seconds, "s"),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--only", type=float, nargs="*", default=[0.5, 0.1, 0.02], help="mm")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    figures = []
    for screening in (0.0, 100.0):
        for tolerance in options.only:
            some = measure(screening, tolerance)
            print_figures("concentric spheres", some)
            figures += some
    if options.json:
        save_json(options.json, figures)


if __name__ == "__main__":
    main()
