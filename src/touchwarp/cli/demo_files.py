"""The demo's input: the mug's mesh, a scene for each goal, a hand that reaches for the mug."""

from __future__ import annotations

from pathlib import Path

from touchwarp.outputs import replacing

SCENE = """\
# {title}
# Solve and check it:
#   touchwarp solve {name}.toml -o {name}.warp
#   touchwarp check {name}.toml {name}.warp --html {name}.html
# docs/scene-file.md explains every key.

[objective]
mismatch_weight = 0.0    # λ; try 10: the displacement stays nearer the mug
tolerance_mm = {tolerance_mm}

[[prop]]
name = "mug"
mesh = "mug.stl"         # the real mug: 80 mm wide, 95 mm tall, its handle in +x
unit = "mm"

[prop.goal]
kind = "transform"       # the cup is the mug, widened, lowered and moved
pivot = "base"
scale = [1.2, 1.2, 0.6]
rotation_deg = {rotation_deg}
translation = {translation}

[[fixed]]
name = "table"           # a hand that lies on the table is shown lying on it
plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }}
contact = "slide"
"""


def write_input(folder: Path, tolerance_mm: float = 0.1) -> None:
    """Write mug.stl, mug.toml, turned.toml and hand.csv.

    Args:
        folder: an existing one.
        tolerance_mm: goes into the scenes.

    Raises:
        OutputError: the folder cannot be written to.
    """
    with replacing(folder / "mug.stl") as temporary:
        temporary.write_bytes(mug_stl())
    texts = {
        "mug.toml": SCENE.format(
            title="A coffee mug on a table, felt as a wide tea cup.",
            name="mug",
            tolerance_mm=tolerance_mm,
            rotation_deg="[0, 0, 0]",
            translation="[0.015, 0, 0]",
        ),
        "turned.toml": SCENE.format(
            title="The same mug, felt as the same cup, which stands elsewhere and is turned.",
            name="turned",
            tolerance_mm=tolerance_mm,
            rotation_deg="[0, 0, 35]",
            translation="[-0.01, 0.03, 0]",
        ),
        "hand.csv": reach_csv(),
    }
    for name, text in texts.items():
        with replacing(folder / name) as temporary:
            temporary.write_text(text, encoding="utf-8")


def mug_stl() -> bytes:
    """The library's mug as a binary STL file in mm, such as a scanner or CAD program writes."""
    import numpy as np

    from touchwarp.scene.vessels import mug

    surface = mug()
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("spare", "<u2")])
    facets = np.zeros(len(surface.faces), dtype=record)
    facets["corners"] = surface.vertices[surface.faces] * 1e3
    return b"a mug, mm".ljust(80) + np.uint32(len(facets)).tobytes() + facets.tobytes()


def reach_csv() -> str:
    """A fingertip that comes from 15 cm away to the mug's wall opposite the handle, x,y,z in m.

    One sample in the middle is lost (nan), as happens with real trackers.
    """
    rows = ["time_s,x,y,z"]
    for i in range(21):
        if i == 10:
            rows.append(f"{i / 20:.2f},nan,nan,nan")
            continue
        left = 1 - i / 20
        rows.append(
            f"{i / 20:.2f},{-0.04 - 0.15 * left:.5f},{0.03 * left:.5f},{0.05 + 0.04 * left:.5f}"
        )
    return "\n".join(rows) + "\n"
