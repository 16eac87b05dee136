"""The tracked hand of WebXR and OpenXR: its joints, and the skeleton that links them.

A joint's frame has −z along its bone towards the tip and +y out of the back of the hand, so that
bending the finger turns −z towards −y: a turn by a negative angle about x. The *palm* (wrist,
metacarpals, knuckles) is one rigid body; each finger has four angles: at its base one of flexion
and one of abduction, and flexion at its two other joints.
"""

from __future__ import annotations

import numpy as np

FINGERS = ("thumb", "index", "middle", "ring", "little")

JOINTS = (
    "wrist",
    "thumb-metacarpal",
    "thumb-phalanx-proximal",
    "thumb-phalanx-distal",
    "thumb-tip",
    *(
        f"{finger}-finger-{bone}"
        for finger in ("index", "middle", "ring", "pinky")
        for bone in (
            "metacarpal",
            "phalanx-proximal",
            "phalanx-intermediate",
            "phalanx-distal",
            "tip",
        )
    ),
)
"""WebXR's names and order, 25; OpenXR has a palm before them, 26."""

BASES = np.array([1, 6, 11, 16, 21])
"""The joint at each finger's base: the thumb's metacarpal, the other fingers' knuckles."""

TIPS = BASES + 3

PARENTS = np.array([1, 5, 10, 15, 20])
"""Whose frame a base's angles are counted in. The thumb's own: it is held near its tracked pose,
since its base is a saddle whose angles to the wrist tell little."""

_THUMB = [[-25.0, 25.0], [-25.0, 25.0], [-60.0, 10.0], [-85.0, 20.0]]
_FINGER = [[-90.0, 30.0], [-25.0, 25.0], [-110.0, 5.0], [-80.0, 10.0]]
LIMITS = np.radians([_THUMB, _FINGER, _FINGER, _FINGER, _FINGER])
"""(5, 4, 2) rad: least and greatest flexion and abduction at the base, then flexion of the two
other joints; of the thumb's base, relative to its tracked pose. A tracked angle beyond a limit
moves the limit there."""

TIP_RADIUS = 8e-3
"""m: distance of a tracked fingertip from the skin where the device gives none."""
