"""Points and directions as messages spell them."""

from __future__ import annotations

from typing import Any

import numpy as np


def spell_point(point: Any) -> str:
    """A point (3,) m, as in (12.5, 0, -3) mm."""
    return f"({', '.join(f'{v * 1e3 + 0.0:.4g}' for v in np.asarray(point).tolist())}) mm"


def spell_direction(direction: Any) -> str:
    """A direction (3,), as in (0, 0.707, 0.707)."""
    return f"({', '.join(f'{v + 0.0:.3g}' for v in np.asarray(direction).tolist())})"
