"""What people notice: every number with its condition and its source.

Position, gain, direction, curvature and sharpness are separate quantities; a number found under
one condition says nothing about another. A measured value is held against a threshold only where
the scene's interaction mode meets the condition, and is "unknown" elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from touchwarp.check.report import Check, Limit, measured, number_text, unmeasured

ANY_MODE = ("tap", "slide", "pinch", "grasp")

JND = "just noticeable difference"
DETECTION = "detection threshold"
ACCEPTANCE = "acceptance"


@dataclass(frozen=True)
class Threshold:
    """One published number.

    Attributes:
        quantity: what was varied.
        limit: the greatest value, or (least, greatest), in `unit`.
        unit: as in `Check`.
        kind: `JND`, `DETECTION` or `ACCEPTANCE`, in full for readers; they are not the same.
        condition: how it was measured.
        source: where it stands.
        modes: interaction modes that meet the condition; none where nothing here does.
    """

    quantity: str
    limit: Limit
    unit: str
    kind: str
    condition: str
    source: str
    modes: tuple[str, ...] = ()


_ZHAO = "Zhao & Follmer, CHI 2018"
_ZENNER = "Zenner & Krüger, IEEE VR 2019, 10.1109/VR.2019.8798143"
_TINGUY = "de Tinguy et al. 2019, hal-02121839"

FINGERTIP_OFFSET = Threshold(
    "fingertip offset in contact",
    52.0,
    "mm",
    JND,
    "normal and shear force feedback (another source adds: both fingertips shown)",
    f"{_ZHAO}, ref. 35",
    ("slide", "pinch", "grasp"),
)
HAND_OFFSET = Threshold(
    "hand offset before contact",
    200.0,
    "mm",
    JND,
    "visual dominance, no tactile feedback",
    f"{_ZHAO}, ref. 15",
    ANY_MODE,
)
FORCE_DIRECTION = Threshold(
    "direction of the contact force",
    31.9,
    "deg",
    JND,
    "haptics with incongruent vision (18.4° haptics alone, 25.6° with congruent vision)",
    f"{_ZHAO}, ref. 11",
    ("tap", "slide"),
)
REACH_DIRECTION = Threshold(
    "direction of a whole reach",
    4.5,
    "deg",
    DETECTION,
    "fixed offset, horizontal or vertical, two-alternative choice, 12 people, no touch",
    _ZENNER,
    ANY_MODE,
)
REACH_GAIN = Threshold(
    "gain of a whole reach",
    (0.88, 1.07),
    "×",
    DETECTION,
    "two-alternative choice, 12 people, no touch",
    _ZENNER,
    ANY_MODE,
)
PINCH_WIDTH = Threshold(
    "width between thumb and index",
    5.75,
    "%",
    DETECTION,
    "thumb–index pinch",
    _TINGUY,
    ("pinch",),
)
PINCH_CURVATURE = Threshold(
    "local curvature", 66.66, "%", DETECTION, "thumb–index pinch", _TINGUY, ("pinch",)
)
EDGE_ANGLE = Threshold(
    "angle of an edge", 11.0, "%", JND, "touch only, nothing seen", "Skinner et al. 2013"
)
SCALE_UP = Threshold("scale-up", 1.8, "×", DETECTION, "shape display", "Abtahi & Follmer, CHI 2018")

THRESHOLDS = (
    FINGERTIP_OFFSET,
    HAND_OFFSET,
    FORCE_DIRECTION,
    REACH_DIRECTION,
    REACH_GAIN,
    PINCH_WIDTH,
    PINCH_CURVATURE,
    EDGE_ANGLE,
    Threshold(
        "local orientation",
        43.8,
        "%",
        DETECTION,
        "thumb–index pinch; of which reference angle is not said",
        _TINGUY,
    ),
    Threshold(
        "finger flexion", 32.0, "mm", JND, 'printed as an "angular mismatch"', f"{_ZHAO}, ref. 37"
    ),
    Threshold(
        "direction of a whole reach, accepted though noticed",
        40.0,
        "deg",
        ACCEPTANCE,
        "rated 4.6 of 5",
        "Cheng et al., Sparse Haptic Proxy, CHI 2017",
    ),
    Threshold(
        "slope shown flat", 40.0, "deg", DETECTION, "shape display", "Abtahi & Follmer, CHI 2018"
    ),
    SCALE_UP,
    Threshold(
        "offset of a hand-held stick",
        150.0,
        "mm",
        DETECTION,
        "hand-held tool, 26 people",
        "10.1109/tvcg.2023.3247047",
    ),
)


def judge(
    threshold: Threshold,
    mode: str,
    name: str,
    title: str,
    value: float,
    *,
    limit: Limit | None = None,
    **more: Any,
) -> Check:
    """The value against the threshold, or "unknown" where the mode does not meet its condition.

    Args:
        threshold: what to hold the value against.
        mode: the scene's interaction mode.
        name, title, value: as in `Check`; the unit is the threshold's.
        limit: one end of the threshold's limit, where each end has a check of its own.
        more: other fields of `Check`.
    """
    limit = threshold.limit if limit is None else limit
    condition = f"{threshold.kind}: {threshold.condition}"
    if mode in threshold.modes:
        return measured(
            name,
            title,
            value,
            threshold.unit,
            limit=limit,
            group="judged",
            condition=condition,
            source=threshold.source,
            **more,
        )
    nearest = Check(name, title, value, threshold.unit, limit, "unknown", "judged")
    return Check(
        name,
        title,
        value,
        threshold.unit,
        None,
        "unknown",
        "judged",
        condition=f"no number for mode “{mode}”; nearest: {nearest.limit_text}, {condition}",
        source=threshold.source,
        **more,
    )


def unjudged(threshold: Threshold, name: str, title: str, detail: str, **more: Any) -> Check:
    """A check that this prop gives nothing to measure for."""
    return unmeasured(
        name,
        title,
        threshold.unit,
        group="judged",
        detail=detail,
        condition=f"{threshold.kind}: {threshold.condition}",
        source=threshold.source,
        **more,
    )


def limit_of(threshold: Threshold) -> str:
    """The threshold's number as text, for the page's list of thresholds."""
    limit = threshold.limit
    if isinstance(limit, tuple):
        low, high = (number_text(v or 0.0) for v in limit)
        return f"{low} – {high} {threshold.unit}"
    return Check("", "", None, threshold.unit, limit, "unknown", "judged").limit_text[2:]
