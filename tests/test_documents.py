"""What README.md and docs/ show is true of the code."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.hand.hands import make_hand
from touchwarp.cli.demo_files import write_input
from touchwarp.cli.main import main, touchwarp
from touchwarp.scene.goal_spec import GOAL_SPECS
from touchwarp.scene.interaction import MODES, TRACKING_PRESETS, Tracking
from touchwarp.scene.objective import Objective
from touchwarp.scene.scene import CONTACTS
from touchwarp.scene.shapes import SHAPES
from touchwarp.scene.units import METRES
from touchwarp.warp import load_warp

CHECKOUT = Path(__file__).resolve().parent.parent
README = (CHECKOUT / "README.md").read_text(encoding="utf-8")
DOCUMENTS = [
    CHECKOUT / "README.md",
    CHECKOUT / "CONTRIBUTING.md",
    CHECKOUT / "examples" / "README.md",
    *sorted((CHECKOUT / "docs").glob("*.md")),
]


def block(language: str, text: str = README) -> str:
    """The only code block in a language, of the README or another document."""
    (found,) = re.findall(rf"```{language}\n(.*?)```", text, flags=re.DOTALL)
    return str(found)


@pytest.fixture
def mug_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the mug's mesh and the README's scene, coarsely solved."""
    write_input(tmp_path)
    (tmp_path / "mug.toml").write_text(block("toml") + "\n[objective]\ntolerance_mm = 2\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_readme_s_scene_commands_and_code_work(mug_folder: Path) -> None:
    commands = re.findall(r"^    touchwarp (.*)$", README, flags=re.MULTILINE)
    assert [command.split()[0] for command in commands] == ["solve", "check"]
    for command in commands:
        assert main(command.split()) == 0
    assert (mug_folder / "mug.html").exists()

    palms = np.array([[[-0.1, 0.0, 0.06]], [[0.12, 0.0, 0.06]]])
    hands = palms + np.random.default_rng(0).uniform(-0.03, 0.03, (2, 26, 3))
    hands[0, 3] = np.nan
    names: dict[str, np.ndarray] = {"hands": hands}
    exec(block("python"), names)
    assert np.isnan(names["shown"][0, 3]).all()
    assert np.nanmax(np.abs(names["shown"] - hands)) > 5e-3
    assert names["real"].shape == hands.shape


def test_the_library_s_page_solves_the_segment_of_eq_9() -> None:
    """As it says: u = 20 mm · sinh(s (0.3 m − x)) / sinh(s · 0.3 m), s = 10 m⁻¹."""
    text = (CHECKOUT / "docs" / "python.md").read_text(encoding="utf-8")
    names: dict[str, np.ndarray] = {}
    exec(block("python", text), names)

    def exact(x: np.ndarray) -> np.ndarray:
        return np.asarray(0.02 * np.sinh(10 * (0.3 - x)) / np.sinh(3))

    told = re.search(r"in closed form: (.*) m$", text, flags=re.MULTILINE)
    assert told is not None
    places = np.array([0.0, 0.05, 0.3])
    np.testing.assert_allclose(names["u"], exact(places), atol=1e-12)
    np.testing.assert_allclose([float(n) for n in told[1].split(",")], exact(places), atol=5e-5)
    np.testing.assert_allclose(names["u_nodes"], exact(names["nodes"]), atol=1e-6)


def test_the_page_on_hands_runs() -> None:
    """One block after the other, as they stand, on a hand beside a ball."""
    text = (CHECKOUT / "docs" / "hands.md").read_text(encoding="utf-8")
    names: dict[str, Any] = {
        "warp": load_warp(CHECKOUT / "tests" / "vectors" / "levels.warp"),
        "poses": make_hand(),
        "time": 0.0,
        "radii": np.full(25, 0.008),
        "T_room_scene": np.eye(4),
    }
    blocks = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)
    assert len(blocks) == 2
    for code in blocks:
        exec(code, names)
        assert names["shown"].shape == (25, 4, 4)
    assert names["carried"].valid


def test_every_command_is_told_of() -> None:
    text = (CHECKOUT / "docs" / "index.md").read_text(encoding="utf-8")
    assert [name for name in touchwarp.commands if f"`{name}`" not in text] == []


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.name)
def test_links_lead_to_files(path: Path) -> None:
    links = re.findall(r"\]\(([^)#:]+)\)", path.read_text(encoding="utf-8"))
    assert [link for link in links if not (path.parent / link).exists()] == []


def test_the_scene_file_s_words_are_all_explained() -> None:
    text = (CHECKOUT / "docs" / "scene-file.md").read_text(encoding="utf-8")
    words = {
        *(field.name for field in fields(Objective)),
        *(key for spec in GOAL_SPECS.values() for key in spec.keys),
        *(field.name for field in fields(Tracking) if field.name != "name"),
        *MODES,
        *CONTACTS,
        *TRACKING_PRESETS,
        *SHAPES,
        *METRES,
        *GOAL_SPECS,
    }
    assert [word for word in sorted(words) if not re.search(rf"\b{word}\b", text)] == []
