"""Whole hands: a tracked hand in, the displayed hand out; see docs/hands.md."""

from touchwarp.hand.carried import CarriedWarp
from touchwarp.hand.contact import NearestSurface
from touchwarp.hand.mesh_surface import MeshSurface
from touchwarp.hand.onset import Onset
from touchwarp.hand.options import HandOptions
from touchwarp.hand.pad import Pad, calibrate_pad
from touchwarp.hand.retarget import HandRetargeter
from touchwarp.hand.skeleton import FINGERS, JOINTS

__all__ = [
    "FINGERS",
    "JOINTS",
    "CarriedWarp",
    "HandOptions",
    "HandRetargeter",
    "MeshSurface",
    "NearestSurface",
    "Onset",
    "Pad",
    "calibrate_pad",
]
