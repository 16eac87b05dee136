"""The reader printed in docs/warp-file.md reads what is saved."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.warp.tables import META, points_in, sliding_bricks, sphere_bricks, turned_bricks
from touchwarp.warp.bricks import Bricks
from touchwarp.warp.table import TableWarp

DOC = Path(__file__).resolve().parents[2] / "docs" / "warp-file.md"


def documented_reader(*changes: tuple[str, str]) -> dict[str, Any]:
    (code,) = re.findall(r"```python\n(.*?)```", DOC.read_text(encoding="utf-8"), re.DOTALL)
    for old, new in changes:
        assert old in code
        code = code.replace(old, new)
    code = code.replace('open(path, "rb").read()', "path.read_bytes()")
    names: dict[str, Any] = {}
    exec(code, names)
    return names


def disagreement(path: Path, bricks: Bricks, *changes: tuple[str, str], dtype: Any = "float32"):
    """Greatest distance between what the documented reader and the warp display."""
    warp = TableWarp(bricks, META)
    warp.save(path, dtype=dtype)
    reader = documented_reader(*changes)
    document, tensors = reader["read"](path)
    x = points_in(bricks, 300)
    told = np.array([reader["displayed"](document, tensors, row) for row in x.tolist()])
    return np.abs(told - warp(x)).max()


TABLES = {"plain": sphere_bricks, "turned": turned_bricks, "sliding": sliding_bricks}


@pytest.mark.parametrize("table", TABLES)
def test_the_documented_reader_agrees_with_the_warp(table: str, tmp_path: Path) -> None:
    assert disagreement(tmp_path / "w.warp", TABLES[table]()) < 1e-15


def test_the_documented_reader_reads_float16(tmp_path: Path) -> None:
    loss = disagreement(tmp_path / "w.warp", sphere_bricks(), dtype="float16")
    assert 0.0 < loss < 1e-4


@pytest.mark.parametrize(
    ("table", "old", "new"),
    [
        ("plain", "9 + i) * 9 + j) * 9 + k", "9 + k) * 9 + j) * 9 + i"),
        ("plain", "weight = [8.0 * fraction[d] - cell[d]", "weight = [8.0 * fraction[d] - 0.5"),
        ("plain", "4 * half[0] + 2 * half[1] + half[2]", "half[0] + 2 * half[1] + 4 * half[2]"),
        ("turned", "R[i][d] * (x[i] - o[i])", "R[d][i] * (x[i] - o[i])"),
        ("turned", "8.0 * spacing[d]", "8.0 * spacing[2 - d]"),
        ("sliding", "sign, fade = -1.0", "sign, fade = 1.0"),
        ("sliding", "1.0 + p[2] / depth", "1.0"),
    ],
)
def test_the_agreement_rejects_a_wrong_reader(table, old, new, tmp_path: Path) -> None:
    assert disagreement(tmp_path / "w.warp", TABLES[table](), (old, new)) > 1e-4
