"""The flat faces that a prop and its virtual object stand on, one to show on the other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.maps.closed_mesh import ClosedMesh
from touchwarp.scene.surface import Surface

Float = NDArray[np.float64]

FLAT = 5e-6
"""m: what is nearer than this to the plane is on it."""
LEVEL = 1e-4
"""m: the planes of both may differ by this."""


@dataclass(frozen=True, eq=False)
class Base:
    """Which vertices of the prop stand on the plane, and where on it the virtual object does.

    Attributes:
        normal: (3,) unit vector, outward.
        prop_height, height: m, of the prop's and of the virtual object's plane along the normal.
    """

    normal: Float
    prop_height: float
    height: float

    def stands(self, vertices: Float) -> NDArray[np.bool_]:
        """(n,): which vertices (n, 3) m of the prop are on the plane."""
        return np.asarray(vertices @ self.normal >= self.prop_height - FLAT)


def find_base(prop: ClosedMesh | Surface, virtual: ClosedMesh | Surface, normal: Float) -> Base:
    """The base of both surfaces towards `normal`.

    Raises:
        GoalError: one of them has no flat face there, or they lie in different planes.
    """
    heights = prop.vertices @ normal, virtual.vertices @ normal
    top = [float(along.max()) for along in heights]
    on_plane = [along >= most - FLAT for along, most in zip(heights, top, strict=True)]
    for what, mesh, on in (
        ("the prop", prop, on_plane[0]),
        ("the virtual object", virtual, on_plane[1]),
    ):
        if not on[mesh.faces].all(axis=1).any():
            raise GoalError(
                f"{what} has no flat face towards goal.base; give the outward normal of the face "
                "that it stands on, or leave base out."
            )
    if abs(top[0] - top[1]) > LEVEL:
        raise GoalError(
            f"the bases of the prop and the virtual object lie {abs(top[0] - top[1]) * 1e3:.3g} mm "
            "apart along goal.base; they must be in one plane: change the pose, or leave base out."
        )
    return Base(normal, top[0], top[1])
