"""Draw the pictures of README.md and docs/ anew, from the demo's own scene: `make pictures`."""

from __future__ import annotations

import tempfile
from pathlib import Path

import touchwarp as tw
from touchwarp.cli.demo_files import write_input
from touchwarp.cli.demo_picture import draw

HERE = Path(__file__).resolve().parent


def main() -> None:
    """Solve the demo's mug and draw it."""
    with tempfile.TemporaryDirectory() as name:
        write_input(Path(name))
        scene = tw.load_scene(Path(name) / "mug.toml")
        warp = tw.solve(scene)
        assert isinstance(warp, tw.TableWarp)
        draw(scene, warp, HERE / "mug_as_cup.png")


if __name__ == "__main__":
    main()
