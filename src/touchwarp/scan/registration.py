"""Least squares of the distances between two surfaces, both ways, over pose and scale."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.scan.deviation import face_normals
from touchwarp.scan.poses import Cloud, turns
from touchwarp.scene.surface import Surface

Float = NDArray[np.float64]

STEPS, FINEST_STEPS = 25, 60
COARSE_POINTS, POINTS = 250, 500
TURNS = 24


@dataclass(frozen=True, eq=False)
class Similarity:
    """x ↦ scale·R·(x − pivot) + place.

    Attributes:
        scale: a factor.
        R: (3, 3) a rotation.
        place: (3,) m, prop frame: where the pivot goes.
        pivot: (3,) m, virtual object's frame.
    """

    scale: float
    R: Float
    place: Float
    pivot: Float

    @property
    def matrix(self) -> Float:
        """(4, 4), virtual object's frame to the prop's."""
        T = np.eye(4)
        T[:3, :3] = self.scale * self.R
        T[:3, 3] = self.place - T[:3, :3] @ self.pivot
        return T

    def __call__(self, points: Float) -> Float:
        return (points - self.pivot) @ (self.scale * self.R).T + self.place

    def inverse(self, points: Float) -> Float:
        """Points (n, 3) m of the prop's frame in the virtual object's."""
        return (points - self.place) @ self.R / self.scale + self.pivot


class Registration:
    """Two surfaces with samples of each and trees to find nearest points in.

    Args:
        prop, virtual: m.
        of_prop, of_virtual: samples of them.
        scale: whether a uniform scale is sought too.
        rotation: "any", "upright" (about z), "none".
    """

    def __init__(
        self,
        prop: Surface,
        virtual: Surface,
        of_prop: Cloud,
        of_virtual: Cloud,
        scale: bool,
        rotation: str,
    ) -> None:
        from scipy.spatial import cKDTree

        self.prop, self.virtual = _Nearest(prop), _Nearest(virtual)
        self.of_prop, self.of_virtual = of_prop, of_virtual
        self.free = np.array(
            [rotation == "any", rotation == "any", rotation != "none", True, True, True, scale]
        )
        self.trees = cKDTree(of_prop.points), cKDTree(of_virtual.points)

    def coarse(self, R: Float, scale: float) -> float:
        """m: root mean square distance between samples, centroid on centroid."""
        a = self.of_prop.points[:: len(self.of_prop.points) // COARSE_POINTS]
        b = self.of_virtual.points[:: len(self.of_virtual.points) // COARSE_POINTS]
        to_prop, _ = self.trees[0].query(scale * b @ R.T)
        to_virtual, _ = self.trees[1].query(a @ R / scale)
        return float(np.sqrt(((to_prop**2).mean() + (scale * to_virtual) ** 2).mean() / 2))

    def fine(self, pose: Similarity, steps: int = STEPS, points: int = POINTS) -> Any:
        """Levenberg–Marquardt from a pose: (root mean square distance m, the pose found)."""
        damping = 1e-3
        residual, jacobian = self._linear(pose, points)
        for _ in range(steps):
            normal = jacobian.T @ jacobian
            gradient = jacobian.T @ residual
            step = np.zeros(7)
            ridge = damping * np.diag(normal).max() * np.eye(len(normal))
            step[self.free] = -np.linalg.solve(normal + ridge, gradient)
            moved = _moved(pose, step, self.of_prop.radius)
            new_residual, new_jacobian = self._linear(moved, points)
            if (new_residual**2).sum() < (residual**2).sum():
                gain = 1 - (new_residual**2).sum() / (residual**2).sum()
                pose, residual, jacobian = moved, new_residual, new_jacobian
                damping = max(damping / 5, 1e-9)
                if gain < 1e-9:
                    break
            else:
                damping *= 8
                if damping > 1e4:
                    break
        return float(np.sqrt((residual**2).mean())), pose

    def finest(self, pose: Similarity) -> Similarity:
        """The same with all samples and more steps."""
        found: Similarity = self.fine(pose, FINEST_STEPS, len(self.of_prop.points))[1]
        return found

    def free_axes(self, pose: Similarity, limit: float) -> list[Float]:
        """Principal axes (prop frame) about which the object can turn with residuals ≤ limit."""
        free = []
        for axis in (pose.R @ self.of_virtual.axes).T:
            if self.free[:3].all() or (self.free[2] and abs(axis[2]) > 0.99):
                spun = [
                    Similarity(pose.scale, R @ pose.R, pose.place, pose.pivot)
                    for R in turns(axis, TURNS)
                ]
                if all(self.residual(turned) <= limit for turned in spun):
                    free.append(axis * np.sign(axis[np.abs(axis).argmax()]))
        return free

    def residual(self, pose: Similarity) -> float:
        """m: root mean square distance between the surfaces, both ways."""
        residual, _ = self._linear(pose, POINTS)
        return float(np.sqrt((residual**2).mean()))

    def _linear(self, pose: Similarity, points: int) -> tuple[Float, Float]:
        """Distances (n,) m and their derivatives (n, free) by turn, move and log scale.

        Turn and scale are about the pose's place, in units of the prop's radius.
        """
        b = self.of_virtual.points[:: max(1, len(self.of_virtual.points) // points)]
        at = pose(b + self.of_virtual.centroid)
        foot, facing = self.prop(at)
        # the other way round: the virtual surface's point nearest to each point of the prop
        a = self.of_prop.points[:: max(1, len(self.of_prop.points) // points)]
        target = a + self.of_prop.centroid
        near, near_facing = self.virtual(pose.inverse(target))
        at = np.concatenate([at, pose(near)])
        gap = at - np.concatenate([foot, target])
        facing = np.concatenate([facing, near_facing @ pose.R.T])
        distance = np.linalg.norm(gap, axis=1)
        along = np.where(
            (distance > 1e-9)[:, None], gap / np.maximum(distance, 1e-300)[:, None], facing
        )
        arm = at - pose.place
        jacobian = np.concatenate(
            [np.cross(arm, along), along * self.of_prop.radius, (along * arm).sum(1)[:, None]],
            axis=1,
        )
        return distance, jacobian[:, self.free]


def _moved(pose: Similarity, step: Float, radius: float) -> Similarity:
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_rotvec(step[:3]).as_matrix()
    return Similarity(
        pose.scale * float(np.exp(np.clip(step[6], -0.5, 0.5))),
        turn @ pose.R,
        pose.place + radius * step[3:6],
        pose.pivot,
    )


class _Nearest:
    """Nearest points of a surface, and the normals there."""

    def __init__(self, surface: Surface) -> None:
        import igl

        self.surface = surface
        self.normals = face_normals(surface)
        self.tree = igl.AABB()
        self.tree.init(surface.vertices, surface.faces)

    def __call__(self, points: Float) -> tuple[Float, Float]:
        _, face, foot = self.tree.squared_distance(
            self.surface.vertices, self.surface.faces, np.ascontiguousarray(points)
        )
        return np.asarray(foot), self.normals[np.asarray(face).ravel()]
