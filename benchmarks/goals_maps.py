"""`match` and `area_preserving` between shapes and scans: flips, coverage, areas, time.

    python benchmarks/goals_maps.py --data DIR [--only NAME ...] [--area-weight W] [--json FILE]

The virtual object is aligned first, as `touchwarp align` does; dirty scans are repaired first, as
`touchwarp repair` does. Times are this process's, with layouts computed anew and compiled code warm
(run twice); what is claimed of time is measured by `goals_time.py`. Nothing is dropped: a pair that
fails counts as missed.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from pathlib import Path

import fast_simplification
import numpy as np
from figures import Figure, print_figures, print_table, save_json

from touchwarp.errors import TouchwarpError
from touchwarp.goals.goal import Goal
from touchwarp.goals.maps.make import area_preserving_goal, match_goal
from touchwarp.scan.preparation import place
from touchwarp.scan.repair import repair
from touchwarp.scene import AreaPreservingGoal, MatchGoal, Prop, Surface, read_mesh
from touchwarp.scene.shapes import box, sphere
from touchwarp.scene.vessels import mug, tea_cup

RAW_SCANS = ("raw pitcher → pitcher",)
TO_DOMAINS = ("banana → sphere", "mustard → sphere", "cup → torus", "pitcher → torus")
"""Pairs that only areas are kept on."""
AS_THEY_STAND = ("cube → sphere", "mug → tea cup")
"""Pairs that need no alignment."""


def torus(radius: float, tube: float, around: int = 96, across: int = 48) -> Surface:
    """A torus about z, m."""
    i, j = (k.ravel() for k in np.indices((around, across)))
    u, v = 2 * np.pi * i / around, 2 * np.pi * j / across
    reach = radius + tube * np.cos(v)
    points = np.stack([reach * np.cos(u), reach * np.sin(u), tube * np.sin(v)], axis=1)
    k, m = (i + 1) % around, (j + 1) % across
    a, b, c, d = i * across + j, k * across + j, k * across + m, i * across + m
    return Surface(points, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def pairs(folder: Path) -> dict[str, Callable[[], tuple[Surface, Surface]]]:
    """Prop and virtual object of each pair, before alignment."""

    def scan(name: str) -> Surface:
        return read_mesh(folder / name, "m")

    def few(surface: Surface) -> Surface:
        points, faces = fast_simplification.simplify(
            surface.vertices.astype(np.float32), surface.faces.astype(np.int32), 0.7
        )
        return Surface(points.astype(np.float64), faces.astype(np.int64))

    return {
        "cube → sphere": lambda: (box([0.1, 0.1, 0.1]), sphere(0.06)),
        "mug → tea cup": lambda: (mug(), tea_cup()),
        "mustard → banana": lambda: (scan("mustard_ycb.obj"), scan("banana_ycb.obj")),
        "few-faced bottle → bottle": lambda: (
            few(scan("fuze_bottle.ply")),
            scan("fuze_bottle.ply"),
        ),
        "cup → pitcher": lambda: (scan("cup_blue.obj"), scan("pitcher_ycb.obj")),
        "dirty mug → cup": lambda: (
            repair(scan("mug_ycb_scan_dirty.obj"), genus=1).surface,
            scan("cup_blue.obj"),
        ),
        "raw pitcher → pitcher": lambda: (
            repair(scan("pitcher_rawscan_dirty.stl"), genus=1).surface,
            scan("pitcher_ycb.obj"),
        ),
        "banana → sphere": lambda: (scan("banana_ycb.obj"), sphere(0.05)),
        "mustard → sphere": lambda: (scan("mustard_ycb.obj"), sphere(0.05)),
        "cup → torus": lambda: (scan("cup_blue.obj"), torus(0.04, 0.018)),
        "pitcher → torus": lambda: (scan("pitcher_ycb.obj"), torus(0.04, 0.018)),
    }


def aligned(name: str, prop: Surface, virtual: Surface) -> Surface:
    """The virtual object of a pair where `touchwarp align` puts it, if it is to be moved."""
    if name in AS_THEY_STAND:
        return virtual
    return virtual.transformed(place(prop, virtual).T_prop_virtual)


def goal_of(kind: str, prop: Surface, virtual: Surface, **weights: float) -> Goal:
    """The map of one kind between two surfaces, by `match` with weights other than its own."""
    if kind == "match":
        return match_goal(Prop("prop", prop), MatchGoal(virtual, **weights))
    return area_preserving_goal(Prop("prop", prop), AreaPreservingGoal(virtual))


def judged(name: str, kind: str, goal: Goal) -> list[Figure]:
    """The figures of one map beside what is claimed of it."""
    told = goal.report
    covered = 0.99 if name in RAW_SCANS else 0.999
    area = ("area_std", 0.15) if kind == "match" else ("domain_area_std", 0.01)
    return [
        Figure(f"{name}, {kind}: flips on the domain", told["domain_flips"], "", at_most=0),
        Figure(f"{name}, {kind}: folded triangles", told["flips"], "", at_most=0),
        Figure(f"{name}, {kind}: opposing normals", told["opposing"], "of area", at_most=5e-4),
        Figure(f"{name}, {kind}: coverage", told["coverage"], "of area", at_least=covered),
        Figure(f"{name}, {kind}: {area[0]}", told[area[0]], "", at_most=area[1]),
        Figure(f"{name}, {kind}: vertices off the surface", told["distance_vertices"], "m", 1e-9),
        Figure(f"{name}, {kind}: displacement", told["displacement_mean"] * 1e3, "mm"),
        Figure(f"{name}, {kind}: normals turned", np.degrees(told["normal_mean"]), "°"),
        Figure(f"{name}, {kind}: curvature mismatch", told["curvature_mean"], "1/m"),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--area-weight", type=float)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    weights = {} if options.area_weight is None else {"area_weight": options.area_weight}
    os.environ["TOUCHWARP_CACHE"] = ""
    figures: list[Figure] = []
    failed: list[tuple[str, str]] = []
    for name, make in pairs(options.data).items():
        if options.only and name not in options.only:
            continue
        try:
            prop, virtual = make()
            virtual = aligned(name, prop, virtual)
            moved = {}
            for kind in ("area_preserving", "match")[: 1 if name in TO_DOMAINS else 2]:
                start = time.process_time()
                goal = goal_of(kind, prop, virtual, **weights)
                seconds = time.process_time() - start
                rows = judged(name, kind, goal)
                rows.append(Figure(f"{name}, {kind}: processor time", seconds, "s"))
                moved[kind] = goal.report["displacement_mean"]
                print_figures(f"{name}: {len(goal.faces)} faces", rows)
                figures += rows
            if name in TO_DOMAINS:
                continue
            ratio = moved["match"] / moved["area_preserving"]
            figures.append(Figure(f"{name}: displacement, match over area", ratio, "", at_most=1))
            print_figures(name, figures[-1:])
        except TouchwarpError as error:
            failed.append((name, str(error)))
            figures.append(Figure(f"{name}: made", 0, "", at_least=1))
            print(f"\n{name} FAILED: {error}")
    if failed:
        print_table("failed", ["pair", "why"], failed)
    if options.json:
        save_json(options.json, figures)


if __name__ == "__main__":
    main()
