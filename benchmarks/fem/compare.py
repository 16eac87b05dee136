"""touchwarp against finite-element packages: mesh file → field → 128³ table, all in one run.

    benchmarks/fem/setup.sh
    benchmarks/fem/.venv/bin/python benchmarks/fem/compare.py \\
        [--cube CUBE.npz] [--mug ../results/mug_reference.npz] [--quick] [--json FILE]

Each package runs in a process of its own, one after the other, with two threads, at a row of
settings. A package's time at another's error is interpolated between its settings, logarithm
against logarithm. Evaluation at the reference's points is not timed.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from case import Case

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from figures import Figure, print_figures, print_table, save_json  # noqa: E402

SCRIPTS = {"touchwarp": "ours.py", "NGSolve": "ngsolve_peer.py", "scikit-fem": "skfem_peer.py"}

SETTINGS: dict[str, dict[str, list[dict[str, float]]]] = {
    "cube": {
        "touchwarp": [
            {"tolerance-mm": t, "edge-radius-mm": r}
            for t, r in ((2, 2), (1, 4), (1, 2), (0.5, 2), (0.1, 2))
        ],
        "NGSolve": [
            {"edge-mm": 8, "grading": 0.5},
            {"edge-mm": 5, "grading": 0.4},
            {"edge-mm": 3, "grading": 0.35},
            {"edge-mm": 2, "grading": 0.3},
        ],
        "scikit-fem": [
            {"edge-mm": 5, "face-mm": 15},
            {"edge-mm": 3.5, "face-mm": 11, "grading": 0.35},
            {"edge-mm": 2.5, "face-mm": 8, "grading": 0.3},
        ],
    },
    "mug": {
        "touchwarp": [{"tolerance-mm": t} for t in (1, 0.5, 0.2, 0.1)],
        "NGSolve": [
            *({"edge-mm": 2, "far-mm": 80, "grading": g} for g in (0.4, 0.3, 0.22)),
            {"edge-mm": 1.5, "far-mm": 60, "grading": 0.15},
            {"face-mm": 8},
        ],
        "scikit-fem": [{"edge-mm": 2, "far-mm": 80, "grading": g} for g in (0.4, 0.3, 0.22)],
    },
}

HEAD = ["package", "settings", "unknowns", "s", "CPU s", "mesh, solve, table"]
HEAD += ["rms", "p99", "max mm"]

SCENE = """[objective]
mismatch_weight = 0.0

[outer]
box = {{ min = {low}, max = {high} }}

[[prop]]
name = "{name}"
mesh = "{name}.stl"
unit = "mm"

[prop.goal]
kind = "transform"
matrix = {matrix}
"""


def write_case(name: str, reference: Path, folder: Path) -> Case:
    """The case's mesh, scene and true values, in a folder."""
    with np.load(reference) as arrays:
        given = {key: arrays[key] for key in arrays}
    if name == "cube":  # shown at 0.63 of its size about its centre, in a box of side 1 m
        centre = 0.5 * (given["V"].min(axis=0) + given["V"].max(axis=0))
        given["matrix"] = np.diag([0.63, 0.63, 0.63, 1.0])
        given["matrix"][:3, 3] = 0.37 * centre
        given["box"] = np.stack([centre - 0.5, centre + 0.5])
    file = folder / f"{name}.stl"
    trimesh.Trimesh(1e3 * given["V"], given["F"], process=False).export(file)
    low, high = given["box"].tolist()
    text = SCENE.format(name=name, low=low, high=high, matrix=given["matrix"].tolist())
    file.with_suffix(".toml").write_text(text)
    values = (given[k].astype(np.float64) for k in ("points", "displacement", "distance"))
    case = Case(name, file, given["matrix"], given["box"], *values)
    case.save(folder)
    return case


def run_script(script: str, folder: Path, options: dict[str, float]) -> dict[str, Any] | None:
    """One package at one setting; None where it fails."""
    words = [sys.executable, str(HERE / script), str(folder)]
    for name, value in options.items():
        words += [f"--{name}", str(value)]
    threads = {"NGS_NUM_THREADS": "2", "OMP_NUM_THREADS": "2", "NUMBA_NUM_THREADS": "2"}
    try:
        done = subprocess.run(
            words, capture_output=True, text=True, timeout=900, env=os.environ | threads
        )
    except subprocess.TimeoutExpired:
        print(f"{script} {options}: no result in 15 minutes", file=sys.stderr)
        return None
    for line in reversed(done.stdout.splitlines()):
        if line.startswith('{"case"'):
            return json.loads(line)
    print(f"{script} {options} failed:\n{done.stderr[-800:]}", file=sys.stderr)
    return None


def time_at(records: list[dict[str, Any]], rms_mm: float) -> float | None:
    """Seconds that a package needs for an error, between its settings; None outside them."""
    row = sorted((np.log(r["rms_mm"]), np.log(r["total_s"])) for r in records)
    if len(row) < 2 or not row[0][0] <= np.log(rms_mm) <= row[-1][0]:
        return None
    errors, times = zip(*row, strict=True)
    return float(np.exp(np.interp(np.log(rms_mm), errors, times)))


def speed_ups(name: str, records: dict[str, list[dict[str, Any]]]) -> list[Figure]:
    """Each peer's time over ours, at the error of each of the peer's settings."""
    figures = []
    for peer, rows in records.items():
        for row in rows if peer != "touchwarp" else []:
            own = time_at(records["touchwarp"], row["rms_mm"])
            coarsest = max(records["touchwarp"], key=lambda r: r["rms_mm"], default=None)
            if own is None and coarsest and coarsest["rms_mm"] < row["rms_mm"]:
                own = coarsest["total_s"]  # better than asked for, and counted as it is
            if own is not None:
                claim = f"{name}: {peer} at rms {row['rms_mm']:.3f} mm, time over ours"
                figures.append(Figure(claim, row["total_s"] / own, "×", at_least=30.0))
    return figures


def accuracy(name: str, records: list[dict[str, Any]]) -> list[Figure]:
    """The claims on the default tolerance."""
    figures = []
    for row in records:
        if row["settings"]["tolerance_mm"] == 0.1:
            figures.append(Figure(f"{name}: rms error", row["rms_mm"], "mm", at_most=0.05))
            figures.append(Figure(f"{name}: greatest error", row["max_mm"], "mm", at_most=0.3))
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--cube", type=Path, help="the reference of the box, cube.npz")
    parser.add_argument("--mug", type=Path, help="the reference made by mug_reference.py")
    parser.add_argument("--quick", action="store_true", help="only two settings of each package")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    references = {k: v for k in ("cube", "mug") if (v := getattr(options, k)) is not None}
    if not references:
        parser.error("nothing to compare on: give --cube, --mug or both")
    figures: list[Figure] = []
    everything: list[dict[str, Any]] = []
    for name, reference in references.items():
        with tempfile.TemporaryDirectory() as folder:
            write_case(name, reference, Path(folder))
            records: dict[str, list[dict[str, Any]]] = {package: [] for package in SCRIPTS}
            for package, script in SCRIPTS.items():
                for setting in SETTINGS[name][package][: 2 if options.quick else None]:
                    record = run_script(script, Path(folder), setting)
                    if record is not None:
                        records[package].append(record)
                        everything.append(record)
        print_table(
            f"{name}: mesh file → 128³ table",
            [
                "package",
                "settings",
                "unknowns",
                "s",
                "CPU s",
                "mesh, solve, table",
                "rms",
                "p99",
                "max mm",
            ],
            [
                [
                    r["package"],
                    " ".join(f"{k}={v:g}" for k, v in r["settings"].items()),
                    f"{r['unknowns']:,}",
                    f"{r['total_s']:.2f}",
                    f"{r['cpu_s']:.2f}",
                    ", ".join(f"{s:.2f}" for s in r["stages_s"].values()),
                    *(f"{r[k]:.4f}" for k in ("rms_mm", "p99_mm", "max_mm")),
                ]
                for rows in records.values()
                for r in rows
            ],
        )
        figures += accuracy(name, records["touchwarp"]) + speed_ups(name, records)
    print_figures("touchwarp against finite elements", figures)
    if options.json:
        save_json(options.json, figures, records=everything)


if __name__ == "__main__":
    main()
