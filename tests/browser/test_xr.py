"""The headset as a person uses it: enter, rub the mug, verify, and touch what is seen."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import igl
import numpy as np
import pytest
from numpy.typing import NDArray
from playwright.sync_api import Page

import touchwarp as tw
from tests.browser.headset import RADIUS, TIPS, Hand, Headset
from tests.browser.server import Server

Serve = Callable[[Path], Server]
Points = NDArray[np.float64]

SCENE = """\
[objective]
tolerance_mm = 0.5

[[prop]]
name = "mug"
shape = { kind = "mug" }

[prop.goal]
kind = "transform"
scale = [1.2, 1.2, 0.6]
translation = [0.015, 0, 0]

[[fixed]]
name = "table"
plane = { point = [0, 0, 0], normal = [0, 0, 1] }
contact = "slide"
"""


@pytest.fixture(scope="module")
def mug_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("mug-scene")
    path = folder / "mug.toml"
    path.write_text(SCENE)
    tw.solve(tw.load_scene(path)).save(path.with_suffix(".warp"))
    return folder


@pytest.fixture
def mug(mug_folder: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(mug_folder, tmp_path / "scene")) / "mug.toml"


class RealMug:
    """The mug that the person touches, somewhere in the room."""

    def __init__(self, path: Path, yaw_deg: float = 40.0) -> None:
        scene = tw.load_scene(path)
        surface = scene.props[0].surface
        self.vertices, self.faces = surface.vertices, surface.faces
        yaw = np.radians(yaw_deg)
        upright = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])  # z up to y up
        turn = np.array([[np.cos(yaw), 0, np.sin(yaw)], [0, 1, 0], [-np.sin(yaw), 0, np.cos(yaw)]])
        self.T_room_scene = np.eye(4)
        self.T_room_scene[:3, :3] = turn @ upright
        self.T_room_scene[:3, 3] = [0.04, 0.74, -0.12]

    def to_room(self, points: Points) -> Points:
        return points @ self.T_room_scene[:3, :3].T + self.T_room_scene[:3, 3]

    def touch(self, aims: Points) -> tuple[Points, Points]:
        """Centres of fingertips that touch nearest to some places, and the ways out; scene frame."""
        _, faces, feet = igl.point_mesh_squared_distance(aims, self.vertices, self.faces)[:3]
        out = aims - feet
        out /= np.linalg.norm(out, axis=1, keepdims=True)
        return feet + RADIUS * out, out

    def distance(self, points: Points, T: Points | None = None) -> Points:
        """Distance of points of the scene from the mug, or from its image under a goal."""
        vertices = self.vertices if T is None else self.vertices @ T[:3, :3].T + T[:3, 3]
        squared = igl.point_mesh_squared_distance(points, vertices, self.faces)[0]
        return np.sqrt(squared)


AWAY = np.array([-0.25, 0.95, -0.05])


class Person:
    """Rubs, verifies and touches with the right hand's index finger; the left one pinches."""

    def __init__(self, headset: Headset, mug: RealMug) -> None:
        self.headset = headset
        self.mug = mug

    def touching(self, aim: Points, side: str = "right", finger: int = 1) -> Hand:
        """A hand whose fingertip touches the mug nearest to a place of the scene."""
        tips, out = self.mug.touch(np.atleast_2d(aim))
        inward = -self.mug.T_room_scene[:3, :3] @ out[0]
        return self.headset.hand_at(side, self.mug.to_room(tips)[0], inward, finger)

    def stroke(self, aims: Points) -> None:
        """One stroke over the mug: pinch, slide, let go."""
        closed = self.headset.pinching("left", AWAY)
        frames = [{"left": closed, "right": self.touching(aim)} for aim in aims]
        opened = {"left": self.headset.open_hand("left", AWAY), "right": frames[-1]["right"]}
        self.headset.step([*frames, opened, opened])

    def rub(self) -> None:
        """Around the outside at three heights, over the rim, along the handle."""
        turn = np.linspace(-2.6, 2.6, 100)
        for height in (0.025, 0.05, 0.075):
            ring = [0.2 * np.cos(turn), 0.2 * np.sin(turn), np.full(100, height)]
            self.stroke(np.transpose(ring))
        self.stroke(np.transpose([0.042 * np.cos(turn), 0.042 * np.sin(turn), np.full(100, 0.13)]))
        for y in (0.03, -0.03):
            arc = np.linspace(-1.2, 1.2, 100)
            handle = [0.055 + 0.03 * np.cos(arc), np.full(100, y), 0.048 + 0.05 * np.sin(arc)]
            self.stroke(np.transpose(handle))

    def verify(self) -> None:
        """Five fresh touches."""
        turn = np.array([0.6, 1.9, 3.1, -1.9, -0.6])
        for angle in turn:
            place = np.array([0.2 * np.cos(angle), 0.2 * np.sin(angle), 0.06])
            self.stroke(np.repeat(place[None], 30, axis=0))

    def arrive(self) -> None:
        """All that comes before touching."""
        self.rub()
        assert self.headset.probe("it.session.phase") == "verify"
        self.verify()
        assert self.headset.probe("it.session.phase") == "immersed"
        self.headset.wait(2.0, right=self.headset.open_hand("right", -AWAY * [1, -1, 1]))
