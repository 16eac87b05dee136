"""Maps of the mug to the tea cup by other methods, beside `match`, all measured alike.

    benchmarks/rivals/setup.sh                                           # once
    benchmarks/rivals/.venv/bin/python benchmarks/goals_rivals.py

Closest point: each vertex goes to the nearest point of the virtual surface. nricp: trimesh's
non-rigid registration (Amberg 2007), with its own settings. Functional map: pyFM with wave kernel
descriptors, fifteen landmarks and ZoomOut; vertices go to places in faces. Landmarks are given to
it alone. All get the same even meshes. Claimed: `match` is no worse than any on folds, coverage,
opposing normals and spread of areas.
"""

from __future__ import annotations

import importlib.util
import os
import time
from collections.abc import Callable

import numpy as np
import trimesh
from figures import Figure, print_figures, print_table
from numpy.typing import NDArray

from touchwarp.goals.goal import Goal
from touchwarp.goals.maps.make import match_goal
from touchwarp.goals.measure import measure_map
from touchwarp.goals.surface_tree import SurfaceTree
from touchwarp.scan.remesh import edge_length_for, remesh
from touchwarp.scene import MatchGoal, Prop, Surface
from touchwarp.scene.vessels import mug, tea_cup

Float = NDArray[np.float64]

AROUND = ((-1, 0), (0, 1), (0, -1), (-1, 1), (-1, -1), (1, 1), (1, -1))
LANDMARKS = [(1, 0, 0), *((x, y, z) for x, y in AROUND for z in (1, -1))]
"""Directions in which both vessels' furthest vertices are landmarks: handle, rim and foot."""

FACES = 12_000
"""Even triangles on either vessel, for all alike: the rivals want them, `match` does not."""
ZOOM_STEPS = 18
"""From 35 to 125 eigenfunctions, of the 128 that there are."""


def closest_point(prop: Surface, virtual: Surface) -> Float:
    """Images of the prop's vertices."""
    return SurfaceTree(virtual.vertices, virtual.faces).nearest(prop.vertices).points


def nricp(prop: Surface, virtual: Surface) -> Float:
    """The same, by trimesh."""
    source, target = (trimesh.Trimesh(s.vertices, s.faces, process=False) for s in (prop, virtual))
    return np.asarray(trimesh.registration.nricp_amberg(source, target))


def functional_map(prop: Surface, virtual: Surface) -> Float:
    """The same, by pyFM."""
    from pyFM.functional import FunctionalMapping
    from pyFM.mesh import TriMesh

    landmarks = np.array(
        [[int((s.vertices @ d).argmax()) for s in (virtual, prop)] for d in LANDMARKS]
    )
    model = FunctionalMapping(*(TriMesh(s.vertices, s.faces) for s in (virtual, prop)))
    model.preprocess(n_descr=100, descr_type="WKS", landmarks=landmarks, subsample_step=5)
    model.fit(K=(35, 35), w_descr=1, w_lap=1e-2, w_dcomm=1e-1)
    finer = model.zoomout_refine(nit=ZOOM_STEPS, step=5)
    face, weights = model.get_precise_map(FM=finer, precompute_dmin=True)
    return np.einsum("nk,nkd->nd", weights, virtual.vertices[virtual.faces[face]])


def main() -> None:
    os.environ["TOUCHWARP_CACHE"] = ""
    prop, virtual = (remesh(s, edge_length_for(s, FACES)) for s in (mug(), tea_cup()))
    rivals: dict[str, Callable[[Surface, Surface], Float]] = {
        "closest point": closest_point,
        "nricp": nricp,
    }
    if importlib.util.find_spec("pyFM"):
        rivals["functional map"] = functional_map
    else:
        print("pyFM is not installed: no functional map.")
    told, rows = {}, []
    for name in ("match", *rivals):
        start = time.perf_counter()
        if name == "match":
            goal = match_goal(Prop("mug", prop), MatchGoal(virtual, tolerance_mm=0.1))
        else:
            images = rivals[name](prop, virtual)
            goal = Goal(prop.vertices, images, prop.faces, virtual_surface=virtual)
        seconds = time.perf_counter() - start
        told[name] = measure_map(goal).summary()
        rows.append(
            [
                name,
                f"{told[name]['flips']:.0f}",
                f"{told[name]['coverage']:.4f}",
                f"{told[name]['opposing']:.4f}",
                f"{told[name]['area_std']:.3f}",
                f"{told[name]['displacement_mean'] * 1e3:.1f}",
                f"{seconds:.0f}",
            ]
        )
    head = ["map", "folds", "coverage", "opposing", "area std", "displacement mm", "s"]
    print_table("mug to tea cup", head, rows)
    best = {
        key: min(sign * told[name][key] for name in rivals) * sign
        for key, sign in (("flips", 1), ("coverage", -1), ("opposing", 1), ("area_std", 1))
    }
    ours = told["match"]
    print_figures(
        "match against the best of the others",
        [
            Figure("folds", ours["flips"], "", at_most=best["flips"]),
            Figure("coverage", ours["coverage"], "", at_least=best["coverage"]),
            Figure("opposing normals", ours["opposing"], "of area", at_most=best["opposing"]),
            Figure("spread of areas", ours["area_std"], "", at_most=best["area_std"]),
        ],
    )


if __name__ == "__main__":
    main()
