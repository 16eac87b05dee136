"""How the hand meets the prop, and how well it is tracked."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from touchwarp.errors import SceneError
from touchwarp.scene.nearest import suggest

MODES = ("tap", "slide", "pinch", "grasp")


@dataclass(frozen=True)
class Tracking:
    """A tracker's errors, for the certificate's error budget.

    Attributes:
        bias_mm: constant offset of the tracked fingertip, mm (length of the offset).
        noise_mm: standard deviation of the tracked fingertip along each axis, mm.
        latency_ms: age of the tracked fingertip when it is displayed, ms.
        pose_mm: standard deviation of the prop's tracked position along each axis, mm.
        pose_deg: standard deviation of the prop's tracked rotation about each axis, degrees.
        name: the preset's name, or "given".
    """

    bias_mm: float = 0.0
    noise_mm: float = 0.0
    latency_ms: float = 0.0
    pose_mm: float = 0.0
    pose_deg: float = 0.0
    name: str = "given"

    def __post_init__(self) -> None:
        for key in (f.name for f in fields(self) if f.name != "name"):
            value = getattr(self, key)
            if not math.isfinite(value) or value < 0:
                raise SceneError(
                    f"interaction.tracking.{key} is {value}; a finite number ≥ 0 is needed."
                )


# Bias and latency: 0.2–1 mm and 5–15 ms for optical markers; 11 mm mean fingertip error and 45 ms
# for headset hands (Quest 2, 10.3758/s13428-022-02051-8). Noise and pose errors are assumed values
# of the usual size; give your own tracker's numbers where they matter.
TRACKING_PRESETS = {
    "markers": Tracking(0.5, 0.2, 10.0, 0.5, 0.3, "markers"),
    "headset_hands": Tracking(11.0, 1.0, 45.0, 2.0, 1.0, "headset_hands"),
}


@dataclass(frozen=True)
class Interaction:
    """Chooses the thresholds that the certificate quotes.

    Attributes:
        mode: "tap", "slide", "pinch" or "grasp".
        tracking: a `Tracking`, or the name of a preset: "markers", "headset_hands".
    """

    mode: str = "slide"
    tracking: Tracking | str = "markers"

    def __post_init__(self) -> None:
        if self.mode not in MODES:
            raise SceneError(f"interaction.mode is '{self.mode}'. {suggest(self.mode, MODES)}")
        if isinstance(self.tracking, str):
            if self.tracking not in TRACKING_PRESETS:
                raise SceneError(
                    f"interaction.tracking is '{self.tracking}'. "
                    f"{suggest(self.tracking, TRACKING_PRESETS)}"
                )
            object.__setattr__(self, "tracking", TRACKING_PRESETS[self.tracking])
        elif not isinstance(self.tracking, Tracking):
            raise SceneError(
                f"interaction.tracking is {self.tracking!r}; a Tracking or one of "
                f"{', '.join(TRACKING_PRESETS)} is needed."
            )
