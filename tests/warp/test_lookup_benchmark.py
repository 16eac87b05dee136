"""The benchmark of lookups runs, and tells every figure that it promises."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from tests.warp.tables import environment, sphere_table

SCRIPT = Path(__file__).resolve().parents[2] / "benchmarks" / "lookup.py"


def test_the_benchmark_runs_on_a_warp_file(tmp_path: Path) -> None:
    sphere_table().save(tmp_path / "a.warp")
    command = [sys.executable, str(SCRIPT), str(tmp_path / "a.warp"), "--points=100", "--repeats=1"]
    told = subprocess.run(command, check=True, capture_output=True, text=True, env=environment())
    limits = [line for line in told.stdout.splitlines() if "(at most" in line]
    assert len(limits) == 5, told.stdout
