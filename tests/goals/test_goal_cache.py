"""A goal that was made once is not made again, and is the one that would be made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from touchwarp.cli.main import DEFECT, main
from touchwarp.goals import Goal, goals
from touchwarp.goals.goal_cache import GOALS
from touchwarp.goals.maps import make, parameterise
from touchwarp.scene import AreaPreservingGoal, MatchGoal, Prop, Scene, Surface
from touchwarp.scene.map_goals import Landmark
from touchwarp.scene.shapes import ellipsoid, sphere

EGG = ellipsoid([0.05, 0.06, 0.09], 1.0)
BALL = sphere(0.03, 1.0)
MATCH = MatchGoal(
    BALL, landmarks=[Landmark((0, 0, 0.045), (0, 0, 0.03))], tolerance_mm=1.0, starts=1
)
TIMES = ("seconds", "search_seconds")


class Made(Exception):
    """A maker was called."""


@pytest.fixture(autouse=True)
def small_and_alone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(parameterise, "EDGES_PER_SIZE", 10)
    monkeypatch.setenv("TOUCHWARP_CACHE", str(tmp_path / "cache"))


@pytest.fixture
def makers_stop(monkeypatch: pytest.MonkeyPatch) -> Callable[[], None]:
    def stop() -> None:
        def refuse(*_: object) -> Goal:
            raise Made

        monkeypatch.setattr(make, "match_goal", refuse)
        monkeypatch.setattr(make, "area_preserving_goal", refuse)

    return stop


def goal_of(spec: MatchGoal | AreaPreservingGoal, prop: Surface = EGG) -> Goal:
    return goals(Scene([Prop("egg", prop, spec)]))["egg"]


def without_times(goal: Goal) -> str:
    return repr({key: value for key, value in goal.report.items() if key not in TIMES})


@pytest.mark.parametrize("spec", [MATCH, AreaPreservingGoal(BALL, tolerance_mm=1.0, starts=1)])
def test_a_kept_goal_is_to_the_bit_what_is_made_without_the_cache(
    spec: MatchGoal | AreaPreservingGoal,
    makers_stop: Callable[[], None],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    goal_of(spec)
    with monkeypatch.context() as off:
        off.setenv("TOUCHWARP_CACHE", "")
        fresh = goal_of(spec)
    makers_stop()
    kept = goal_of(replace(spec, origin={"virtual_mesh": "ball.stl"}))
    for name in ("prop_points", "virtual_points", "faces", "landmarks"):
        one, other = getattr(kept, name), getattr(fresh, name)
        assert (one is None and other is None) or np.array_equal(one, other), name
    assert (kept.kind, kept.virtual_surface) == (fresh.kind, fresh.virtual_surface)
    assert without_times(kept) == without_times(fresh)
    assert {key: type(value) for key, value in kept.report.items()} == {
        key: type(value) for key, value in fresh.report.items()
    }


@pytest.mark.parametrize(
    "changed",
    [
        {"spec": replace(MATCH, area_weight=0.6)},
        {"spec": replace(MATCH, seed=1)},
        {"spec": replace(MATCH, tolerance_mm=0.9)},
        {"spec": replace(MATCH, landmarks=())},
        {"spec": replace(MATCH, landmarks=[Landmark((0, 0, 0.045), (0, 0.001, 0.03))])},
        {"spec": replace(MATCH, virtual=Surface(BALL.vertices + 1e-6, BALL.faces))},
        {"spec": replace(MATCH, virtual=Surface(BALL.vertices, BALL.faces[::-1]))},
        {"spec": AreaPreservingGoal(BALL, tolerance_mm=1.0, starts=1)},
        {"prop": Surface(EGG.vertices + 1e-6, EGG.faces)},
    ],
    ids=["weight", "seed", "tolerance", "no landmark", "landmark", "pose", "mesh", "kind", "prop"],
)
def test_another_setting_mesh_or_pose_is_made_anew(
    changed: dict[str, MatchGoal], makers_stop: Callable[[], None]
) -> None:
    goal_of(MATCH)
    makers_stop()
    assert goal_of(MATCH).kind == "match"
    with pytest.raises(Made):
        goal_of(**{"spec": MATCH, **changed})  # type: ignore[arg-type]


def test_a_damaged_goal_is_made_anew(makers_stop: Callable[[], None]) -> None:
    first = goal_of(MATCH)
    assert GOALS.folder is not None
    (path,) = GOALS.folder.iterdir()
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    assert np.array_equal(goal_of(MATCH).virtual_points, first.virtual_points)
    path.write_bytes(content)
    makers_stop()
    with pytest.raises(Made):
        goal_of(MATCH)


def test_a_second_command_makes_nothing(
    tmp_path: Path,
    makers_stop: Callable[[], None],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    scene = tmp_path / "egg.toml"
    scene.write_text(
        '[[prop]]\nname = "egg"\nshape = { kind = "ellipsoid", size = [0.05, 0.06, 0.09] }\n'
        '[prop.goal]\nkind = "match"\nstarts = 1\ntolerance_mm = 1\n'
        'virtual_shape = { kind = "sphere", radius = 0.03 }\n'
    )

    def goal_as(ending: str) -> int:
        return main(["goal", str(scene), "-o", str(tmp_path / f"egg{ending}")])

    assert goal_as(".npz") == 0
    makers_stop()
    assert goal_as(".npz") == 0
    assert goal_as(".glb") == 0
    monkeypatch.setenv("TOUCHWARP_CACHE", "")
    assert goal_as(".npz") == DEFECT
    assert "Made" in capsys.readouterr().err
