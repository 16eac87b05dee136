"""How a hand is displayed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from touchwarp.hand.contact import NearestSurface
from touchwarp.hand.skeleton import FINGERS, TIP_RADIUS

Mode = Literal["fingertips", "rigid", "points"]
Orientation = Literal["as_tracked", "turned"]
Contact = Literal["centre", "pad", "skin"]


@dataclass(frozen=True)
class HandOptions:
    """How a hand is displayed.

    Attributes:
        mode: "fingertips" brings all five to their warped places, by inverse kinematics; "rigid"
            moves the hand as a whole, as `leader` asks; "points" warps every joint by itself, which
            stretches bones.
        leader: the finger that leads in "rigid".
        orientation: "as_tracked", or "turned" by the rotation part of ∂f: of the palm, or in
            "rigid" at the leading fingertip.
        contact: what of a fingertip is warped: its "centre", its "pad", or the "skin" nearest to
            the prop, which needs `surface`; see `touchwarp.hand.contact`.
        surface: the props' surface.
        tip_radius: m, where the device gives none.
        pad_offsets: (5, 3) m from each fingertip's centre to its pad, in the tip's frame; straight
            out of the palm's side by the radius when left out.
        weights: how the five fingers share a miss that cannot be helped; the greater, the less.
        onset: s from no displacement to all of it.

    Raises:
        ValueError: a word is unknown, a number out of range, or "skin" has no surface.
    """

    mode: Mode = "fingertips"
    leader: str = "index"
    orientation: Orientation = "as_tracked"
    contact: Contact = "centre"
    surface: NearestSurface | None = None
    tip_radius: float = TIP_RADIUS
    pad_offsets: tuple[tuple[float, float, float], ...] | None = None
    weights: tuple[float, float, float, float, float] = (1.0, 1.0, 1.0, 1.0, 1.0)
    onset: float = 0.5

    def __post_init__(self) -> None:
        words = {
            "mode": get_args(Mode),
            "leader": FINGERS,
            "orientation": get_args(Orientation),
            "contact": get_args(Contact),
        }
        for name, known in words.items():
            if getattr(self, name) not in known:
                raise ValueError(
                    f"The hand's {name} is {getattr(self, name)!r}; one of {', '.join(known)} is "
                    "needed."
                )
        if self.contact == "skin" and self.surface is None:
            raise ValueError(
                'contact="skin" needs to know where the props are: give `surface`, or take "pad".'
            )
        if not 0.0 < self.tip_radius < 0.05:
            raise ValueError(f"The tip radius is {self.tip_radius} m; 0 to 0.05 is needed.")
        if len(self.weights) != 5 or not all(0.0 < w < np.inf for w in self.weights):
            raise ValueError(f"The weights are {self.weights}; five numbers > 0 are needed.")
        if self.pad_offsets is not None and np.shape(self.pad_offsets) != (5, 3):
            raise ValueError(
                f"The pad offsets have shape {np.shape(self.pad_offsets)}; (5, 3) is needed."
            )
