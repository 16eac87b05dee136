"""Where a virtual object lies best on a prop: a rigid pose, and if asked a uniform scale.

Coarse: rotations spread over all there are, and those that match principal axes, are tried on few
points; the best few are registered. Fine: least squares of the distances between the surfaces, both
ways, by Gauss–Newton steps on pose and scale. What turns leave the fit as good are reported: the
object is symmetric there and its pose free.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import SceneError
from touchwarp.scan.deviation import Deviation, deviation, face_areas
from touchwarp.scan.poses import Cloud, even_rotations, frame_matches, turns
from touchwarp.scan.registration import Registration, Similarity
from touchwarp.scene.nearest import suggest
from touchwarp.scene.pose import angles_deg
from touchwarp.scene.surface import Surface

Float = NDArray[np.float64]
Progress = Callable[[str, float], None]

ROTATIONS = ("any", "upright", "none")
SAMPLES = 1500
EVEN = 576
"""Rotations that are tried: neighbours about 30° apart."""
REGISTERED = 12
"""Candidates that are registered."""
APART = math.radians(25)
"""Between candidates, and between poses that count as different."""
ALIKE = 0.02
"""Poses whose residuals differ by less than this part, and 0.2 % of the prop's radius, fit equally
well."""


@dataclass(frozen=True, eq=False)
class Alignment:
    """The best pose of a virtual object on a prop.

    Attributes:
        T_prop_virtual: (4, 4): virtual object's points to the prop's frame; a rotation, times
            `scale`, and a translation, m.
        scale: uniform; 1 unless asked for.
        to_prop: distances from the aligned virtual surface to the prop's.
        to_virtual: the other way round.
        free_axes: directions (prop frame) about which any turn fits as well: one for a solid of
            revolution, three for a ball.
        equal_poses: how many clearly different poses fit as well as this one, this one included;
            1 where the pose is unique. Turns about free axes are not counted.
        upright_times: where the file's up axis is not up, how many times the misfit would be with
            it up; None where it is, or was not tried.
    """

    T_prop_virtual: Float
    scale: float
    to_prop: Deviation
    to_virtual: Deviation
    free_axes: tuple[tuple[float, float, float], ...]
    equal_poses: int
    upright_times: float | None = None

    @property
    def rotation_deg(self) -> tuple[float, float, float]:
        """Angles about x, y, z, R = Rz·Ry·Rx, as a scene's `pose` has them."""
        return angles_deg(self.T_prop_virtual[:3, :3] / self.scale)

    @property
    def position(self) -> tuple[float, float, float]:
        """m, prop frame."""
        x, y, z = (float(v) for v in self.T_prop_virtual[:3, 3])
        return x, y, z

    def moved(self, prop: Surface, virtual: Surface, by: Float) -> Alignment:
        """The same pose moved by (3,) m, its distances measured anew."""
        T = self.T_prop_virtual.copy()
        T[:3, 3] += by
        there = virtual.transformed(T)
        return replace(
            self,
            T_prop_virtual=T,
            to_prop=deviation(there, prop),
            to_virtual=deviation(prop, there),
        )


def align(
    prop: Surface,
    virtual: Surface,
    *,
    scale: bool = False,
    rotation: str = "any",
    seed: int = 0,
    progress: Progress | None = None,
) -> Alignment:
    """Find the pose of `virtual` that lies nearest to `prop`.

    Args:
        prop, virtual: m; open or dirty surfaces are fine.
        scale: also find a uniform scale.
        rotation: "any"; "upright" turns about z only; "none" moves only.
        seed: of the samples.
        progress: called as progress(step, part done).

    Raises:
        SceneError: an unknown kind of rotation, or a surface with no area.
    """
    _check(prop, virtual, rotation)
    report = progress or (lambda step, part: None)
    of_prop, of_virtual = (Cloud.of(s, SAMPLES, seed + i) for i, s in enumerate((prop, virtual)))
    start_scale = of_prop.radius / of_virtual.radius if scale else 1.0
    registration = Registration(prop, virtual, of_prop, of_virtual, scale, rotation)
    rotations = _rotations(rotation, of_prop, of_virtual)
    report("trying rotations", 0.0)
    scores = np.array([registration.coarse(R, start_scale) for R in rotations])
    chosen = _spread(rotations, scores)
    found: list[tuple[float, Similarity]] = []
    for i, which in enumerate(chosen):
        report("registering", i / len(chosen))
        start = Similarity(start_scale, rotations[which], of_prop.centroid, of_virtual.centroid)
        found.append(registration.fine(start))
    least = min(residual for residual, _ in found)
    limit = (1 + ALIKE) * least + 0.1 * ALIKE * of_prop.radius
    alike = [pose for residual, pose in found if residual <= limit]
    # of poses that fit equally well, the one that turns the object least
    pose = registration.finest(max(alike, key=lambda pose: float(np.trace(pose.R))))
    report("looking for symmetry", 0.9)
    free = registration.free_axes(pose, limit)
    moved = virtual.transformed(pose.matrix)
    return Alignment(
        T_prop_virtual=pose.matrix,
        scale=pose.scale,
        to_prop=deviation(moved, prop),
        to_virtual=deviation(prop, moved),
        free_axes=tuple((float(x), float(y), float(z)) for x, y, z in free),
        equal_poses=_distinct([other.R for other in alike], free),
    )


def _rotations(kind: str, of_prop: Cloud, of_virtual: Cloud) -> Float:
    """(n, 3, 3) rotations to try, the identity first."""
    if kind == "none":
        return np.eye(3)[None]
    if kind == "upright":
        return turns(np.array([0.0, 0.0, 1.0]), 36)
    matches = frame_matches(of_prop.axes, of_virtual.axes)
    return np.concatenate([np.eye(3)[None], matches, even_rotations(EVEN)])


def _spread(rotations: Float, scores: Float) -> list[int]:
    """The best few, no two of them within 25° of each other."""
    chosen: list[int] = []
    for which in np.argsort(scores, kind="stable"):
        if all(_angle(rotations[which], rotations[other]) > APART for other in chosen):
            chosen.append(int(which))
        if len(chosen) == REGISTERED:
            break
    return chosen


def _angle(a: Float, b: Float) -> float:
    """rad, between two rotations."""
    return math.acos(float(np.clip((np.trace(a.T @ b) - 1) / 2, -1, 1)))


def _distinct(rotations: list[Float], free: list[Float]) -> int:
    """How many of the rotations differ by more than 25°, turns about a free axis apart."""
    different: list[Float] = []
    for R in rotations:
        if len(free) > 1:
            return 1
        if all(
            (_angle(R, other) if not free else _tilt(R @ other.T, free[0])) > APART
            for other in different
        ):
            different.append(R)
    return len(different)


def _tilt(R: Float, axis: Float) -> float:
    """rad, by how much R tilts an axis."""
    return math.acos(float(np.clip(axis @ R @ axis, -1, 1)))


def _check(prop: Surface, virtual: Surface, rotation: str) -> None:
    if rotation not in ROTATIONS:
        raise SceneError(f"unknown rotation '{rotation}'. {suggest(rotation, ROTATIONS)}")
    for name, surface in (("prop", prop), ("virtual object", virtual)):
        if surface.dimension != 3:
            raise SceneError(f"the {name} is a polygon; triangle surfaces are needed to align.")
        if not face_areas(surface).sum() > 0:
            raise SceneError(f"the {name} has no area; a mesh with proper faces is needed.")
