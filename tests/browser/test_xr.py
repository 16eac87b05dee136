"""The headset as a person uses it: enter, find the mug, verify, and touch what is seen."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq

from tests.browser.conftest import Enter
from tests.browser.desk import wait_until
from tests.browser.headset import RADIUS, TIPS, Headset
from tests.browser.person import AWAY, REST, Person, RealProp, touchable
from tests.browser.server import Server

GOAL = np.diag([1.2, 1.2, 0.6, 1.0])
GOAL[0, 3] = 0.015


def found_pose(headset: Headset) -> np.ndarray:
    """T_room_scene, as calibrated."""
    return np.array(headset.probe("[...it.placed.pose.matrix().elements]")).reshape(4, 4).T


def pose_errors(headset: Headset, prop: RealProp) -> tuple[float, float]:
    """Of the prop's middle in m, of its turn in degrees."""
    found, real = found_pose(headset), prop.T_room_scene
    middle = np.append(prop.vertices.mean(axis=0), 1.0)
    turn = np.trace(found[:3, :3].T @ real[:3, :3])
    angle = np.degrees(np.arccos(min(1.0, (turn - 1.0) / 2.0)))
    return float(np.linalg.norm((found - real) @ middle)), float(angle)


DISPLAYED = "touchwarpProbe.displacement.displayed.map((hand) => [...hand])"


def test_the_skin_that_touches_is_displayed_on_the_virtual_surface(
    enter: Enter, screenshots: Path
) -> None:
    """200 places, both hands, five fingers: within 0.5 mm of the cup."""
    person = enter()
    headset, mug = person.headset, person.prop
    headset.picture(screenshots / "xr_begin.png")
    person.rub()
    assert pose_errors(headset, mug)[0] < 1e-3
    headset.picture(screenshots / "xr_verify.png")
    person.verify()
    assert headset.probe("it.session.phase") == "immersed"
    headset.await_warp()
    person.rest(2.0)
    assert headset.probe("it.displacement.weight") == 1
    frames = []
    asked = []
    for k in range(10):
        side, finger = ("left", "right")[k % 2], k // 2
        other = ("right", "left")[k % 2]
        rest = headset.open_hand(other, AWAY if other == "left" else REST)
        for hand in person.touching(touchable(mug, 20, seed=k), side, finger):
            frames.append({side: hand, other: rest})
            asked.append((k % 2, TIPS[finger]))
    shown = headset.step(frames, DISPLAYED)
    centres = np.array(
        [
            np.reshape(hands[side], (25, 4, 4))[tip, 3, :3]
            for hands, (side, tip) in zip(shown, asked, strict=True)
        ]
    )
    scene = mug.to_scene(centres)
    gaps = np.abs(mug.distance(scene, GOAL) - RADIUS)
    print(
        f"displayed skin to cup: median {1e3 * np.median(gaps):.3f}, max {1e3 * gaps.max():.3f} mm"
    )
    assert gaps.max() < 0.5e-3
    # the claim can fail: against the mug itself, which the person does not see, it does
    assert np.median(np.abs(mug.distance(scene) - RADIUS)) > 5e-3
    headset.step(frames[-1:] * 20)
    headset.picture(screenshots / "xr_touch.png")


def test_hands_up_a_lost_hand_a_moved_origin_and_coming_back(
    enter: Enter, screenshots: Path
) -> None:
    person = enter(noise=1e-3)
    headset = person.headset
    person.rub()
    millimetres, degrees = (
        1e3 * pose_errors(headset, person.prop)[0],
        pose_errors(headset, person.prop)[1],
    )
    print(f"found with 1 mm of noise: {millimetres:.2f} mm, {degrees:.2f}°")
    assert millimetres < 1.0
    assert degrees < 0.5
    person.verify()
    headset.await_warp()
    person.rest(2.0)
    assert headset.probe("[it.displacement.weight, it.anchored.held]") == [1, True]
    right = person.touching(np.array([0.0, 0.1, 0.06]))[0]

    headset.page.evaluate("headset.lost.add('right')")
    headset.wait(0.5, right=right)
    assert headset.probe("it.inputs[1].tracked") is False
    headset.page.evaluate("headset.lost.delete('right')")
    weights = headset.step([{"right": right}] * 72, "touchwarpProbe.displacement.handWeight(1)")
    assert weights[0] < 0.2  # it comes back undisplaced, and eases in
    assert np.diff(weights).max() < 0.1
    assert weights[-1] == 1

    up = np.array([0.2, 1.5, -0.1])
    headset.wait(0.8, left=headset.open_hand("left", up), right=headset.open_hand("right", up))
    assert headset.probe("[...it.session.pauses]") == ["asked"]
    headset.wait(1.0, left=headset.open_hand("left", AWAY), right=right)
    assert headset.probe("[it.displacement.weight, it.world]") == [0, 0]
    headset.picture(screenshots / "xr_paused.png")
    headset.poke("Resume")
    person.rest(2.0)
    assert headset.probe("it.displacement.weight") == 1

    headset.probe("it.room.renderer.xr.getReferenceSpace().dispatchEvent(new Event('reset'))")
    headset.wait(1.0)
    assert headset.probe("[it.session.phase, it.displacement.weight]") == ["verify", 0]
    person.verify()
    person.rest(2.0)
    assert headset.probe("[it.session.phase, it.displacement.weight]") == ["immersed", 1]

    headset.leave()
    headset.enter()
    assert headset.probe("it.session.phase") == "calibrate"
    person.arrive()


def test_it_fades_when_the_head_leaves_and_when_the_headset_shows_something_else(
    enter: Enter,
) -> None:
    person = enter()
    headset = person.headset
    person.arrive()
    for leave, come_back, pause in (
        (
            "headset.device.position.set(0, 1.2, 1.1)",
            "headset.device.position.set(0, 1.2, 0.35)",
            "outside",
        ),
        (
            "headset.device.updateVisibilityState('visible-blurred')",
            "headset.device.updateVisibilityState('visible')",
            "hidden",
        ),
    ):
        headset.page.evaluate(leave)
        person.rest(1.0)
        assert headset.probe("[...it.session.pauses]") == [pause]
        assert headset.probe("[it.displacement.weight, it.world]") == [0, 0]
        headset.page.evaluate(come_back)
        person.rest(2.5)
        assert headset.probe("[it.displacement.weight, it.world]") == [1, 1]


def test_a_prop_that_was_moved_is_noticed_by_touching(enter: Enter, screenshots: Path) -> None:
    """The audit puts 9 mm down to the calibration, asks for another, and is content after it."""
    person = enter()
    headset = person.headset
    person.arrive()
    assert not headset.probe("it.displacement.watch.audit.hasDrifted")
    person.prop.T_room_scene[:3, 3] += [0.007, 0.0, 0.0055]
    tap_all_around(person)
    told = headset.probe("it.displacement.watch.audit.typical")
    assert headset.probe("it.displacement.watch.audit.hasDrifted")
    assert headset.probe("it.room.panel.content.title") == "Has the prop moved?"
    assert abs(told["calibration"]) > abs(told["tracking"])
    assert abs(told["warp"]) < 1e-3
    headset.picture(screenshots / "xr_drifted.png")
    headset.poke("Redo")
    assert headset.probe("it.session.phase") == "calibrate"
    person.arrive()
    tap_all_around(person)
    assert not headset.probe("it.displacement.watch.audit.hasDrifted")
    assert headset.probe("it.displacement.watch.audit.typical.gap") < 1e-3


def tap_all_around(person: Person) -> None:
    """Twelve taps: the fingertip comes, touches, stays a moment and goes."""
    for angle in np.linspace(-2.2, 2.2, 12):
        aim = np.array([0.2 * np.cos(angle), 0.2 * np.sin(angle), 0.06])
        touching = person.touching(aim)[0]
        away = person.prop.T_room_scene[:3, :3] @ np.array([np.cos(angle), np.sin(angle), 0.0])
        coming = []
        for gap in [*np.linspace(0.06, 0.0, 30), *[0.0] * 16, 0.03]:
            hand = touching.copy()
            hand[:, :3, 3] += gap * away
            coming.append({"right": hand})
        person.headset.step(coming)


def test_hands_are_recorded_in_the_headset(enter: Enter, mug_server: Server) -> None:
    person = enter()
    headset = person.headset
    page = headset.page
    headset.await_warp()  # which all that is recorded is displaced by
    headset.leave()
    page.locator("button[name=record]").click()
    page.locator("input[name=participant]").fill("P21")
    page.locator("input[name=consent]").check()
    page.locator("button[name=begin]").click()
    headset.enter()
    person.arrive()
    headset.step([{"right": hand} for hand in person.touching(touchable(person.prop, 30, 1))])
    assert headset.probe("it.room.panel.content.recording") == "P21"
    headset.poke("Stop rec.")
    assert headset.probe("it.room.panel.content.recording") is None
    headset.leave()
    (folder,) = (mug_server.recordings / "P21").iterdir()
    wait_until(page, (folder / "recording.parquet").exists, "the recording is not whole on disk")
    table = pq.read_table(folder / "recording.parquet")
    column = {name: table[name].to_numpy() for name in table.column_names if name != "warp"}
    assert set(column["hand"]) == {0, 1}
    right = column["hand"] == 1
    assert (np.diff(column["time_ms"][right]) > 0).all()
    displaced = np.linalg.norm(
        [column[f"displayed.wrist.{d}"] - column[f"real.wrist.{d}"] for d in "xyz"], axis=0
    )
    assert displaced[column["weight"] == 0].max() < 1e-6
    touching = (column["contacts"] > 0) & right & (column["weight"] == 1)
    assert touching.sum() >= 30
    assert displaced[touching].min() > 1e-3
    (identity,) = set(table["warp"].to_pylist())
    assert identity == page.evaluate(
        "fetch('./boot.json').then(a => a.json()).then(s => s.warp.identity)"
    )
    told = [note["text"] for note in recorded_notes(folder)]
    assert any("verified: immersed" in text for text in told)


def recorded_notes(folder: Path) -> list[dict[str, Any]]:
    import json

    notes: list[dict[str, Any]] = json.loads((folder / "about.json").read_text())["notes"]
    return notes
