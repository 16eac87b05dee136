"""Instant goals: a new transform gives a warp in under 5 ms, a combined table in under 100 ms.

    python benchmarks/instant.py [--json FILE]

The demo's mug on its table, its affine goals from basis fields solved once. Within the stated range
a combination equals a solve on the same grid to 1 µm, and a fresh solve within both tolerances in
Ω, farther than the edge radius from sharp edges.
"""

from __future__ import annotations

import argparse
import dataclasses
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from figures import Figure, print_figures, save_json
from scipy.spatial import cKDTree

import touchwarp as tw
from touchwarp.cli.demo_files import write_input
from touchwarp.goals.surface_samples import find_sharp_edges, sample_surface
from touchwarp.warp.rounds import fit_round
from touchwarp.warp.solve_bases import basis_rounds
from touchwarp.warp.solver import COMPONENTS, IN_METRES

GOALS = {
    "cup": tw.TransformGoal(scale=[1.2, 1.2, 0.6], translation=[0.015, 0, 0]),
    "moved and turned": tw.TransformGoal(rotation_deg=[0, 0, 45], translation=[0.06, -0.05, 0]),
}


def best(
    combine: Callable[[dict[str, np.ndarray]], object],
    goals: dict[str, np.ndarray],
    repeats: int = 7,
) -> float:
    """The shortest time of one combination after a first, ms."""
    times = []
    for _ in range(repeats + 1):
        started = time.perf_counter()
        combine(goals)
        times.append(time.perf_counter() - started)
    return 1e3 * min(times[1:])


def points_in_reach(goal: tw.Goal, radius: float) -> np.ndarray:
    """(n, 3) m: outside the mug, within 0.1 m of it, above the table, away from sharp edges."""
    random = np.random.default_rng(0)
    low, high = goal.prop_points.min(axis=0) - 0.1, goal.prop_points.max(axis=0) + 0.1
    low[2] = 0.0
    x = random.uniform(low, high, (400_000, 3))
    on = sample_surface(goal, 200_000, random)
    # beyond the mug's own outline seen from its axis, or above it: in Ω for certain
    top = goal.prop_points[:, 2].max()
    across = np.linalg.norm(x[:, :2], axis=1)
    widest = np.linalg.norm(goal.prop_points[:, :2], axis=1).max()
    x = x[(across > widest) | (x[:, 2] > top)]
    skin = on.points + 0.5e-3 * on.normals
    x = np.concatenate([x, skin[skin[:, 2] > 0.0]])
    sharp = find_sharp_edges(goal.prop_points, goal.faces)
    edges, _ = sharp.sample(goal, 100_000, random)
    gap, _ = cKDTree(edges).query(x, distance_upper_bound=radius)
    return np.asarray(x[~np.isfinite(gap)])


def measure(scene: tw.Scene) -> list[Figure]:
    """Times, and differences from solves."""
    tolerance, radius = scene.objective.tolerance_mm, 1e-3 * scene.objective.edge_radius_mm
    tw.solve_bases(scene, tolerance_mm=1.0)  # compiles
    started = time.perf_counter()
    bases = tw.solve_bases(scene)
    solved = time.perf_counter() - started
    size = bases.bricks.values.nbytes / 1e6
    figures = [Figure(f"bases of {len(bases.bricks.slot):,} bricks, {size:.1f} MB", solved, "s")]
    x = points_in_reach(tw.goals(scene)["mug"], radius)
    figures.append(same_grid(scene, bases, GOALS["cup"]))
    for name, spec in GOALS.items():
        other = scene.with_goals({"mug": spec})
        matrix = tw.goals(other)["mug"].matrix
        assert matrix is not None
        given = {"mug": matrix}
        lazy, table = bases.warp(given), bases.table(given)
        # bases keep their ∂Ω1, while `box_scale` follows the virtual object
        fresh = tw.solve(dataclasses.replace(other, outer=tw.Outer(box=bases.meta.outer_box)))
        own = 1e3 * float(np.linalg.norm(lazy(x) - table(x), axis=1).max())
        gap = 1e3 * float(np.linalg.norm(table(x) - fresh(x), axis=1).max())
        stated = bases.error_bound_mm(given) or 0.0
        figures += [
            Figure(f"{name}: stated bound of its error", stated, "mm"),
            Figure(f"{name}: bases.warp", best(bases.warp, given), "ms", 5.0),
            Figure(f"{name}: bases.table", best(bases.table, given), "ms", 100.0),
            Figure(f"{name}: lazy and combined differ by", own, "mm", 1e-3),
            Figure(f"{name}: differs from a fresh solve in Ω by", gap, "mm", 2 * tolerance),
        ]
    return figures


def same_grid(scene: tw.Scene, bases: tw.AffineBases, spec: tw.TransformGoal) -> Figure:
    """How far a combination is from a solve of the goal itself on the very grid of the bases."""
    whole = tw.WarpSolver(scene.with_goals({"mug": spec}))
    solver, rounds = basis_rounds(whole, lambda text, share: None)
    data, lanes = whole.problem.goal_data(whole.goals), whole.problem.normal_lanes
    # it takes the data, in metres, for basis fields, which weigh a fiftieth
    solver.settled /= 100.0
    solver.solve(data, lanes)
    own = fit_round(solver, rounds[-1].maker, data, lanes, IN_METRES)
    assert own is not None
    bricks = own.maker.bricks([own.fitted.values], COMPONENTS)
    matrix = whole.goals["mug"].matrix
    assert matrix is not None
    combined = bases.table({"mug": matrix}).bricks
    assert combined.values.shape == bricks.values.shape, "the grids differ"
    gap = 1e3 * float(np.abs(combined.values - bricks.values).max())
    return Figure("differs from a solve on the same grid by", gap, "mm", at_most=1e-3)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        write_input(Path(folder))
        figures = measure(tw.load_scene(Path(folder) / "mug.toml"))
    print_figures("instant goals", figures)
    if options.json:
        save_json(options.json, figures)


if __name__ == "__main__":
    main()
