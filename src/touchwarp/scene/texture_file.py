"""Reading displacement textures: x, y, z in red, green, blue of an OpenEXR or PNG image.

An EXR's numbers are metres, or multiples of the scale that is given. A PNG's number n of b bits
stands for (n − 2ᵇ⁻¹) / (2ᵇ⁻¹ − 1) of its scale, so that no displacement is exactly 2ᵇ⁻¹; the scale
is told by the scene file, or by the image's own text `Displacement scale`, in metres.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import SceneError
from touchwarp.scene.table import within

FORMATS = (".exr", ".png")
SCALE_KEYWORD = "Displacement scale"


def read_texture(path: str | Path, scale: float | None = None) -> NDArray[np.float64]:
    """A displacement texture (h, w, 3) m, the top row first.

    Args:
        path: an OpenEXR or PNG file with red, green and blue.
        scale: m: what 1 stands for in an EXR (1 where it is None), and the greatest number in a
            PNG (where it is None, the image itself must tell).

    Raises:
        SceneError: the file is missing, of another format, unreadable, or tells no scale.
    """
    path = Path(path)
    if path.suffix.lower() not in FORMATS:
        raise SceneError(
            f"{path.name} has the ending '{path.suffix}'; a displacement texture is an image in "
            "32-bit OpenEXR (.exr) or 16-bit PNG (.png)."
        )
    if not path.is_file():
        raise SceneError(f"texture {path} does not exist; check the name and folder.")
    if scale is not None and not (math.isfinite(scale) and scale > 0):
        raise SceneError(f"the texture's scale is {scale} m; a finite number > 0 is needed.")
    with within(path.name):
        return _read_exr(path, scale) if path.suffix.lower() == ".exr" else _read_png(path, scale)


def _read_exr(path: Path, scale: float | None) -> NDArray[np.float64]:
    import OpenEXR

    try:
        with OpenEXR.File(str(path), separate_channels=True) as file:
            channels = {name: np.asarray(c.pixels) for name, c in file.channels().items()}
    except Exception as error:  # the binding raises whatever the library meets
        raise SceneError(f"it cannot be read as OpenEXR ({error}); save it again.") from error
    missing = [name for name in "RGB" if name not in channels]
    if missing:
        raise SceneError(
            f"its channels are {', '.join(sorted(channels))}; R, G and B are needed: the "
            "displacement's x, y and z."
        )
    image = np.stack([channels[name] for name in "RGB"], axis=-1).astype(np.float64)
    return image if scale is None else image * scale


def _read_png(path: Path, scale: float | None) -> NDArray[np.float64]:
    import png

    data = path.read_bytes()
    try:
        texts = {}
        for kind, content in png.Reader(bytes=data).chunks():
            if kind == b"tEXt":
                keyword, _, text = content.decode("latin-1").partition("\0")
                texts[keyword] = text
        width, height, rows, facts = png.Reader(bytes=data).asDirect()
        numbers = np.stack([np.asarray(row, dtype=np.float64) for row in rows])
    except (png.Error, ValueError, EOFError) as error:
        raise SceneError(f"it cannot be read as PNG ({error}); save it again.") from error
    if facts["greyscale"]:
        raise SceneError("it is a grey image; red, green and blue are needed: x, y and z.")
    if scale is None:
        scale = _told_scale(texts)
    half = 2 ** (facts["bitdepth"] - 1)
    image = numbers.reshape(height, width, facts["planes"])[..., :3]
    return np.asarray((image - half) / (half - 1) * scale)


def _told_scale(texts: dict[str, str]) -> float:
    try:
        scale = float(texts[SCALE_KEYWORD])
    except (KeyError, ValueError):
        scale = math.nan
    if not (math.isfinite(scale) and scale > 0):
        raise SceneError(
            "it does not tell its scale; write texture_scale = the displacement in metres that "
            "the greatest number stands for."
        )
    return scale
