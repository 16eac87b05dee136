"""The certificate of one warp: every family of checks, in reading order."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from touchwarp.check.belonging import require_belonging
from touchwarp.check.below import check_below
from touchwarp.check.bounds import check_bounds
from touchwarp.check.budget import check_budget
from touchwarp.check.case import Case, Finding, open_case
from touchwarp.check.contact import check_contact
from touchwarp.check.continuity import check_continuity
from touchwarp.check.energy import check_energy
from touchwarp.check.estimate import check_estimate
from touchwarp.check.field import check_field
from touchwarp.check.folds import check_folds
from touchwarp.check.gain import check_gain
from touchwarp.check.goal_map import check_map
from touchwarp.check.identity import check_identity
from touchwarp.check.openings import check_openings
from touchwarp.check.perception import check_perception
from touchwarp.check.reaches import check_reaches
from touchwarp.check.report import Check, Report
from touchwarp.check.virtual_contact import check_virtual_contact
from touchwarp.goals import goals as make_goals
from touchwarp.goals import outer_box
from touchwarp.scene.scene import Scene
from touchwarp.warp.bases import AffineWarp
from touchwarp.warp.meta import WarpMeta
from touchwarp.warp.protocol import Warp

SAMPLES = 1_000_000

FAMILIES: dict[str, Callable[[Case], Finding]] = {
    "contact": check_contact,
    "virtual": check_virtual_contact,
    "map": check_map,
    "bounds": check_bounds,
    "continuity": check_continuity,
    "identity": check_identity,
    "estimate": check_estimate,
    "field": check_field,
    "folds": check_folds,
    "gain": check_gain,
    "reaches": check_reaches,
    "perception": check_perception,
    "below": check_below,
    "budget": check_budget,
    "openings": check_openings,
    "energy": check_energy,
}
"""To add a family: a function from a Case to a Finding, in a file of its own, and a line here."""


def check(
    scene: Scene,
    warp: Warp,
    *,
    samples: int = SAMPLES,
    seed: int = 0,
    progress: Callable[[str, float], None] | None = None,
) -> Report:
    """The certificate of a warp: every promise of the scene, checked on it.

    Any warp can be checked; what only a table can show is "unknown" for others. Lazily combined
    bases are checked as the table that they stand for, a carried warp where its scene was solved.

    Args:
        scene: what the warp should do.
        warp: of the scene's dimension, in its frame.
        samples: of the prop surfaces, shared equally by the props.
        seed: of every random choice; the same seed gives the same report.
        progress: called with the family's name and the part that is done, 0 to 1.

    Raises:
        WarpFileError: scene and warp do not belong together.
        ValueError: fewer than 1000 samples.
    """
    if samples < 1000:
        raise ValueError(f"samples is {samples}; at least 1000 are needed for percentiles.")
    started = time.perf_counter()
    if isinstance(warp, AffineWarp):
        warp = warp.table()
    if warp.dimension != scene.dimension:
        from touchwarp.errors import WarpFileError

        raise WarpFileError(
            f"The warp is {warp.dimension}-D, but the scene {scene.dimension}-D; they do not "
            "belong together."
        )
    goals = make_goals(scene)
    meta = getattr(warp, "meta", None)
    meta = meta if isinstance(meta, WarpMeta) else None
    if meta is not None:
        require_belonging(scene, goals, meta)
        if not np.array_equal(meta.T_room_scene, np.eye(len(meta.T_room_scene))):
            warp = warp.at(np.linalg.inv(meta.T_room_scene))
    box = outer_box(scene, goals)
    if scene.outer.box_scale is not None and meta is not None and meta.outer_box is not None:
        # A solver used again, and bases, keep the ∂Ω1 of their first goal.
        box = meta.outer_box
    case = open_case(scene, warp, goals, box, meta, samples=samples, seed=seed)
    checks: list[Check] = []
    shown: dict[str, Any] = {}
    seconds: dict[str, float] = {}
    for done, (name, family) in enumerate(FAMILIES.items()):
        if progress is not None:
            progress(f"checking {name}", done / len(FAMILIES))
        since = time.perf_counter()
        found = family(case)
        seconds[name] = round(time.perf_counter() - since, 3)
        checks += found.checks
        shown[name] = found.shown
    return Report(tuple(checks), _facts(case, samples, started, seconds), shown, case)


def _facts(case: Case, samples: int, started: float, seconds: dict[str, float]) -> dict[str, Any]:
    return {
        "touchwarp_version": _version(),
        "warp": type(case.warp).__name__,
        "dimension": case.dimension,
        "props": [p.name for p in case.props],
        "mode": case.scene.interaction.mode,
        "tracking": getattr(case.scene.interaction.tracking, "name", ""),
        "lambda_per_m2": case.screening,
        "tolerance_mm": 1e3 * case.tolerance,
        "edge_radius_mm": 1e3 * case.edge_radius,
        "outer_box_m": case.region.box.tolist(),
        "surface_samples": samples,
        "touched_samples": sum(int((~standing).sum()) for standing in case.standing.values()),
        "domain_samples": len(case.probes.points),
        "seed": case.seed,
        "seconds": round(time.perf_counter() - started, 2),
        "seconds_by_family": seconds,
    }


def _version() -> str:
    # the package's face, which every room may be imported through, is loaded by now
    return str(getattr(sys.modules["touchwarp"], "__version__", ""))
