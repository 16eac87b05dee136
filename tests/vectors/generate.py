"""Make the files that every other reader of warps is tested against; see docs/warp-file.md.

    python -m tests.vectors.generate        # from the checkout; writes beside this file

`vectors.safetensors` holds, for each warp: points; u, ∂f and the inverse at them, float64, room
frame. `carried` is `levels` carried to `carried.pose`. `hand.*` are hands, see `hands.py`.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray
from safetensors.numpy import save_file

from tests.vectors.hands import hand_vectors
from tests.vectors.warps import GOALS, HALF, NEAR, POSE, write_warps
from touchwarp.warp.bases import AffineBases
from touchwarp.warp.file import load_warp, read
from touchwarp.warp.plane_table import PlaneTableWarp
from touchwarp.warp.protocol import Warp
from touchwarp.warp.table import TableWarp

FOLDER = Path(__file__).resolve().parent
ASIDE = 1e-6
Arrays = dict[str, NDArray[Any]]


def table_places() -> NDArray[np.float64]:
    """(n, 3) places in a table, as shares of its box: what readers may get wrong."""
    random = np.random.default_rng(7)
    return np.concatenate(
        [
            random.uniform(0.02, 0.98, (10, 3)),
            0.5 + (NEAR + random.normal(0.0, 0.012, (8, 3))) / (2 * HALF),  # the finest level
            # borders: of root cells, of bricks, of levels; and corners of them
            np.array(
                [
                    [0.5, 0.3, 0.7],
                    [0.55, 0.5, 0.625],
                    [0.75, 0.625, 0.6],
                    [0.5, 0.5, 0.5],
                    [0.625, 0.625, 0.625],
                    [0.53125, 0.5625, 0.515625],
                    [0.125, 0.25, 0.375],
                ]
            ),
            # the outer boundary, its upper side too, and beyond it
            np.array([[0.0, 0.4, 0.5], [1.0, 0.4, 0.5], [1.0, 1.0, 1.0]]),
            np.array([[1.001, 0.4, 0.5], [-0.3, 0.5, 0.5], [0.4, 0.4, 7.0]]),
            np.array([[0.5, 0.48, 0.51], [0.46, 0.5, 0.53]]),  # inside the prop
            np.array([[0.3, 0.4, -0.05], [0.6, 0.5, -0.2], [0.6, 0.5, -0.001]]),  # below
            np.array([[np.nan, 0.5, 0.5], [0.5, 0.5, np.nan]]),
        ]
    )


def points_of(warp: Warp) -> NDArray[np.float64]:
    if isinstance(warp, PlaneTableWarp):
        random = np.random.default_rng(8)
        places = random.uniform([-0.3, -0.12], [0.3, 0.35], (40, 2))
        places = np.concatenate([places, [[0.125, 0.05], [0.0, 0.0], [np.nan, 0.1]]])
        T = warp.table.T_scene_table
        return places @ T[:2, :2].T + T[:2, 2]
    bricks = (warp if isinstance(warp, TableWarp) else warp._bases).bricks  # type: ignore[attr-defined]
    width = np.array(bricks.root.shape) * 8 * bricks.spacing
    T = bricks.T_scene_table
    # where the table is turned, rounding would decide on which side of a border a point is
    aside = 0.0 if np.array_equal(T[:3, :3], np.eye(3)) else ASIDE
    return np.asarray((table_places() + aside) * width @ T[:3, :3].T + T[:3, 3])


def vectors_of(name: str, warp: Warp, points: NDArray[np.float64]) -> Arrays:
    return {
        f"{name}.points": points,
        f"{name}.displacement": warp.displacement(points),
        f"{name}.jacobian": warp.jacobian(points),
        f"{name}.inverse": warp.inverse(points).points,
    }


def make_vectors(folder: Path) -> Arrays:
    """The vectors of the warp files in a folder."""
    arrays: Arrays = {}
    for path in sorted(folder.glob("*.warp")):
        loaded = load_warp(path)
        name = path.stem
        if isinstance(loaded, AffineBases):
            for prop, goal in GOALS[name].items():
                arrays[f"{name}.goal.{prop}"] = goal
            warp: Warp = loaded.warp(GOALS[name])
        else:
            warp = loaded
        arrays |= vectors_of(name, warp, points_of(warp))
    carried = load_warp(folder / "levels.warp").at(POSE)  # type: ignore[union-attr]
    points = points_of(carried)
    arrays |= {"carried.pose": POSE} | vectors_of("carried", carried, points)
    return arrays | hand_vectors(folder)


def write_changed_warps(folder: Path) -> None:
    """The warps, but for those that a folder holds already: their headers' order is not fixed."""
    with TemporaryDirectory() as name:
        write_warps(Path(name))
        for path in Path(name).glob("*.warp"):
            kept = folder / path.name
            if not kept.exists() or not same(read(kept), read(path)):
                shutil.copy(path, kept)


def same(a: tuple[dict[str, Any], Any], b: tuple[dict[str, Any], Any]) -> bool:
    return a[0] == b[0] and all(
        a[1].keys() == b[1].keys() and np.array_equal(a[1][name], b[1][name]) for name in a[1]
    )


def main() -> None:
    write_changed_warps(FOLDER)
    arrays = {name: np.ascontiguousarray(array) for name, array in make_vectors(FOLDER).items()}
    save_file(arrays, FOLDER / "vectors.safetensors")
    for path in sorted(FOLDER.iterdir()):
        if path.suffix in (".warp", ".safetensors"):
            print(f"{path.name:24s} {path.stat().st_size / 1e3:7.1f} kB")


if __name__ == "__main__":
    main()
