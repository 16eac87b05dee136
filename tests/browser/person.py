"""A person with a real prop: rubs it, verifies it, touches it."""

from __future__ import annotations

import igl
import numpy as np
from numpy.typing import NDArray

import touchwarp as tw
from tests.browser.headset import RADIUS, Hand, Headset

Points = NDArray[np.float64]

AWAY = np.array([-0.25, 0.95, -0.05])
"""Where the left hand is while it touches nothing, room frame; the right one mirrored."""

REST = AWAY * [-1, 1, 1]


class RealProp:
    """A prop of a scene that the person touches, somewhere in the room.

    Args:
        prop: a mug, as the scene has it.
        origin: the middle of its foot, scene frame.
        yaw_deg, place: where the scene stands, as far as this prop is concerned.
    """

    def __init__(
        self,
        prop: tw.Prop,
        origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
        yaw_deg: float = 40.0,
        place: tuple[float, float, float] = (0.04, 0.74, -0.12),
    ) -> None:
        self.vertices, self.faces = prop.surface.vertices, prop.surface.faces
        self.origin = np.array(origin)
        yaw = np.radians(yaw_deg)
        upright = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])  # z up to y up
        turn = np.array([[np.cos(yaw), 0, np.sin(yaw)], [0, 1, 0], [-np.sin(yaw), 0, np.cos(yaw)]])
        self.T_room_scene = np.eye(4)
        self.T_room_scene[:3, :3] = turn @ upright
        self.T_room_scene[:3, 3] = place

    def to_room(self, points: Points) -> Points:
        return points @ self.T_room_scene[:3, :3].T + self.T_room_scene[:3, 3]

    def to_scene(self, points: Points) -> Points:
        return (points - self.T_room_scene[:3, 3]) @ self.T_room_scene[:3, :3]

    def touch(self, aims: Points) -> tuple[Points, Points]:
        """Centres of fingertips that touch nearest to places, and the ways out; scene frame."""
        _, _, feet = igl.point_mesh_squared_distance(aims, self.vertices, self.faces)[:3]
        out = aims - feet
        out /= np.linalg.norm(out, axis=1, keepdims=True)
        return feet + RADIUS * out, out

    def distance(self, points: Points, T: Points | None = None) -> Points:
        """Distance of points of the scene from the prop, or from its image under a goal."""
        vertices = self.vertices if T is None else self.vertices @ T[:3, :3].T + T[:3, 3]
        squared = igl.point_mesh_squared_distance(points, vertices, self.faces)[0]
        return np.sqrt(squared)


def touchable(prop: RealProp, count: int, seed: int) -> Points:
    """Places of a mug where a fingertip fits, above the table, outside its handle's ring."""
    rng = np.random.default_rng(seed)
    found: list[Points] = []
    while len(found) < count:
        angle = rng.uniform(-np.pi, np.pi)
        height = rng.uniform(0.02, 0.13)
        aim = np.array([0.11 * np.cos(angle), 0.11 * np.sin(angle), height])
        tips, _ = prop.touch(prop.origin + aim[None])
        if prop.distance(tips)[0] > RADIUS - 1e-4 and tips[0, 2] > 0.016:
            found.append(aim)
    return np.array(found)


class Person:
    """Rubs, verifies and touches with the right hand's index finger; the left one pinches.

    Args:
        headset: worn.
        prop: the one that is touched.
        noise: m, of tracking, one sigma per axis and frame.
    """

    def __init__(self, headset: Headset, prop: RealProp, noise: float = 0.0) -> None:
        self.headset = headset
        self.prop = prop
        self.noise = noise
        self._random = np.random.default_rng(5)

    def touching(self, aims: Points, side: str = "right", finger: int = 1) -> list[Hand]:
        """Hands whose fingertip touches the prop nearest to places, seen from its foot."""
        tips, out = self.prop.touch(self.prop.origin + np.atleast_2d(aims))
        inward = -out @ self.prop.T_room_scene[:3, :3].T
        centres = self.prop.to_room(tips) + self._random.normal(0.0, self.noise, tips.shape)
        pairs = zip(centres, inward, strict=True)
        return [self.headset.hand_at(side, *pair, finger) for pair in pairs]

    def stroke(self, hands: list[Hand]) -> None:
        """One stroke over the prop: pinch, slide, let go."""
        closed = self.headset.pinching("left", AWAY)
        frames = [{"left": closed, "right": hand} for hand in hands]
        opened = {"left": self.headset.open_hand("left", AWAY), "right": hands[-1]}
        self.headset.step([*frames, opened, opened])
        self.headset.settle()
        self.headset.step([opened])

    def rub(self) -> None:
        """A mug: around the outside at three heights, over the rim, along the handle."""
        turn = np.linspace(-2.6, 2.6, 100)
        for height in (0.025, 0.05, 0.075):
            ring = [0.2 * np.cos(turn), 0.2 * np.sin(turn), np.full(100, height)]
            self.stroke(self.touching(np.transpose(ring)))
        rim = [0.042 * np.cos(turn), 0.042 * np.sin(turn), np.full(100, 0.13)]
        self.stroke(self.touching(np.transpose(rim)))
        for y in (0.03, -0.03):
            arc = np.linspace(-1.2, 1.2, 100)
            handle = [0.055 + 0.03 * np.cos(arc), np.full(100, y), 0.048 + 0.05 * np.sin(arc)]
            self.stroke(self.touching(np.transpose(handle)))

    def touch_places(self, most: int = 14) -> None:
        """The places that the model shows, one after another, each for half a second.

        On the way to the next one tracking forgets how it was off.
        """
        for _ in range(most):
            if self.headset.probe("it.session.phase") != "calibrate":
                return
            place = self.headset.probe(
                "[it.calibrator.place.point.toArray(), it.calibrator.place.normal.toArray()]"
            )
            aim = np.array(place[0]) + 0.002 * np.array(place[1])
            self.stroke(self.touching(np.tile(aim - self.prop.origin, (36, 1))))
            self.rest(1.5)

    def verify(self) -> None:
        """Five fresh touches."""
        for angle in (0.6, 1.9, 3.1, -1.9, -0.6):
            place = np.array([0.2 * np.cos(angle), 0.2 * np.sin(angle), 0.06])
            self.stroke(self.touching(np.tile(place, (30, 1))))

    def rest(self, seconds: float) -> None:
        """Hands off; time passes."""
        self.headset.wait(seconds, right=self.headset.open_hand("right", REST))

    def arrive(self) -> None:
        """All that comes before touching."""
        self.rub()
        assert self.headset.probe("it.session.phase") == "verify"
        self.verify()
        assert self.headset.probe("it.session.phase") == "immersed"
        self.headset.await_warp()
        self.rest(2.0)
        assert self.headset.probe("it.displacement.weight") == 1
