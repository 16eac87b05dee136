"""The weight of curvature in `match`, swept: mismatch of curvature against displacement.

    python benchmarks/goals_curvature.py --data DIR [--only NAME ...] [--weights W ...]
        [--picture FILE.png]

A box whose edge is rounded by 10 mm shown with 30 mm, the mug as the tea cup, and a bottle as a
banana. Claimed: the mismatch falls with every step of the weight, by 30 % at the far end. The
picture of `docs/limits.md` is drawn by `--picture docs/images/curvature_weight.png`.
"""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Sequence
from pathlib import Path

from figures import Figure, print_figures, print_table

from touchwarp.goals.maps.make import match_goal
from touchwarp.scan.align import align
from touchwarp.scene import MatchGoal, Prop, Surface, read_mesh
from touchwarp.scene.shapes import fillet_box
from touchwarp.scene.vessels import mug, tea_cup

WEIGHTS = (0.0, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0)
SIZE = [0.1, 0.1, 0.1]


def shapes(name: str, folder: Path) -> tuple[Surface, Surface]:
    """Prop and virtual object."""
    if name == "fillet":
        return fillet_box(SIZE, 0.01), fillet_box(SIZE, 0.03)
    if name == "mug":
        return mug(), tea_cup()
    bottle = read_mesh(folder / "mustard_ycb.obj", "m")
    banana = read_mesh(folder / "banana_ycb.obj", "m")
    return bottle, banana.transformed(align(bottle, banana).T_prop_virtual)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--only", nargs="*", default=["fillet", "mug", "bottle"])
    parser.add_argument("--weights", type=float, nargs="*", default=WEIGHTS)
    parser.add_argument("--picture", type=Path)
    options = parser.parse_args()
    curves = {}
    for name in options.only:
        prop, virtual = shapes(name, options.data)
        rows, curve = [], []
        for weight in options.weights:
            spec = MatchGoal(virtual, area_weight=0.5, curvature_weight=weight, tolerance_mm=0.1)
            told = match_goal(Prop("prop", prop), spec).report
            curve.append((told["displacement_mean"] * 1e3, told["curvature_mean"]))
            rows.append(
                [
                    f"{weight:g}",
                    f"{told['curvature_mean']:.3f}",
                    f"{told['displacement_mean'] * 1e3:.3f}",
                    f"{told['area_std']:.3f}",
                    f"{told['flips']:.0f}",
                    f"{told['coverage']:.5f}",
                ]
            )
        head = ["weight", "mismatch 1/m", "displacement mm", "area std", "folds", "coverage"]
        print_table(name, head, rows)
        mismatch = [m for _, m in curve]
        rises = max(b / a - 1 for a, b in itertools.pairwise(mismatch))
        print_figures(
            name,
            [
                Figure("greatest rise between steps", rises, "", at_most=0),
                Figure("fall at the far end", 1 - mismatch[-1] / mismatch[0], "", at_least=0.3),
            ],
        )
        curves[name] = curve
    if options.picture:
        draw(options.picture, options.weights, curves)


def draw(
    path: Path, weights: Sequence[float], curves: dict[str, list[tuple[float, float]]]
) -> None:
    """Mismatch against displacement, one curve a pair, weights beside the points."""
    from matplotlib.figure import Figure as Canvas

    canvas = Canvas(figsize=(4 * len(curves), 3.4), layout="constrained")
    for k, (name, curve) in enumerate(curves.items()):
        axes = canvas.add_subplot(1, len(curves), k + 1)
        axes.plot(*zip(*curve, strict=True), "o-")
        for weight, point in zip(weights, curve, strict=True):
            axes.annotate(f"{weight:g}", point, textcoords="offset points", xytext=(4, 4))
        axes.set(title=name, xlabel="displacement, mm", ylabel="curvature mismatch, 1/m")
    canvas.savefig(path, dpi=120)


if __name__ == "__main__":
    main()
