"""touchwarp on one case, compiled code warm.

.venv/bin/python ours.py CASE [--tolerance-mm 0.1] [--edge-radius-mm 2]
"""

from __future__ import annotations

import numpy as np
from case import TABLE_NODES, Case, Stopwatch, run_package

import touchwarp as tw


def run(
    case: Case, watch: Stopwatch, tolerance_mm: float, edge_radius_mm: float
) -> tuple[np.ndarray, int]:
    shape = (TABLE_NODES,) * 3
    file = case.mesh.with_suffix(".toml")
    tw.solve(tw.load_scene(file), tolerance_mm=1.0).resample(shape)
    watch.restart()
    scene = tw.load_scene(file)
    watch.lap("mesh")
    wanted = scene.with_objective(tolerance_mm=tolerance_mm, edge_radius_mm=edge_radius_mm)
    warp = tw.solve(wanted)
    watch.lap("solve")
    warp.resample(shape)
    watch.lap("table")
    return warp.displacement(case.points), int(warp.solution.nodes)


if __name__ == "__main__":
    run_package("touchwarp", run, tolerance_mm=0.1, edge_radius_mm=2.0)
