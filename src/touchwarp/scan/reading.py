"""What a mesh file does not tell: its unit and its up axis, proposed from what is plausible."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from touchwarp.scan.deviation import face_areas, face_normals
from touchwarp.scene.mesh_file import read_raw_mesh
from touchwarp.scene.surface import Surface
from touchwarp.scene.units import METRES, UP_AXES, up_rotation

HAND_HELD = (0.03, 0.45)
"""m: the longest side of things that are held in one hand lies between these."""
USUAL = 0.12
"""m: and is most often about so long."""
FLAT = 0.05
"""A face is part of a foot if it is within this part of the height from the lowest point."""
CLEARLY = 1.5
"""A foot must be this much larger than the next to be taken for one."""


@dataclass(frozen=True)
class Reading:
    """How to read a mesh file.

    Attributes:
        unit: a unit's name; "m" where the format defines it.
        up: an up axis.
        unit_known, up_known: defined by the format, rather than proposed.
        size_mm: extent along the file's axes in that unit.
    """

    unit: str
    up: str
    unit_known: bool
    up_known: bool
    size_mm: tuple[float, float, float]

    @property
    def plausible(self) -> bool:
        """Whether the longest side is that of a thing held in one hand."""
        return HAND_HELD[0] <= max(self.size_mm) * 1e-3 <= HAND_HELD[1]


def propose_reading(path: Path) -> Reading:
    """The unit and axes of a mesh file, as its format defines them or else as is most plausible.

    The unit is the one by which the longest side is nearest to 12 cm, mm, m and cm before inches.
    The up axis is the one that the object has the largest flat foot under, where one is clearly
    larger than the others; else z.

    Raises:
        SceneError: as `read_mesh`, but never for a missing unit.
    """
    raw = read_raw_mesh(path)
    surface = Surface(raw.vertices, raw.faces)
    extent = np.ptp(surface.bounds, axis=0)
    named = {metres: name for name, metres in METRES.items()}
    unit = named.get(raw.metres or 0.0, "m") if raw.metres else plausible_unit(float(extent.max()))
    x, y, z = (float(v) for v in extent * METRES[unit] * 1e3)
    up_known = path.suffix.lower() in (".glb", ".gltf")
    up = raw.up if up_known else plausible_up(surface)
    return Reading(unit, up, raw.metres is not None, up_known, (x, y, z))


def plausible_unit(longest: float) -> str:
    """The unit in which a side of that many units is most likely the longest of a hand-held thing.

    Inches and feet are proposed only where mm, cm and m all give an implausible size.
    """

    def strangeness(unit: str) -> float:
        metres = longest * METRES[unit]
        rare = 0 if unit in ("mm", "cm", "m") else 1
        outside = not HAND_HELD[0] <= metres <= HAND_HELD[1]
        return 100.0 * outside + 10.0 * rare + abs(math.log(max(metres, 1e-12) / USUAL))

    return min(METRES, key=strangeness)


def plausible_up(surface: Surface) -> str:
    """The axis that the largest flat foot of the surface speaks for; "z" where none does clearly.

    Orientation of the faces plays no part.
    """
    feet = {}
    area, normals = face_areas(surface), face_normals(surface)
    for up in UP_AXES:
        axis = up_rotation(up)[2]
        height = (surface.vertices @ axis)[surface.faces]
        low, high = float(height.min()), float(height.max())
        if high <= low:
            return "z"
        foot = height.max(axis=1) < low + FLAT * (high - low)
        level = np.abs(normals @ axis) > 0.95
        feet[up] = float(area[foot & level].sum())
    ranked = sorted(feet, key=lambda up: -feet[up])
    if feet[ranked[0]] <= CLEARLY * max(feet[ranked[1]], 1e-12):
        return "z"
    return ranked[0]
