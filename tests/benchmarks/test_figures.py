import importlib.util
import json
import sys
from pathlib import Path

import pytest

FILE = Path(__file__).resolve().parents[2] / "benchmarks" / "figures.py"
spec = importlib.util.spec_from_file_location("benchmark_figures", FILE)
figures = importlib.util.module_from_spec(spec)
sys.modules[spec.name] = figures
spec.loader.exec_module(figures)


@pytest.mark.parametrize(
    ("value", "limits", "holds"),
    [
        (0.04, {"at_most": 0.05}, True),
        (0.06, {"at_most": 0.05}, False),
        (31.0, {"at_least": 30.0}, True),
        (29.0, {"at_least": 30.0}, False),
        (29.0, {}, None),
    ],
)
def test_a_figure_says_whether_its_claim_holds(value, limits, holds):
    assert figures.Figure("error", value, "mm", **limits).holds is holds


def test_a_missed_claim_stands_out(capsys):
    figures.print_figures("errors", [figures.Figure("rms", 0.06, "mm", at_most=0.05)])
    assert capsys.readouterr().out.splitlines()[-1].split() == [
        "rms", "0.06", "mm", "≤", "0.05", "MISSED",
    ]  # fmt: skip


def test_figures_are_saved_with_the_machine(tmp_path):
    figure = figures.Figure("time", 1.2, "s", at_most=1.5)
    figures.save_json(tmp_path / "f.json", [figure], records=[{"a": 1}])
    saved = json.loads((tmp_path / "f.json").read_text())
    assert saved["figures"][0]["holds"] is True
    assert saved["records"] == [{"a": 1}]
    assert saved["machine"]["cores"] >= 1
    assert [p.name for p in tmp_path.iterdir()] == ["f.json"]
