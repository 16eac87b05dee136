"""The card in the headset: warnings that stay until they are read, and what its buttons do."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.browser.conftest import Enter
from tests.browser.headset import Headset
from tests.browser.person import AWAY, Person

ABOUT_THE_MUG = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
"""Corners (x, z) of bounds that hold the mug, if they are given in the frame of the floor."""


def bounds(place: tuple[float, float, float], turn_deg: float) -> dict[str, Any]:
    """The same corners in a frame of the bounds' own, which stands elsewhere in the room."""
    angle = np.radians(turn_deg)
    T = np.eye(4)
    T[0, 0] = T[2, 2] = np.cos(angle)
    T[0, 2], T[2, 0] = np.sin(angle), -np.sin(angle)
    T[:3, 3] = place
    return {"matrix": T.T.ravel().tolist(), "outline": ABOUT_THE_MUG}


def card(headset: Headset) -> tuple[str, list[str], list[str]]:
    """Title, lines and buttons, as they are shown."""
    title, lines, buttons = headset.probe(
        "[it.room.panel.content.title, it.room.panel.content.lines,"
        " it.room.panel.content.buttons.map(({ label }) => label)]"
    )
    return title, lines, buttons


def test_a_prop_outside_the_bounds_is_warned_of_until_that_is_read(enter: Enter) -> None:
    """Bounds whose frame is 3 m beside the floor's, turned: the mug is out of them."""
    person = enter(bounds=bounds((3.0, 0.0, 0.0), 30.0))
    headset = person.headset
    person.rub()
    person.rest(1.2)
    title, lines, buttons = card(headset)
    assert (title, lines[0]) == ("Careful", "The mug stands outside your play area.")
    assert "Understood" in buttons
    person.verify()  # whose own notices do not take its place
    person.rest(1.2)
    assert headset.probe("it.session.phase") == "immersed"
    assert card(headset)[:2] == (title, lines)
    headset.poke("Understood")
    person.rest(1.2)
    assert card(headset)[0] == "Touch what you see"
    # what is understood is told of again only where the mug is found anew
    headset.poke("Redo")
    person.rub()
    person.rest(1.2)
    assert card(headset)[0] == "Careful"


def test_bounds_that_hold_the_prop_in_their_own_frame_warn_of_nothing(enter: Enter) -> None:
    """Corners that, taken for places on the floor, would leave it out: they are 5 m away."""
    placed = bounds((5.0, 0.0, 4.0), 90.0)
    T = np.reshape(placed["matrix"], (4, 4)).T
    corners = np.array([[x, 0.0, z, 1.0] for x, z in ABOUT_THE_MUG])
    placed["outline"] = (corners @ np.linalg.inv(T).T)[:, [0, 2]].tolist()
    person = enter(bounds=placed)
    person.rub()
    person.rest(2.2)
    assert person.headset.probe("[it.session.phase, it.warning.length]") == ["verify", 0]


def test_pause_show_real_recentre_and_leave(enter: Enter) -> None:
    person = enter()
    headset = person.headset
    person.arrive()
    head = np.array([0.0, 1.2, 0.35])

    headset.poke("Pause")
    person.rest(1.0)
    assert headset.probe("[[...it.session.pauses], it.displacement.weight, it.world]") == [
        ["asked"],
        0,
        0,
    ]
    assert card(headset)[0] == "Paused"
    headset.poke("Resume")
    person.rest(2.5)
    assert headset.probe("[it.session.pauses.size, it.displacement.weight]") == [0, 1]

    headset.poke("Show real")
    headset.step([{"right": person.touching(np.array([0.0, 0.1, 0.06]))[0]}] * 3)
    ghost, real, shown = headset.probe(
        "[it.room.ghosts[1].visible, [...it.inputs[1].poses], [...it.displacement.displayed[1]]]"
    )
    assert ghost
    assert np.abs(np.subtract(real, shown)).max() > 5e-3  # there is something to be compared
    headset.poke("Hide real")
    assert headset.probe("it.room.ghosts[1].visible") is False

    # half a metre aside, the card is out of reach; after Recentre it is where it was from there
    before = headset.probe("it.room.panel.position.toArray()")
    aside = head + np.array([0.5, 0.0, 0.0])
    move_head(headset, aside)
    person.rest(0.2)
    headset.poke("Recentre")
    moved = np.subtract(headset.probe("it.room.panel.position.toArray()"), before)
    np.testing.assert_allclose(moved, aside - head, atol=1e-3)
    # and the play volume is about the new place: 0.5 m farther on is within it, 0.7 m is not
    for further, outside in ((0.5, []), (0.7, ["outside"])):
        move_head(headset, aside + np.array([further, 0.0, 0.0]))
        person.rest(0.2)
        assert headset.probe("[...it.session.pauses]") == outside
    move_head(headset, aside)
    person.rest(0.2)

    headset.poke_last("Leave")
    headset.page.evaluate("headset.giveClockBack()")
    headset.page.wait_for_selector("#enter-xr:enabled")
    assert headset.page.evaluate("window.touchwarpProbe") is None
    headset.enter()
    assert headset.probe("it.session.phase") == "calibrate"


def move_head(headset: Headset, place: np.ndarray) -> None:
    headset.page.evaluate("(at) => headset.device.position.set(...at)", place.tolist())


def point(headset: Headset, at: str, distance: float = 0.4, side: str = "right") -> None:
    """Point with a hand at a place of the card, given in JavaScript, from before it."""
    place = np.array(headset.probe(f"it.room.panel.localToWorld({at}).toArray()"))
    out = np.array(headset.probe("it.room.panel.getWorldDirection(it.head.clone()).toArray()"))
    turn = Rotation.align_vectors([-out], [[0.0, 0.0, -1.0]])[0].as_quat()
    headset.page.evaluate(
        "([side, at, turn]) => { const ray = headset.device.hands[side];"
        " ray.position.set(...at); ray.quaternion.set(...turn); }",
        [side, (place + distance * out).tolist(), turn.tolist()],
    )
    headset.wait(0.1)


def close(headset: Headset, side: str, closed: int) -> None:
    """Begin a pinch or end it, as the headset tells it."""
    headset.page.evaluate(f"headset.device.hands.{side}.updatePinchValue({closed})")


def pinch(headset: Headset) -> None:
    """Briefly."""
    for closed in (1, 0):
        close(headset, "right", closed)
        headset.wait(0.1)


def test_the_card_is_worked_from_afar_by_pointing_and_pinching(enter: Enter) -> None:
    headset = enter().headset
    headset.wait(0.2)
    button = "it.room.panel.middleOf({!r}).clone()".format
    assert headset.probe("it.way") == "rub"
    point(headset, button("By places"))
    assert headset.probe("it.way") == "rub"  # pointing alone does nothing
    pinch(headset)
    assert headset.probe("it.way") == "places"
    # beside the card, on it beside its buttons, and from behind nothing is worked
    for place, distance in (
        (f"{button('By rubbing')}.setX(0.2)", 0.4),
        (f"{button('By rubbing')}.setY(0.05)", 0.4),
        (button("By rubbing"), -0.4),
    ):
        point(headset, place, distance)
        pinch(headset)
        assert headset.probe("[it.way, it.session.pauses.size]") == ["places", 0]
    point(headset, button("By rubbing"))
    pinch(headset)
    assert headset.probe("it.way") == "rub"


def test_a_pinch_is_either_a_stroke_or_works_the_card(enter: Enter) -> None:
    person = enter()
    headset = person.headset
    headset.wait(0.2)
    closed, opened = headset.pinching("left", AWAY), headset.open_hand("left", AWAY)

    def pinch_while_touching(label: str, frames: int) -> None:
        """The left hand points at a button all the time, the right index finger rubs the mug."""
        turn = np.linspace(-2.6, 2.6, frames)
        ring = [0.2 * np.cos(turn), 0.2 * np.sin(turn), np.full(frames, 0.05)]
        hands = person.touching(np.transpose(ring))
        point(headset, f"it.room.panel.middleOf({label!r}).clone()", side="left")
        close(headset, "left", 1)
        headset.step([{"left": closed, "right": hand} for hand in hands])
        close(headset, "left", 0)
        headset.step([{"left": opened, "right": hands[-1]}] * 3)
        headset.settle()

    counts = "[it.calibrator.strokes, it.calibrator.strokeLength]"
    pinch_while_touching("Leave", 100)
    assert headset.probe("it.session.phase") == "calibrate"
    assert headset.probe(counts) == [1, 0]
    pinch_while_touching("By places", 20)
    assert headset.probe("it.way") == "places"
    assert headset.probe(counts) == [1, 0]


CONTACTS = "it.displacement.watch.audit.contacts"


def creep(person: Person) -> None:
    """A fingertip comes to the prop too slowly for its stop to tell of a contact."""
    away = person.prop.T_room_scene[:3, :3] @ np.array([0.0, 1.0, 0.0])
    touching = person.touching(np.array([0.0, 0.2, 0.06]))[0]
    gaps = [0.015] * 50 + np.linspace(0.015, 0.0, 60).tolist() + [0.0] * 30
    frames = []
    for gap in gaps:
        hand = touching.copy()
        hand[:, :3, 3] += gap * away
        frames.append({"right": hand, "left": person.headset.open_hand("left", AWAY)})
    person.headset.step(frames)
    person.headset.step(frames[-1:])


@pytest.mark.parametrize("late", [0.0, 0.3])
def test_an_outside_signal_tells_of_a_contact(enter: Enter, late: float) -> None:
    """Of the finger that is there, but not of one that comes later."""
    person = enter()
    headset = person.headset
    person.arrive()
    if late:
        headset.probe("it.displacement.watch.signal(performance.now() / 1e3)")
        person.rest(late)
    creep(person)
    assert headset.probe(f"{CONTACTS}.length") == 0
    if late:
        return
    headset.probe("it.displacement.watch.signal(performance.now() / 1e3)")
    headset.step([{}] * 30)
    (contact,) = headset.probe(CONTACTS)
    assert (contact["signal"], contact["hand"], contact["finger"]) == ("outside", 1, 1)
    assert abs(contact["gap"]) < 1e-3
    assert contact["latency"] == 0
