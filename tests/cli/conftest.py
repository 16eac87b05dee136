"""A ball that shall be felt beside itself, as files: its scene, and a warp in closed form."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.exact.sample_bricks import near_sphere, sample_bricks
from tests.exact.spheres import SphereWarp
from touchwarp.goals import goals
from touchwarp.scene import load_scene
from touchwarp.warp.meta import Outline, WarpMeta
from touchwarp.warp.table import TableWarp

SHIFT = (0.01, 0.0, 0.0)

SCENE = """
[objective]
tolerance_mm = 1.0

[outer]
box = { min = [-0.2, -0.2, -0.2], max = [0.2, 0.2, 0.2] }

[[prop]]
name = "ball"
shape = { kind = "ellipsoid", size = [0.1, 0.1, 0.1] }

[prop.goal]
kind = "transform"
translation = [0.01, 0, 0]
"""


@pytest.fixture
def ball_scene(tmp_path: Path) -> Path:
    """The scene file."""
    path = tmp_path / "ball.toml"
    path.write_text(SCENE)
    return path


@pytest.fixture(scope="session")
def ball_exact() -> SphereWarp:
    """The warp that the table samples."""
    return SphereWarp(radius=0.05, outer_radius=0.2, shift=np.array(SHIFT))


@pytest.fixture(scope="session")
def ball_table(ball_exact: SphereWarp, tmp_path_factory: pytest.TempPathFactory) -> TableWarp:
    """A table of it that belongs to the scene."""
    path = tmp_path_factory.mktemp("ball") / "ball.toml"
    path.write_text(SCENE)
    scene = load_scene(path)
    box = np.array([[-0.2] * 3, [0.2] * 3])
    bricks = sample_bricks(
        ball_exact.displacement, *box, depth=2, refine=near_sphere(np.zeros(3), 0.05)
    )
    (goal,) = goals(scene).values()
    assert goal.matrix is not None
    prop = scene.props[0].surface
    meta = WarpMeta(
        scene_text=scene.text,
        mesh_digests=scene.digests,
        outlines={"ball": Outline(prop, prop.transformed(goal.matrix))},
        outer_box=box,
        tolerance_mm=1.0,
        estimated_error_max_mm=0.5,
        estimated_error_rms_mm=0.1,
        prop_names=("ball",),
        goals={"ball": goal.matrix},
    )
    return TableWarp(bricks, meta)


@pytest.fixture
def ball_warp(ball_table: TableWarp, tmp_path: Path) -> Path:
    """The warp file."""
    path = tmp_path / "ball.warp"
    ball_table.save(path)
    return path
