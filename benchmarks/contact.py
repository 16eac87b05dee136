"""Contact error at the default tolerance, on shapes and on scanned meshes.

    python benchmarks/contact.py --data DIR [--only mug box] [--json FILE]

Goal: scale [1.15, 0.9, 1.1], 8° about z, 14 mm in x, about the base. The error |f − g| is taken at
10⁶ points of each surface uniform in area (within 1 mm of corners told apart), and at 10⁵ on its
sharp edges. Nothing is dropped. DIR holds the meshes of `MESHES` and `DIRTY`; missing ones count as
missed.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
from figures import Figure, print_figures, save_json
from scipy.spatial import cKDTree

import touchwarp as tw
from touchwarp.goals.surface_samples import find_sharp_edges, sample_surface
from touchwarp.scene import parse_scene

GOAL = (
    '{ kind = "transform", scale = [1.15, 0.9, 1.1], '
    "rotation_deg = [0, 0, 8], translation = [0.014, 0, 0] }"
)
SHAPES = {
    "mug": '{ kind = "mug" }',
    "box": '{ kind = "box", size = [0.1, 0.1, 0.1] }',
}
MESHES = {
    "cup": ("cup_blue.obj", '"m"'),
    "pitcher": ("pitcher_ycb.obj", '"m"'),
    "banana": ("banana_ycb.obj", '"m"'),
    "mustard": ("mustard_ycb.obj", '"m"'),
    "hammer": ("hammer.obj", "0.04"),
    "bottle": ("fuze_bottle.ply", '"m"'),
    "duck": ("duck.glb", "0.06"),
}
DIRTY = {
    "mug scan": ("mug_ycb_scan_dirty.obj", '"m"'),
    "pitcher scan": ("pitcher_rawscan_dirty.stl", '"m"'),
}
CORNER = 1e-3
"""m: samples closer than this to a corner, where sharp edges meet or end, are told apart."""


def scene_of(name: str, folder: Path) -> tw.Scene:
    """The scene of one mesh, in the middle of a box four times its size."""
    if name in SHAPES:
        source = f"shape = {SHAPES[name]}"
    else:
        file, unit = (MESHES | DIRTY)[name]
        source = f"mesh = {str(file)!r}\nunit = {unit}"
    return parse_scene(f"[[prop]]\nname = {name!r}\n{source}\ngoal = {GOAL}\n", folder)


def corners_of(vertices: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """(k, 3) where sharp edges (e, 2) meet, end, or turn by more than 30°."""
    if len(ends) == 0:
        return np.empty((0, 3))
    _, index = np.unique(np.round(vertices, 9), axis=0, return_inverse=True)
    start, stop = ends.ravel(), ends[:, ::-1].ravel()
    along = vertices[stop] - vertices[start]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    vertex = index.reshape(-1)[start]
    count = np.bincount(vertex)
    both = np.zeros((len(count), 3))
    np.add.at(both, vertex, along)
    straight = (count == 2) & (np.linalg.norm(both, axis=1) < 2 * np.sin(np.radians(15)))
    return np.asarray(vertices[start[(~straight)[vertex]]])


def measure(name: str, folder: Path) -> list[Figure]:
    """Contact errors of one mesh."""
    scene = scene_of(name, folder)
    started = time.perf_counter()
    warp = tw.solve(scene, tolerance_mm=0.1, memory_limit_gb=8.0)
    seconds = time.perf_counter() - started
    goal = tw.goals(scene)[name]
    random = np.random.default_rng(0)
    samples = sample_surface(goal, 1_000_000, random)
    error = 1e3 * np.linalg.norm(warp(samples.points) - samples.targets, axis=1)
    sharp = find_sharp_edges(goal.prop_points, goal.faces)
    corners = corners_of(goal.prop_points, sharp.ends)
    near = np.zeros(len(error), bool)
    if len(corners):
        gap, _ = cKDTree(corners).query(samples.points, distance_upper_bound=CORNER)
        near = np.isfinite(gap)
    on_edges, targets = sharp.sample(goal, 100_000, random)
    at_edges = 1e3 * np.linalg.norm(warp(on_edges) - targets, axis=1)
    clean = name not in DIRTY
    worst = int(np.where(near, -1.0, error).argmax())
    where = ", ".join(f"{1e3 * x:.1f}" for x in samples.points[worst])
    record = warp.solution
    assert record is not None
    found = [
        Figure("mean", float(error.mean()), "mm", 0.02 if clean else 0.05),
        Figure("99th percentile", float(np.quantile(error, 0.99)), "mm", 0.1 if clean else 0.3),
        Figure(f"greatest, at ({where}) mm", float(error[worst]), "mm", 0.5 if clean else None),
    ]
    if near.any():
        what = f"greatest within 1 mm of corners, {near.mean():.2%} of the area"
        found.append(Figure(what, float(error[near].max()), "mm"))
    if len(at_edges):
        rims = f"{sharp.rim.sum():,} of {len(sharp.rim):,} are rims"
        for what, value in [
            (f"sharp edges ({rims}), mean", at_edges.mean()),
            ("sharp edges, 99th percentile", np.quantile(at_edges, 0.99)),
            ("sharp edges, greatest", at_edges.max()),
        ]:
            found.append(Figure(what, float(value), "mm"))
    found.append(Figure("estimated greatest error in Ω", record.estimated_error_max_mm, "mm"))
    found.append(Figure(f"solve, {record.nodes:,} nodes", seconds, "s"))
    return [Figure(f"{name}: {f.claim}", f.value, f.unit, f.at_most) for f in found]


def main() -> None:
    every = [*SHAPES, *MESHES, *DIRTY]
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--data", type=Path, default=Path())
    parser.add_argument("--only", nargs="*", default=every, choices=every)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    figures = []
    for name in options.only:
        try:
            some = measure(name, options.data)
        except tw.TouchwarpError as error:
            print(f"\n{name}: {type(error).__name__}: {error}")
            some = [Figure(f"{name}: failed", float("nan"), "mm", at_most=0.0)]
        print_figures(f"contact, {name}", some)
        figures += some
    if options.json:
        save_json(options.json, figures)


if __name__ == "__main__":
    main()
