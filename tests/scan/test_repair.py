"""A repair closes a scan, keeps its handles and stays near it, or says why it cannot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.scan.scans import (
    fine_mug,
    holed,
    noisy,
    with_duplicates,
    with_speck,
    with_tunnel,
    with_turned_faces,
)
from touchwarp.errors import SceneError
from touchwarp.scan.deviation import deviation
from touchwarp.scan.repair import repair
from touchwarp.scan.soundness import inspect, volume
from touchwarp.scene import read_mesh
from touchwarp.scene.shapes import box, make_shape, polygon
from touchwarp.scene.surface import Surface


@pytest.fixture(scope="module")
def mug() -> Surface:
    return fine_mug(3e-3)


def test_a_sound_mesh_is_returned_as_it_is(mug: Surface) -> None:
    done = repair(mug)
    assert done.surface is mug
    assert done.steps == ()
    assert (done.genus_before, done.genus) == (1, 1)
    assert done.from_input.max_mm < 1e-9


def test_turned_faces_duplicates_and_specks_need_no_wrap(mug: Surface) -> None:
    dirty = with_speck(with_duplicates(with_turned_faces(mug, 0.2), 30))
    assert not inspect(dirty).sound
    done = repair(dirty)
    assert inspect(done.surface).sound
    assert done.genus == 1
    assert not any("wrapped" in step for step in done.steps)
    assert deviation(done.surface, mug).max_mm < 1e-3
    assert volume(done.surface) == pytest.approx(volume(mug), rel=1e-6)


def test_a_mesh_turned_inside_out_is_turned_back(mug: Surface) -> None:
    done = repair(Surface(mug.vertices, mug.faces[:, ::-1]))
    assert volume(done.surface) == pytest.approx(volume(mug))


def test_small_holes_are_capped_flat(mug: Surface) -> None:
    centres = np.array([[-0.04, 0.0, 0.05], [0.0, 0.04, 0.03], [0.0, -0.036, 0.06]])
    done = repair(holed(mug, centres, 5e-3))
    assert inspect(done.surface).sound
    assert done.genus == 1
    assert "capped" in done.steps[-1]
    # a flat cap over a hole of radius 5 + 3 mm in a wall of radius 40 mm is off by r²/2R = 0.8 mm
    assert deviation(done.surface, mug).max_mm < 1.0
    assert done.genus_before is None


def shattered(mug: Surface) -> Surface:
    """Noise, sixty holes, and 20 µm between what lies on either side of y = 0: too far to weld."""
    random = np.random.default_rng(3)
    where = random.choice(len(mug.vertices), 60, replace=False)
    open_mug = noisy(holed(mug, mug.vertices[where], 4e-3), 1e-4)
    side = open_mug.vertices[open_mug.faces].mean(axis=1)[:, 1] > 0
    apart = np.where(side[:, None], open_mug.faces + len(open_mug.vertices), open_mug.faces)
    beside = open_mug.vertices + np.array([0, 2e-5, 0])
    return Surface(np.concatenate([open_mug.vertices, beside]), apart)


def test_a_scan_in_pieces_is_wrapped_with_its_handle(mug: Surface) -> None:
    done = repair(shattered(mug), voxel_mm=1.6, faces=None)
    assert inspect(done.surface).sound
    assert inspect(done.surface).genus == done.genus == 1
    assert any("wrapped" in step for step in done.steps)
    assert deviation(mug, done.surface).p99_mm < 1.5
    assert deviation(done.surface, mug).mean_mm < 0.3


def test_a_repair_that_drops_the_handle_is_refused(mug: Surface) -> None:
    with pytest.raises(SceneError, match=r"genus 0 \(asked for\).*Tried: .*genus 1"):
        repair(shattered(mug), genus=0, voxel_mm=3.0)


def test_a_voxel_that_closes_the_handle_or_breaks_the_wall_is_refused(mug: Surface) -> None:
    with pytest.raises(SceneError, match=r"no repair keeps the topology.*genus 1"):
        repair(shattered(mug), genus=1, voxel_mm=30.0)


def test_wraps_end_at_a_bound_of_work(mug: Surface, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("touchwarp.scan.repair.MOST_WORK", 1000)
    with pytest.raises(SceneError, match=r"genus 1 \(asked for\).*end at 0.001 million") as refused:
        repair(shattered(mug), genus=1)
    assert "wrapped" not in str(refused.value)
    # the twin: a voxel that is asked for is tried whatever the bound
    assert repair(shattered(mug), genus=1, voxel_mm=1.6, faces=None).genus == 1


@pytest.mark.parametrize(("finer", "tries"), [(11, 2), (6, 11)])
def test_wraps_end_where_a_finer_voxel_keeps_the_handles(
    finer: int, tries: int, mug: Surface, monkeypatch: pytest.MonkeyPatch
) -> None:
    # a wall seen from one side only has holes at any voxel; those of a thin wall get fewer
    thing = fine_mug()
    found = {1: thing}
    for angle in 0.5 + 0.55 * np.arange(10):
        thing = with_tunnel(thing, [0.04 * np.cos(angle), 0.04 * np.sin(angle), 0.04])
        found[inspect(thing).genus or 0] = thing
    made: list[float] = []

    def wrap(surface: Surface, voxel: float, *more: object, **options: object) -> Surface:
        made.append(voxel)
        return found[11 if voxel == made[0] else finer]

    monkeypatch.setattr("touchwarp.scan.repair.wrap", wrap)
    monkeypatch.setattr("touchwarp.scan.repair.wall_thickness", lambda surface: 1.0)
    monkeypatch.setattr("touchwarp.scan.repair.MOST_WORK", 1e9)
    with pytest.raises(SceneError, match="a wall seen from one side only cannot be closed"):
        repair(shattered(mug), genus=1)
    # of few handles each voxel's narrow tunnels are closed, in two widths, there and back
    assert len(made) == tries


def test_a_bound_that_is_not_met_is_refused(mug: Surface) -> None:
    with pytest.raises(SceneError, match="1 % of the input lies more than"):
        repair(shattered(mug), genus=1, voxel_mm=1.5, bound_mm=0.01)


def test_a_sheet_is_not_capped_with_itself() -> None:
    corners = np.array([[0.0, 0, 0], [0.1, 0, 0], [0.1, 0.06, 0], [0, 0.06, 0]])
    with pytest.raises(SceneError, match="it has no inside"):
        repair(Surface(corners, np.array([[0, 1, 2], [0, 2, 3]])), genus=0)


def test_a_thin_card_has_an_inside() -> None:
    card = box([0.086, 0.054, 0.0008])
    assert repair(Surface(card.vertices, card.faces[:-1])).genus == 0


def test_half_an_object_is_refused() -> None:
    surface = box([0.1, 0.1, 0.02])
    half = Surface(surface.vertices, surface.faces[:6])
    with pytest.raises(SceneError, match=r"spans holes|no repair keeps"):
        repair(half, genus=0, voxel_mm=4.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"genus": -1}, "genus is -1"),
        ({"bound_mm": 0.0}, "bound is 0.0 mm"),
        ({"voxel_mm": float("nan")}, "voxel is nan mm"),
    ],
)
def test_numbers_out_of_range(arguments: dict[str, float], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        repair(box([0.1, 0.1, 0.1]), **arguments)  # type: ignore[arg-type]


def test_a_polygon_is_refused() -> None:
    with pytest.raises(SceneError, match="a triangle surface is needed"):
        repair(polygon([(0, 0), (1, 0), (0, 1)]))


@pytest.mark.needs_shared_data
def test_a_raw_scan_with_442_holes_keeps_one_handle(shared_data: Path) -> None:
    done = repair(read_mesh(shared_data / "data" / "pitcher_rawscan_dirty.stl", "m"))
    assert done.before.holes == 442
    assert inspect(done.surface).sound
    assert done.genus == 1
    assert done.from_input.p99_mm < 1.0
    assert done.new_share < 0.1


@pytest.mark.needs_shared_data
def test_a_scan_s_spurious_tunnels_are_kept_until_asked(shared_data: Path) -> None:
    done = repair(read_mesh(shared_data / "data" / "mug_ycb_scan_dirty.obj", "m"))
    assert inspect(done.surface).sound
    assert done.genus == 3
    assert done.from_input.max_mm < 0.01


def test_the_library_s_mug_and_cup_are_sound() -> None:
    for kind in ("mug", "tea_cup"):
        assert inspect(make_shape(kind, {})).sound
