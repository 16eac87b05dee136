"""The scene: props with their goals, the outer boundary, what is fixed, what is minimised."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import SceneError
from touchwarp.scene.goal_spec import GoalSpec, ReadyGoal
from touchwarp.scene.interaction import Interaction
from touchwarp.scene.nearest import suggest
from touchwarp.scene.objective import Objective
from touchwarp.scene.surface import Surface, surface_digest
from touchwarp.scene.texture_goal import TextureGoal
from touchwarp.scene.topology import open_edge_count
from touchwarp.scene.transform_goal import TransformGoal

CONTACTS = ("slide", "hold")
DEFAULT_BOX_SCALE = 4.0


@dataclass(frozen=True, eq=False)
class Prop:
    """A real object that is touched, and what it must feel like.

    Attributes:
        name: unique in the scene.
        surface: the prop's surface ∂Ω2, posed: m, scene frame.
        goal: a goal spec such as `TransformGoal`, or a ready `Goal`. The default is the identity:
            the prop appears as it is.
        origin: the scene-file keys that describe the surface, such as {"mesh": "mug.stl", …}; empty
            for a surface given as arrays.
    """

    name: str
    surface: Surface
    goal: GoalSpec | ReadyGoal = field(default_factory=TransformGoal)
    origin: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        _check_name(self.name, "prop")
        if not isinstance(self.surface, Surface):
            raise SceneError(
                f"prop '{self.name}': its surface is a {type(self.surface).__name__}; a Surface "
                "(vertices in m, faces) is needed; read_mesh makes one from a file."
            )
        if not isinstance(self.goal, (GoalSpec, ReadyGoal)):
            raise SceneError(
                f"prop '{self.name}': its goal is a {type(self.goal).__name__}; a TransformGoal, "
                "another goal spec, or a Goal is needed."
            )

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the posed surface: see `surface_digest`."""
        return surface_digest(self.surface)


@dataclass(frozen=True, eq=False)
class Outer:
    """The outer boundary ∂Ω1, beyond which nothing is displaced: one of three.

    Attributes:
        box_scale: a cube whose side is this many times the longest side of the box around all
            props and virtual objects, with the same centre; 4 where nothing else is given.
        box: (2, d) m, scene frame: least and greatest corner.
        surface: any closed surface, m, scene frame.
        origin: as for `Prop`.
    """

    box_scale: float | None = None
    box: NDArray[np.float64] | Sequence[Sequence[float]] | None = None
    surface: Surface | None = None
    origin: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        given = [k for k in ("box_scale", "box", "surface") if getattr(self, k) is not None]
        if len(given) > 1:
            raise SceneError(
                f"outer has {' and '.join(given)}; give exactly one of box_scale, box and a "
                "closed surface."
            )
        if not given:
            object.__setattr__(self, "box_scale", DEFAULT_BOX_SCALE)
        scale = self.box_scale
        if scale is not None and not (math.isfinite(scale) and scale > 1):
            raise SceneError(
                f"outer.box_scale is {scale}; a finite number > 1 is needed (the paper's '10 "
                "times', by volume, is 2.154)."
            )
        if self.box is not None:
            box = np.array(self.box, dtype=np.float64)
            if box.shape not in ((2, 2), (2, 3)) or not np.isfinite(box).all():
                raise SceneError(
                    f"outer.box has shape {box.shape}; a finite least and greatest corner, "
                    "(2, 3), or (2, 2) in a plane scene, are needed."
                )
            for axis, low, high in zip("xyz", box[0], box[1], strict=False):
                if low >= high:
                    raise SceneError(
                        f"outer.box is inverted: in {axis} its min {low:g} is not below its max "
                        f"{high:g}; exchange them."
                    )
            box.setflags(write=False)
            object.__setattr__(self, "box", box)
        if self.surface is not None:
            edges = open_edge_count(self.surface.faces)
            if edges:
                raise SceneError(
                    f"the outer surface is not closed: {edges} of its edges have an odd number of "
                    "faces; close it, or use box."
                )

    @property
    def dimension(self) -> int | None:
        """2 or 3, or None for a box by scale, which fits either."""
        if self.surface is not None:
            return self.surface.dimension
        return None if self.box is None else int(np.shape(self.box)[1])


@dataclass(frozen=True, eq=False)
class Fixed:
    """What a prop stands on or near: touchable, but not retargeted.

    Attributes:
        name: unique in the scene.
        plane: (point, normal), m and a direction, scene frame; the normal becomes a unit vector.
            Props of a sliding plane lie on the side that its normal points to.
        surface: a surface instead of the plane; contact "hold" only.
        contact: "slide", the default for a plane (the displacement stays in the plane), or "hold"
            (no displacement on it).
        blend_mm: where a goal contradicts the surface at the contact line, the width over which
            one turns into the other.
        origin: as for `Prop`.
    """

    name: str
    plane: tuple[Sequence[float], Sequence[float]] | None = None
    surface: Surface | None = None
    contact: str | None = None
    blend_mm: float = 10.0
    origin: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        _check_name(self.name, "fixed surface")
        if (self.plane is None) == (self.surface is None):
            raise SceneError(
                f"fixed surface '{self.name}' has "
                f"{'neither a plane nor a surface' if self.plane is None else 'both'}; give "
                "exactly one of plane and mesh."
            )
        contact = self.contact or ("slide" if self.surface is None else "hold")
        if contact not in CONTACTS:
            raise SceneError(
                f"fixed surface '{self.name}' has the contact '{contact}'. "
                f"{suggest(contact, CONTACTS)}"
            )
        if self.surface is not None and contact == "slide":
            raise SceneError(
                f"fixed surface '{self.name}' is a mesh with contact 'slide'; a mesh can only "
                "'hold' (sliding needs a plane)."
            )
        object.__setattr__(self, "contact", contact)
        if not math.isfinite(self.blend_mm) or self.blend_mm < 0:
            raise SceneError(
                f"fixed surface '{self.name}' has blend_mm {self.blend_mm}; a finite length in mm "
                "≥ 0 is needed."
            )
        if self.plane is not None:
            point, normal = (np.array(v, dtype=np.float64) for v in self.plane)
            if point.shape not in ((2,), (3,)) or normal.shape != point.shape:
                raise SceneError(
                    f"fixed surface '{self.name}' has a point of shape {point.shape} and a normal "
                    f"of shape {normal.shape}; (3,) each, or (2,) in a plane scene, is needed."
                )
            length = float(np.linalg.norm(normal))
            if not (np.isfinite(point).all() and math.isfinite(length)) or length < 1e-12:
                raise SceneError(
                    f"fixed surface '{self.name}' has the point {point.tolist()} and the normal "
                    f"{normal.tolist()}; a finite point and a normal of some length are needed."
                )
            object.__setattr__(self, "plane", (point, normal / length))

    @property
    def dimension(self) -> int:
        """2 or 3."""
        if self.surface is not None:
            return self.surface.dimension
        assert self.plane is not None
        return len(self.plane[0])


@dataclass(frozen=True, eq=False)
class Scene:
    """Everything that decides a warp; read from one TOML file by `load_scene`, or built in code.

    Attributes:
        props: at least one; names unique.
        outer, objective, fixed, interaction: see those classes.
        dimension: 3, or 2 in a plane scene.
        directory: the folder that relative paths of the scene file start from.
    """

    props: Sequence[Prop]
    outer: Outer = field(default_factory=Outer)
    objective: Objective = field(default_factory=Objective)
    fixed: Sequence[Fixed] = ()
    interaction: Interaction = field(default_factory=Interaction)
    dimension: int = 3
    directory: Path = Path()

    def __post_init__(self) -> None:
        object.__setattr__(self, "props", tuple(self.props))
        object.__setattr__(self, "fixed", tuple(self.fixed))
        if self.dimension not in (2, 3):
            raise SceneError(f"dimension is {self.dimension!r}; 2 or 3 is needed.")
        if not self.props:
            raise SceneError("the scene has no props; add at least one [[prop]].")
        names = [p.name for p in self.props] + [f.name for f in self.fixed]
        for name in names:
            if names.count(name) > 1:
                raise SceneError(
                    f"the name '{name}' is used {names.count(name)} times; every prop and fixed "
                    "surface needs a name of its own."
                )
        parts: list[tuple[str, int | None]] = [("outer", self.outer.dimension)]
        parts += [(f"prop '{p.name}'", p.surface.dimension) for p in self.props]
        parts += [(f"fixed surface '{f.name}'", f.dimension) for f in self.fixed]
        for place, dimension in parts:
            if dimension not in (None, self.dimension):
                raise SceneError(
                    f"{place} is {dimension}-D in a {self.dimension}-D scene; give it "
                    f"{self.dimension} coordinates, or set dimension = {dimension}."
                )
        slides = [f.name for f in self.fixed if f.contact == "slide"]
        if len(slides) > 1:
            raise SceneError(
                f"{len(slides)} planes slide ({', '.join(slides)}); at most one can, as the solver "
                'mirrors the scene in it: give the others contact = "hold".'
            )

    @cached_property
    def text(self) -> str:
        """The TOML that the scene was read from, or an equivalent where it was built in code."""
        # load_scene fills this cache; dataclasses.replace drops it, so that text never goes stale.
        from touchwarp.scene.write import scene_text

        return scene_text(self)

    @property
    def digests(self) -> dict[str, str]:
        """SHA-256 of every prop's posed surface, by name, and of virtual objects of their own."""
        digests = {prop.name: prop.digest for prop in self.props}
        for prop in self.props:
            virtual = getattr(prop.goal, "virtual", None)
            if isinstance(virtual, Surface):
                digests[f"{prop.name}, virtual object"] = surface_digest(virtual)
            elif isinstance(prop.goal, TextureGoal):
                digests[f"{prop.name}, texture"] = prop.goal.digest
        return digests

    @property
    def slide_plane(self) -> Fixed | None:
        """The sliding plane, if the scene has one."""
        return next((f for f in self.fixed if f.contact == "slide"), None)

    def prop(self, name: str) -> Prop:
        """The prop of that name."""
        for prop in self.props:
            if prop.name == name:
                return prop
        raise SceneError(
            f"no prop is named '{name}'. {suggest(name, [p.name for p in self.props])}"
        )

    def only(self, name: str) -> Scene:
        """The same scene with no prop but the one of that name."""
        return dataclasses.replace(self, props=[self.prop(name)])

    def with_objective(self, **changes: float) -> Scene:
        """The same scene with some of the objective's values changed."""
        return dataclasses.replace(self, objective=dataclasses.replace(self.objective, **changes))

    def with_goals(self, goals: Mapping[str, GoalSpec | ReadyGoal]) -> Scene:
        """The same scene with other goals for the props named."""
        for name in goals:
            self.prop(name)
        props = [dataclasses.replace(p, goal=goals.get(p.name, p.goal)) for p in self.props]
        return dataclasses.replace(self, props=props)


def _check_name(name: object, what: str) -> None:
    if not isinstance(name, str) or not name.strip():
        raise SceneError(f"a {what} has the name {name!r}; a text that is not empty is needed.")
