"""Holes whose rims are not flat are capped by the least area."""

from __future__ import annotations

import numpy as np
import pytest

from tests.scan.scans import fine_mug, holed
from touchwarp.scan import cleaning
from touchwarp.scan.curved_cap import MOST_CORNERS, least_area_cap
from touchwarp.scan.deviation import deviation, face_areas
from touchwarp.scan.repair import repair
from touchwarp.scan.soundness import inspect
from touchwarp.scene.surface import Surface

ELL = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]], dtype=float)


def free(count: int) -> np.ndarray:
    return np.zeros((count, count), dtype=bool)


def area(rim: np.ndarray, faces: np.ndarray) -> float:
    return float(face_areas(Surface(rim, faces)).sum())


def test_a_flat_rim_is_filled_and_not_more() -> None:
    rim = np.column_stack([np.roll(ELL, 2, axis=0), np.zeros(len(ELL))])
    cap = least_area_cap(rim, free(6))
    assert cap is not None
    assert area(rim, cap) == pytest.approx(5.0)  # 3 × 1 and 1 × 2
    # it runs as the rim does
    sides = rim[cap]
    assert (np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])[:, 2] >= 0).all()
    # the twin: the fan from its first corner leaves the rim
    fan = np.array([[0, k, k + 1] for k in range(1, 5)])
    assert area(rim, fan) > 5.5


def test_a_folded_rim_is_capped_across_the_shorter_way_unless_barred() -> None:
    rim = np.array([[1.0, 0, 0], [0, 2, 1], [-1, 0, 0], [0, -2, 1]])
    short = least_area_cap(rim, free(4))
    barred = free(4)
    barred[0, 2] = barred[2, 0] = True
    other = least_area_cap(rim, barred)
    assert short is not None
    assert other is not None
    assert {0, 2} <= set(short[0]) & set(short[1])
    assert {1, 3} <= set(other[0]) & set(other[1])
    assert area(rim, short) < area(rim, other)
    barred[:] = True
    assert least_area_cap(rim, barred) is None
    assert least_area_cap(np.zeros((MOST_CORNERS + 1, 3)), free(MOST_CORNERS + 1)) is None


def test_a_hole_over_the_lip_is_capped_and_the_rest_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    mug = fine_mug(3e-3)
    scan = holed(mug, np.array([[-0.04, 0.0, 0.095]]), 6e-3)
    done = repair(scan)
    assert inspect(done.surface).sound
    assert done.genus == 1
    assert done.steps[-1] == "1 hole capped"
    assert deviation(scan, done.surface).max_mm < 1e-6
    # nothing but the lip is missing, and the cap lies within the wall of 4 mm
    assert deviation(done.surface, mug).max_mm < 2.1
    # the twin: without such caps the scan has to be wrapped, which moves all of it
    monkeypatch.setattr(cleaning, "SMALL_HOLE", 0.0)
    assert not any("capped" in step for step in repair(scan, voxel_mm=1.5, faces=None).steps)
