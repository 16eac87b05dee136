"""Reading displacement textures: OpenEXR and PNG images, x, y, z in red, green, blue."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import SceneError


def read_texture(path: str | Path, scale: float | None = None) -> NDArray[np.float64]:
    """A displacement texture (h, w, 3) m, the top row first."""
    raise SceneError(f"{path}: textures cannot be read yet.")
