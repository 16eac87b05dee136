"""One problem that every package solves: a mesh file, an affine goal, an outer box, true values."""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

TABLE_NODES = 128


@dataclass(frozen=True)
class Case:
    """Δu = 0 between a prop and a box around it.

    Attributes:
        name: of the case.
        mesh: the prop, an STL file in mm.
        matrix: (4, 4) the goal, m: u = matrix·x − x on the prop.
        box: (2, 3) m, where u = 0.
        points: (n, 3) m, in Ω.
        displacement: (n, 3) m, the reference's u there.
        distance: (n,) m, from the prop.
    """

    name: str
    mesh: Path
    matrix: np.ndarray
    box: np.ndarray
    points: np.ndarray
    displacement: np.ndarray
    distance: np.ndarray

    def save(self, folder: Path) -> None:
        """Into `folder`, beside the mesh."""
        arrays = ("matrix", "box", "points", "displacement", "distance")
        np.savez(folder / "case.npz", **{name: getattr(self, name) for name in arrays})
        (folder / "case.json").write_text(json.dumps({"name": self.name, "mesh": self.mesh.name}))

    @classmethod
    def load(cls, folder: Path) -> Case:
        """From the folder that `save` wrote to."""
        names = json.loads((folder / "case.json").read_text())
        with np.load(folder / "case.npz") as arrays:
            return cls(names["name"], folder / names["mesh"], **arrays)

    def table_axes(self) -> list[np.ndarray]:
        """Three axes (128,) m of the regular table, over the box."""
        return [np.linspace(self.box[0, k], self.box[1, k], TABLE_NODES) for k in range(3)]

    def goal_displacement(self, x: np.ndarray) -> np.ndarray:
        """u (n, 3) m on the prop at x (n, 3) m."""
        return x @ (self.matrix[:3, :3] - np.eye(3)).T + self.matrix[:3, 3]

    def errors(self, displacement: np.ndarray) -> dict[str, float]:
        """How far a solution's u (n, 3) m at `points` is from the reference, mm."""
        error = 1e3 * np.linalg.norm(displacement - self.displacement, axis=1)
        return {
            "rms_mm": float(np.sqrt((error**2).mean())),
            "p99_mm": float(np.quantile(error, 0.99)),
            "max_mm": float(error.max()),
        }


@dataclass
class Stopwatch:
    """Wall time of the stages of one run, and processor time of all its threads, s."""

    stages: dict[str, float] = field(default_factory=dict)
    last: float = field(default_factory=time.perf_counter)
    cpu_start: float = field(default_factory=time.process_time)
    cpu: float = 0.0

    def lap(self, stage: str) -> None:
        """The time since the last lap belongs to `stage`."""
        now = time.perf_counter()
        self.stages[stage] = self.stages.get(stage, 0.0) + now - self.last
        self.last = now
        self.cpu = time.process_time() - self.cpu_start

    def restart(self) -> None:
        """Forget what came before: compiling, warming up."""
        self.stages.clear()
        self.last, self.cpu_start = time.perf_counter(), time.process_time()


def run_package(package: str, run, **settings: float) -> None:
    """The command line of one package's script: solve the case, print a JSON record.

    Args:
        package: its name in the table.
        run: called with the case, a Stopwatch and the settings; returns u (n, 3) m at the case's
            points and the number of unknowns. Evaluation at the points is not to be timed: it ends
            with the last lap.
        settings: numbers that can be given as options, with their defaults.
    """
    parser = argparse.ArgumentParser(description=f"{package} on one case; prints a JSON record.")
    parser.add_argument("case", type=Path, help="folder made by compare.py")
    for name, default in settings.items():
        parser.add_argument(f"--{name.replace('_', '-')}", type=float, default=default)
    options = vars(parser.parse_args())
    case = Case.load(options.pop("case"))
    watch = Stopwatch()
    displacement, unknowns = run(case, watch, **options)
    record = {
        "case": case.name,
        "package": package,
        "settings": options,
        "unknowns": unknowns,
        "stages_s": watch.stages,
        "total_s": sum(watch.stages.values()),
        "cpu_s": watch.cpu,
        **case.errors(displacement),
    }
    print(json.dumps(record))
