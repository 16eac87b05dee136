"""Displacement textures as image files; `touchwarp.scene.texture_file` reads them."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.outputs import replacing
from touchwarp.scene.texture_file import SCALE_KEYWORD

_HALF = 2**15


def write_exr(path: str | Path, displacement: NDArray[np.float32]) -> None:
    """Write a displacement texture (h, w, 3) m as OpenEXR: 32-bit red, green, blue in metres."""
    import OpenEXR

    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "comments": "displacement in metres: x, y, z of a z-up right-handed frame in R, G, B",
    }
    pixels = np.ascontiguousarray(displacement, dtype=np.float32)
    with replacing(Path(path)) as temporary, OpenEXR.File(header, {"RGB": pixels}) as file:
        file.write(str(temporary))


def write_png(
    path: str | Path, displacement: NDArray[np.float32], scale: float | None = None
) -> float:
    """Write a displacement texture (h, w, 3) m as 16-bit PNG, its scale told as a text.

    Args:
        path: of the file.
        displacement: (h, w, 3) m.
        scale: m that the greatest number stands for; by default the greatest component there is.

    Returns:
        The quantisation step, m; no component is off by more than half of it.

    Raises:
        GoalError: a component is greater than the scale.
    """
    import png

    greatest = float(np.abs(displacement).max())
    if scale is None:
        scale = greatest or 1e-3
    if greatest > scale:
        raise GoalError(
            f"the texture displaces by up to {greatest * 1e3:.4g} mm along an axis, more than the "
            f"scale of {scale * 1e3:.4g} mm can tell; give a larger scale."
        )
    numbers = np.rint(np.asarray(displacement, dtype=np.float64) / scale * (_HALF - 1)) + _HALF
    height, width, _ = numbers.shape
    plain = io.BytesIO()
    writer = png.Writer(width, height, greyscale=False, bitdepth=16)
    writer.write(plain, numbers.astype(np.uint16).reshape(height, -1))
    plain.seek(0)
    chunks = list(png.Reader(file=plain).chunks())
    text = f"{SCALE_KEYWORD}\0{scale!r}".encode("latin-1")
    with replacing(Path(path)) as temporary, temporary.open("wb") as file:
        png.write_chunks(file, [chunks[0], (b"tEXt", text), *chunks[1:]])
    return scale / (_HALF - 1)
