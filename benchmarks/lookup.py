"""How long a table takes to be looked up, inverted, resampled and combined.

python benchmarks/lookup.py            # a table in closed form, 17.6 MB, on five levels
python benchmarks/lookup.py mug.warp   # any warp file
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tests.exact.sample_bricks import near_sphere, sample_bricks
from tests.exact.spheres import SphereWarp
from touchwarp.warp.bases import AffineBases
from touchwarp.warp.file import load_table
from touchwarp.warp.meta import BasisProp, WarpMeta
from touchwarp.warp.table import TableWarp

BOX = np.array([[-0.2] * 3, [0.2] * 3])
GRID = {"root_shape": (3, 3, 3), "depth": 4, "refine": near_sphere(0.0, 0.05, reach=0.9)}


def best(run: Callable[[], object], repeats: int) -> float:
    """The shortest time of one run, in s; the first run, which may compile, is not counted."""
    run()
    times = []
    for _ in range(repeats):
        start = perf_counter()
        run()
        times.append(perf_counter() - start)
    return min(times)


def closed_form_table() -> TableWarp:
    exact = SphereWarp(shift=np.array([0.01, 0.0, 0.02]), stretch=0.2 * np.eye(3))
    return TableWarp(sample_bricks(exact.displacement, *BOX, **GRID), WarpMeta(outer_box=BOX))


def closed_form_bases() -> AffineBases:
    """Four lanes of one prop; their values do not matter for the time."""
    exact = SphereWarp(shift=np.array([1.0, 0.0, 0.0]), stretch=np.eye(3))
    lanes = sample_bricks(lambda x: exact.displacement(x) @ np.eye(3, 4), *BOX, **GRID)
    basis = {"ball": BasisProp((0.2, 0.2, 0.2), 0.087)}
    return AffineBases(lanes, WarpMeta(kind="bases", prop_names=("ball",), basis=basis))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("warp", nargs="?", type=Path)
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    warp = load_table(options.warp) if options.warp else closed_form_table()
    assert isinstance(warp, TableWarp), "a table in space is needed"
    low, high = warp.outer_box
    random = np.random.default_rng(0)
    points = random.uniform(low, high, (options.points, 3))
    joints, some = points[:26].copy(), points[: max(options.points // 100, 26)]
    side = 128 if options.points > 10_000 else 8

    def many(call: Callable[[np.ndarray], object], x: np.ndarray, times: int = 100) -> float:
        return best(lambda: [call(x) for _ in range(times)], options.repeats) / times

    bricks, size = len(warp.bricks.slot), warp.bricks.values.nbytes / 1e6
    print(f"table of {bricks} bricks, {size:.1f} MB; best of {options.repeats}")
    rows = [
        ("warp(x), random points", 1e9 / len(points), "ns a point", 150.0, warp, points),
        ("warp.jacobian(x)", 1e9 / len(points), "ns a point", None, warp.jacobian, points),
        ("warp.inverse(x)", 1e6 / len(some), "µs a point", None, warp.inverse, some),
    ]
    for name, scale, unit, limit, call, x in rows:
        show(name, scale * best(lambda call=call, x=x: call(x), options.repeats), unit, limit)
    show("warp(x), 26 joints in one call", 1e6 * many(warp, joints), "µs", 30.0)
    show("warp.jacobian(x), 26 joints", 1e6 * many(warp.jacobian, joints), "µs", None)
    show("warp.inverse(x), 26 joints", 1e6 * many(warp.inverse, joints), "µs", None)
    shape = (side, side, side)
    took = best(lambda: warp.resample(shape), options.repeats)
    show(f"warp.resample({shape})", 1e3 * took, "ms", 300.0)
    bases = closed_form_bases()
    goals = {"ball": np.diag([1.2, 1.0, 0.9, 1.0])}
    show("bases.warp(goals)", 1e3 * many(bases.warp, goals, 20), "ms", 5.0)
    took = best(lambda: bases.table(goals), options.repeats)
    show(f"bases.table(goals), {len(bases.bricks.slot)} bricks", 1e3 * took, "ms", 100.0)


def show(name: str, figure: float, unit: str, limit: float | None) -> None:
    told = "" if limit is None else f"  (at most {limit:g})"
    print(f"{name:44s} {figure:9.3g} {unit}{told}")


if __name__ == "__main__":
    main()
