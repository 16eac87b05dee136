"""Displacement textures come in as metres, from either format, and say what is wrong with them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenEXR
import png
import pytest

from touchwarp.errors import SceneError
from touchwarp.scene.texture_file import read_texture

IMAGE = np.array([[[1, 2, 3], [-4, 5, 6]], [[7, 8, -9], [0, 0, 0]], [[1, 1, 1], [2, 2, 2]]])


def write_exr(path: Path, channels: dict[str, np.ndarray]) -> Path:
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, channels) as file:
        file.write(str(path))
    return path


def write_png(path: Path, numbers: np.ndarray, bits: int = 16, grey: bool = False) -> Path:
    height, width = numbers.shape[:2]
    with path.open("wb") as file:
        png.Writer(width, height, greyscale=grey, bitdepth=bits).write(
            file, numbers.reshape(height, -1).astype(f"u{bits // 8}")
        )
    return path


@pytest.mark.parametrize("dtype", [np.float32, np.float16])
def test_an_exr_is_in_metres_unless_scaled(tmp_path: Path, dtype: type) -> None:
    path = write_exr(tmp_path / "a.exr", {"RGB": IMAGE.astype(dtype)})
    np.testing.assert_array_equal(read_texture(path), IMAGE)
    np.testing.assert_allclose(read_texture(path, 1e-3), IMAGE * 1e-3)


def test_an_exr_may_have_more_channels(tmp_path: Path) -> None:
    rgba = np.concatenate([IMAGE, np.ones((3, 2, 1))], axis=2).astype(np.float32)
    np.testing.assert_array_equal(
        read_texture(write_exr(tmp_path / "a.exr", {"RGBA": rgba})), IMAGE
    )


@pytest.mark.parametrize("bits", [8, 16])
def test_a_png_s_numbers_are_shares_of_its_scale(tmp_path: Path, bits: int) -> None:
    half = 2 ** (bits - 1)
    numbers = np.array([[[half, 1, 2 * half - 1]]], dtype=np.uint16)
    path = write_png(tmp_path / "a.png", numbers, bits)
    np.testing.assert_allclose(read_texture(path, 0.02), [[[0, -0.02, 0.02]]], atol=1e-17)


def test_what_is_wrong_is_told(tmp_path: Path) -> None:
    (tmp_path / "a.jpg").write_bytes(b"x")
    with pytest.raises(SceneError, match=r"a.jpg has the ending '.jpg'; a displacement texture is"):
        read_texture(tmp_path / "a.jpg")
    with pytest.raises(SceneError, match=r"texture .*b.exr does not exist; check the name"):
        read_texture(tmp_path / "b.exr")
    for name in ("c.exr", "c.png"):
        (tmp_path / name).write_bytes(b"no image at all")
        with pytest.raises(SceneError, match=rf"{name}: it cannot be read as .*; save it again"):
            read_texture(tmp_path / name)
    grey = write_exr(tmp_path / "y.exr", {"Y": np.zeros((2, 2), dtype=np.float32)})
    with pytest.raises(SceneError, match=r"y.exr: its channels are Y; R, G and B are needed"):
        read_texture(grey)
    grey = write_png(tmp_path / "g.png", np.zeros((2, 2), dtype=np.uint16), grey=True)
    with pytest.raises(SceneError, match=r"g.png: it is a grey image; red, green and blue"):
        read_texture(grey, 1.0)
    silent = write_png(tmp_path / "s.png", np.zeros((2, 2, 3), dtype=np.uint16))
    with pytest.raises(SceneError, match=r"s.png: it does not tell its scale; write texture_scale"):
        read_texture(silent)
    with pytest.raises(SceneError, match="the texture's scale is -1 m; a finite number > 0"):
        read_texture(silent, -1)


def test_a_cut_off_png_is_told(tmp_path: Path) -> None:
    path = write_png(tmp_path / "a.png", np.zeros((64, 64, 3), dtype=np.uint16))
    path.write_bytes(path.read_bytes()[:60])
    with pytest.raises(SceneError, match=r"a.png: it cannot be read as PNG"):
        read_texture(path, 1.0)
