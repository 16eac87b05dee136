"""The share of the displacement that is shown, which comes and goes at a bounded rate."""

from __future__ import annotations

import math

LONGEST_STEP = 0.1
"""s: a frame later than that counts as this late, lest the hand jump after a pause."""


class Onset:
    """A weight from 0 to 1 that eases in and out; u itself is never rate-limited.

    Args:
        duration: s from 0 to 1; 0 for at once.

    Raises:
        ValueError: the duration is negative or not finite.
    """

    def __init__(self, duration: float) -> None:
        if not (math.isfinite(duration) and duration >= 0.0):
            raise ValueError(f"The onset takes {duration} s; a finite time ≥ 0 is needed.")
        self.duration = duration
        self.weight = 0.0
        self._time = math.nan

    def advance(self, time: float, wanted: bool) -> float:
        """The weight at `time` (s), moved towards 1 where `wanted`, else towards 0."""
        elapsed = min(max(time - self._time, 0.0), LONGEST_STEP)
        if math.isfinite(time):
            self._time = time
        if not math.isfinite(elapsed):
            elapsed = 0.0
        step = elapsed / self.duration if self.duration > 0.0 else 1.0
        self.weight = min(self.weight + step, 1.0) if wanted else max(self.weight - step, 0.0)
        return self.weight
