"""A scan made ready to be a prop: its table cut away, its frame set upright, its mesh repaired."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import SceneError
from touchwarp.scan.align import Alignment, align
from touchwarp.scan.foot import Foot, with_flat_foot
from touchwarp.scan.remesh import edge_length_for, remesh
from touchwarp.scan.repair import Repair, repair
from touchwarp.scan.soundness import Soundness, inspect
from touchwarp.scan.tabletop import Tabletop, crop_tabletop
from touchwarp.scan.thickness import wall_thickness
from touchwarp.scene.surface import Surface
from touchwarp.scene.units import up_rotation

Float = NDArray[np.float64]
Progress = Callable[[str, float], None]

STANDING = np.cos(np.radians(15))
"""An aligned object with one axis nearer to the vertical can be stood upright on it …"""
UPRIGHT_WORTH = 1.25
"""… or on the up axis of its file, if its misfit (p95 distances, both ways) is then at most so many
times the best one's."""
UNLIKE = 1.5
"""Where one diagonal is so many times the other, distances hardly tell how the object is turned."""
MOST_NEIGHBOURS = 40
"""A vertex with more, as in the middle of a fan, calls for remeshing …"""
EVEN_FACES = 20_000
"""… to about so many triangles, more where a wall is thin."""


@dataclass(frozen=True, eq=False)
class Prepared:
    """A mesh that is ready to be a prop or a virtual object.

    Attributes:
        surface: m; in the scene's frame for a prop, its own for a virtual object.
        T_scene_file: (4, 4) rigid, from the file's frame (in m, z up).
        table: what was cut away, in the file's frame, or None.
        repair: what the mesh needed, or None where no repair was good enough.
        refusal: why there is no repair; "" where there is one.
        foot: its foot, closed flat on the table, where it stands on one and that could be done.
        evened: it was remeshed, as vertices had more neighbours than maps of surfaces bear.
        found: the soundness of `surface`.
    """

    surface: Surface
    T_scene_file: Float
    table: Tabletop | None
    repair: Repair | None
    refusal: str
    foot: Foot | None
    evened: bool
    found: Soundness

    @property
    def changed(self) -> bool:
        """Whether the file's own mesh will not do."""
        stood = self.foot is not None and self.foot.drawn > 0
        repaired = self.repair is not None and bool(self.repair.steps)
        return self.table is not None or self.evened or repaired or stood

    def standing(self, T_scene_virtual: Float) -> Prepared:
        """The same thing, set on the table z = 0 by a pose, with its foot closed flat there.

        Args:
            T_scene_virtual: (4, 4): a rotation, times a scale, and a translation, m.
        """
        foot = with_flat_foot(self.surface.transformed(T_scene_virtual))
        if foot is None or foot.drawn == 0:
            return replace(self, foot=foot)
        surface = foot.surface.transformed(np.linalg.inv(T_scene_virtual).astype(np.float64))
        return replace(self, surface=surface, foot=foot, found=inspect(surface))


def prepare(
    surface: Surface,
    *,
    crop: bool = True,
    genus: int | None = None,
    progress: Progress | None = None,
) -> Prepared:
    """Cut away the table of a scan, if there is one, and repair what is left.

    With a table the scene's frame is level: z is the table's normal, the origin on the table below
    the object's middle, and its foot is closed flat there. A mesh that no repair mends is kept as
    it is: the solver takes it, and goals that need no closed surface do too.
    """
    table = crop_tabletop(surface) if crop else None
    T = np.eye(4)
    if table is not None:
        T = level(table)
        surface = table.surface.transformed(T)
    mended, refusal = None, ""
    try:
        mended = repair(surface, genus=genus, progress=progress)
        surface = mended.surface
    except SceneError as error:
        refusal = str(error)
    foot = with_flat_foot(surface) if table is not None else None
    if foot is not None:
        surface = foot.surface
    evened = mended is not None and np.bincount(surface.faces.ravel()).max() > MOST_NEIGHBOURS
    if evened:
        edge_length = min(edge_length_for(surface, EVEN_FACES), 0.7 * wall_thickness(surface))
        surface = remesh(surface, edge_length, progress=progress)
    return Prepared(surface, T, table, mended, refusal, foot, evened, inspect(surface))


def level(table: Tabletop) -> Float:
    """T_scene_file (4, 4): the table's plane becomes z = 0, with as little turning as can be."""
    from scipy.spatial.transform import Rotation

    upward = np.array([[0.0, 0.0, 1.0]])
    R, _ = Rotation.align_vectors(upward, table.normal[None])
    # of all rotations that bring the normal upright, the one that turns least
    axis = np.cross(table.normal, upward[0])
    if np.linalg.norm(axis) > 1e-9:
        angle = np.arctan2(np.linalg.norm(axis), table.normal[2])
        R = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis))
    T = np.eye(4)
    T[:3, :3] = R.as_matrix()
    low, high = table.surface.transformed(T).bounds
    T[:3, 3] = -0.5 * (low + high)
    T[2, 3] = -(T[:3, :3] @ table.point)[2]
    return T


def place(
    prop: Surface,
    virtual: Surface,
    *,
    scale: bool = False,
    on_table: bool = False,
    progress: Progress | None = None,
) -> Alignment:
    """The pose of a virtual object on a prop, upright where that fits about as well.

    The file's own up axis stays up unless another pose fits clearly better, as for an object that
    lies on its side in its file. An object of very different size is turned about the vertical as
    it would be at the prop's size, handle on handle.

    Args:
        prop, virtual: m, z up.
        scale: also find a uniform scale.
        on_table: then lower or raise it to stand on z = 0.
        progress: called as progress(step, part done).
    """
    found = align(prop, virtual, scale=scale, progress=progress)
    upward = found.T_prop_virtual[2, :3] / found.scale
    axis = "xyz"[int(np.abs(upward).argmax())]
    nearest = axis if upward[np.abs(upward).argmax()] > 0 else f"-{axis}"
    standing = ["z"]
    if np.abs(upward).max() > STANDING and nearest != "z":
        standing.append(nearest)
    least = _misfit(found)
    times = None
    for up in standing:
        T_stood_virtual = np.eye(4)
        T_stood_virtual[:3, :3] = up_rotation(up)
        upright = _turned(prop, virtual.transformed(T_stood_virtual), scale, progress)
        if _misfit(upright) <= UPRIGHT_WORTH * least:
            found = replace(upright, T_prop_virtual=upright.T_prop_virtual @ T_stood_virtual)
            break
        if up == "z" and least > 0:
            times = _misfit(upright) / least
    found = replace(found, upright_times=times)
    if on_table:
        drop = float(virtual.transformed(found.T_prop_virtual).bounds[0, 2])
        found = found.moved(prop, virtual, np.array([0.0, 0.0, -drop]))
    return found


def _turned(prop: Surface, virtual: Surface, scale: bool, progress: Progress | None) -> Alignment:
    """The best pose that turns about the vertical only."""
    one, other = (float(np.linalg.norm(np.ptp(s.bounds, axis=0))) for s in (prop, virtual))
    alike = align(
        prop,
        virtual,
        scale=scale or max(one, other) > UNLIKE * min(one, other),
        rotation="upright",
        progress=progress,
    )
    if scale or alike.scale == 1.0:
        return alike
    T = np.eye(4)
    T[:3, :3] = alike.T_prop_virtual[:3, :3] / alike.scale
    moved = align(prop, virtual.transformed(T), rotation="none", progress=progress)
    return replace(
        moved,
        T_prop_virtual=moved.T_prop_virtual @ T,
        free_axes=alike.free_axes,
        equal_poses=alike.equal_poses,
    )


def _misfit(found: Alignment) -> float:
    return found.to_prop.p95_mm + found.to_virtual.p95_mm


def choose_goal(prop: Soundness, virtual: Soundness) -> tuple[str, str]:
    """The kind of goal for two surfaces, and why; "direction" stands for "try it, else transform".

    Args:
        prop, virtual: what `inspect` finds of them.
    """
    for name, found in (("prop", prop), ("virtual object", virtual)):
        if not found.sound:
            return "direction", f"the {name}'s mesh has {found.faults()}, and match needs it closed"
    if prop.genus != virtual.genus:
        return (
            "direction",
            f"the prop has {_handles(prop.genus)} and the virtual object {_handles(virtual.genus)}:"
            " no one-to-one map keeps both",
        )
    why = f"both surfaces are closed and have {_handles(prop.genus)}"
    if prop.genus is not None and prop.genus > 1:
        why += "; see that each is shown on the one beside it"
    return "match", why


def _handles(genus: int | None) -> str:
    return "no handle" if genus == 0 else f"{genus} handle{'s' if genus != 1 else ''}"
