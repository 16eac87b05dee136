"""What is missing is made, soonest useful first; what a change makes worthless is stopped."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from touchwarp.errors import SceneError, SolveError
from touchwarp.live import workbench as workbench_module
from touchwarp.live.messages import ChangeScene, FromServer, Placement, Pose, SceneState
from touchwarp.live.opening import open_workbench
from touchwarp.live.workbench import Workbench
from touchwarp.warp import AffineBases, TableWarp, load_warp

MOVED = Placement(scale=(1, 1, 1), rotation_deg=(0, 0, 0), translation=(0, 0.012, 0))


class Told(list[FromServer]):
    """Everything that a workbench tells, and a way to wait for some of it."""

    def __init__(self) -> None:
        super().__init__()
        self._more = threading.Condition()

    def __call__(self, message: FromServer) -> None:
        with self._more:
            self.append(message)
            self._more.notify_all()

    def wait(self, found: Callable[[FromServer], bool]) -> FromServer:
        deadline = time.monotonic() + 600  # kernels may have to be compiled first
        with self._more:
            while not any(found(m) for m in self):
                assert self._more.wait(deadline - time.monotonic()), "told nothing of the kind"
            return next(m for m in self if found(m))


@pytest.fixture
def told() -> Told:
    return Told()


def complete(message: FromServer) -> bool:
    return (
        isinstance(message, SceneState)
        and message.warp_current
        and message.bases is not None
        and message.certificate is not None
    )


def test_everything_is_made_and_then_follows_a_change(
    ball_path: Path, tmp_path: Path, told: Told
) -> None:
    bench = open_workbench(ball_path, tmp_path, told)
    try:
        bench.start()
        first = told.wait(complete)
        assert isinstance(first, SceneState)
        kinds = [m.task for m in told if m.kind == "progress"]
        assert list(dict.fromkeys(kinds)) == ["bases", "solve", "check"]
        told.clear()
        bench.change(ChangeScene(goals={"ball": MOVED}))
        second = told.wait(complete)
        assert isinstance(second, SceneState)
        assert second.warp is not None
        assert first.warp is not None
        assert bench.file(first.warp.identity) is not None  # a slow page may still ask for it
        path = bench.file(second.warp.identity)
        assert path is not None
        warp = load_warp(path)
        assert isinstance(warp, TableWarp)
        shown = warp(np.array([[0.05, 0, 0], [0, -0.05, 0]]))
        np.testing.assert_allclose(shown, [[0.05, 0.012, 0], [0, -0.038, 0]], atol=1e-3)
        assert "bases" not in [m.task for m in told if m.kind == "progress"]
        assert second.certificate is not None
        assert second.certificate.identity == second.warp.identity
    finally:
        bench.close()


def test_an_object_that_leaves_the_outer_boundary_is_refused_at_once(
    ball_path: Path, tmp_path: Path, told: Told
) -> None:
    bench = open_workbench(ball_path, tmp_path, told)  # its thread is not begun
    before = bench.state
    assert before.outer_fixed
    outside = MOVED.model_copy(update={"translation": (0.0, 0.0, -0.3)})
    with pytest.raises(SceneError, match="must lie inside the outer boundary"):
        bench.change(ChangeScene(goals={"ball": outside}))
    assert bench.state == before


def test_a_surface_stays_for_a_page_that_is_slow_to_ask(
    ball_path: Path, tmp_path: Path, told: Told
) -> None:
    bench = open_workbench(ball_path, tmp_path, told)  # its thread is not begun

    def shown() -> bytes | None:
        (prop,) = bench.state.props
        keys.append(prop.surface.removeprefix("./surfaces/").removesuffix(".bin"))
        return bench.surface(keys[-1])

    keys: list[str] = []
    first = shown()
    bench.change(ChangeScene(poses={"ball": Pose(position=(0, 0, 0.01), rotation_deg=(0, 0, 0))}))
    assert shown() is not None
    assert keys[0] != keys[1]
    assert bench.surface(keys[0]) == first is not None


def test_bases_serve_the_goals_that_they_promise(
    ball_path: Path, tmp_path: Path, told: Told
) -> None:
    bench = open_workbench(ball_path, tmp_path, told)
    bench.finish()
    state = bench.state
    assert state.bases is not None
    path = bench.file(state.bases.identity)
    assert path is not None
    bases = load_warp(path)
    assert isinstance(bases, AffineBases)
    goal = np.eye(4)
    goal[:3, 3] = [0.0, 0.03, -0.01]
    contact = bases.warp({"ball": goal})(np.array([[0.05, 0, 0]]))
    np.testing.assert_allclose(contact, [[0.05, 0.03, -0.01]], atol=1e-3)


def test_a_change_stops_the_work_that_it_makes_worthless(
    ball_path: Path, tmp_path: Path, told: Told, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, goes_on, stopped = threading.Event(), threading.Event(), []

    def endless(scene: object, tolerance_mm: float, progress: Callable[[str, float], None]) -> None:
        try:
            while True:
                begun.set()
                goes_on.wait(10)
                progress("endless", 0.5)
        except BaseException as error:
            stopped.append(error)
            monkeypatch.setattr(workbench_module, "solve_bases", failing)
            raise

    def failing(scene: object, tolerance_mm: float, progress: object) -> None:
        raise SolveError("no room")

    monkeypatch.setattr(workbench_module, "solve_bases", endless)
    bench = open_workbench(ball_path, tmp_path, told)
    try:
        bench.start()
        assert begun.wait(60)
        bench.change(ChangeScene(mismatch_weight=3.0))
        goes_on.set()
        failed = told.wait(lambda m: m.kind == "failed")
        assert len(stopped) == 1
        assert (failed.task, failed.reason) == ("bases", "no room")  # type: ignore[union-attr]
        told.wait(lambda m: isinstance(m, SceneState) and m.warp_current)
    finally:
        bench.close()


def test_states_are_told_in_their_order(
    ball_path: Path, tmp_path: Path, told: Told, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where the scene changes while the thread, which is slow, tells of the one before."""
    tells, overtaken = threading.Event(), threading.Event()

    def failing(scene: object, tolerance_mm: float, progress: object) -> None:
        raise SolveError("no room")

    def publish(message: FromServer) -> None:
        if isinstance(message, SceneState):
            if threading.current_thread().name != "workbench":
                overtaken.set()
            elif not tells.is_set():
                tells.set()
                overtaken.wait(2.0)
        told(message)

    monkeypatch.setattr(workbench_module, "solve_bases", failing)
    bench = open_workbench(ball_path, tmp_path, publish)
    try:
        bench.start()
        assert tells.wait(60)
        bench.change(ChangeScene(goals={"ball": MOVED}))
    finally:
        bench.close()
    revisions = [message.revision for message in told if isinstance(message, SceneState)]
    assert revisions[:2] == [0, 1]
    assert revisions == sorted(revisions)


def test_a_warp_without_its_meshes_is_seen_but_not_changed(
    ball_table: TableWarp, tmp_path: Path, told: Told
) -> None:
    lost = ball_table.meta.scene_text.replace(
        'shape = { kind = "ellipsoid", size = [0.1, 0.1, 0.1] }', 'mesh = "gone.stl"\nunit = "mm"'
    )
    from dataclasses import replace

    table = TableWarp(ball_table.bricks, replace(ball_table.meta, scene_text=lost))
    table.save(tmp_path / "ball.warp")
    (tmp_path / "tables").mkdir()
    bench: Workbench = open_workbench(tmp_path / "ball.warp", tmp_path / "tables", told)
    state = bench.state
    assert not state.solvable
    assert bench.surface(state.props[0].surface.split("/")[-1].removesuffix(".bin")) is not None
    with pytest.raises(SceneError, match=r"can be seen but not solved anew: .*gone.stl"):
        bench.change(ChangeScene(mismatch_weight=1.0))


def test_a_plane_scene_is_told(tmp_path: Path, told: Told) -> None:
    path = Path(__file__).resolve().parents[2] / "examples" / "coaster.toml"
    with pytest.raises(SceneError, match="shows scenes in space only"):
        open_workbench(path, tmp_path, told)


def test_a_warp_of_another_scene_is_passed_over(
    ball_path: Path,
    ball_table: TableWarp,
    tmp_path: Path,
    told: Told,
    caplog: pytest.LogCaptureFixture,
) -> None:
    ball_table.save(ball_path.with_suffix(".warp"))
    ball_table.save(ball_path.with_suffix(".bases"))
    ball_path.write_text(ball_path.read_text().replace("0.01, 0, 0]", "0.02, 0, 0]"))
    bench = open_workbench(ball_path, tmp_path, told)
    assert bench.state.warp is None
    assert "ball.warp is not used: The goal of 'ball' is not the one" in caplog.text
    assert "ball.bases is not used: it holds something else" in caplog.text


def test_a_warp_of_another_weight_is_passed_over(
    ball_path: Path,
    ball_table: TableWarp,
    tmp_path: Path,
    told: Told,
    caplog: pytest.LogCaptureFixture,
) -> None:
    ball_table.save(ball_path.with_suffix(".warp"))
    text = ball_path.read_text()
    ball_path.write_text(text.replace("[objective]", "[objective]\nmismatch_weight = 5"))
    assert open_workbench(ball_path, tmp_path, told).state.warp is None
    assert "it was solved with another λ" in caplog.text
