"""What docs/goals.md shows can be read and run."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from touchwarp.export import write_goal
from touchwarp.goals import Goal
from touchwarp.scene import Surface, parse_scene
from touchwarp.scene.goal_spec import GOAL_SPECS
from touchwarp.scene.shapes import box, sphere

DOCUMENT = (Path(__file__).parents[2] / "docs" / "goals.md").read_text(encoding="utf-8")
SNIPPETS = re.findall(r"```toml\n(.*?)```", DOCUMENT, flags=re.DOTALL)
CUBE = box((0.1, 0.1, 0.1))
PROP = '[[prop]]\nname = "cube"\nshape = { kind = "box", size = [0.1, 0.1, 0.1] }\n'


def in_mm(surface: Surface, path: Path) -> None:
    trimesh.Trimesh(surface.vertices * 1e3, surface.faces, process=False).export(path)


@pytest.mark.parametrize("snippet", SNIPPETS, ids=range(len(SNIPPETS)))
def test_its_snippets_are_scenes(snippet: str, tmp_path: Path) -> None:
    if not snippet.startswith("[prop.goal]"):
        box_again = 'virtual_shape = { kind = "box", size = [0.1, 0.1, 0.1] }\n'
        snippet = f'[prop.goal]\nkind = "plane_projection"\n{box_again}{snippet}'
    for name in ("cup.obj", "mug_deformed.obj"):
        in_mm(CUBE, tmp_path / name)
    write_goal(tmp_path / "mug.exr", Goal(CUBE.vertices, 2 * CUBE.vertices, CUBE.faces), size=64)
    scene = parse_scene(PROP + snippet, tmp_path)
    assert f'kind = "{scene.props[0].goal.kind}"' in snippet  # type: ignore[union-attr]


def test_its_python_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", DOCUMENT, flags=re.DOTALL)
    in_mm(sphere(0.03, facet_mm=1.0), tmp_path / "ball.stl")
    in_mm(box((0.05, 0.05, 0.05)), tmp_path / "die.stl")
    monkeypatch.chdir(tmp_path)
    before_solving = code[: code.index("warp = tw.solve")]
    names: dict[str, Any] = {}
    exec(before_solving, names)
    assert np.abs(names["goal"].virtual_points).max() == pytest.approx(0.025, abs=1e-6)
    assert (tmp_path / "ball.glb").exists()


def test_it_tells_of_every_kind_and_key() -> None:
    told = [kind for kind in GOAL_SPECS if not re.search(rf"^\| `{kind}` \|", DOCUMENT, re.M)]
    assert told == []
    for kind, spec in GOAL_SPECS.items():
        if kind != "transform":  # its keys are in scene-file.md alone
            assert [key for key in spec.keys if not re.search(rf"\b{key}\b", DOCUMENT)] == []


def test_its_defaults_are_the_code_s() -> None:
    for key, default in re.findall(r"^\| `(\w+)` \| ([\d.]+) \|", DOCUMENT, flags=re.M):
        own = [getattr(s, key) for s in GOAL_SPECS.values() if key in s.keys and hasattr(s, key)]
        assert float(default) in own, key
