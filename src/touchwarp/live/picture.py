"""The scene as the page shows it: surfaces to draw, goals to drag, marks on the scales."""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib.metadata import version
from typing import cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from touchwarp.check.report import Report
from touchwarp.check.thresholds import FINGERTIP_OFFSET, HAND_OFFSET, REACH_GAIN, Threshold
from touchwarp.errors import SceneError
from touchwarp.goals import goals as make_goals
from touchwarp.goals import outer_box
from touchwarp.live.document import SceneDocument
from touchwarp.live.messages import (
    Certificate,
    CheckLine,
    Mark,
    Matrix,
    Placement,
    Plane,
    Pose,
    PropState,
    SceneState,
    Vector,
    WarpFile,
)
from touchwarp.live.surfaces import pack_surface
from touchwarp.scene import Prop, Scene, TransformGoal
from touchwarp.warp.meta import WarpMeta


@dataclass(frozen=True)
class Picture:
    """What of a scene is drawn.

    Attributes:
        props: with their goals.
        planes: the fixed ones.
        box: ∂Ω1, or the box around it.
        surfaces: packed, by key.
        affine: whether every goal is an affine map that the page may change.
    """

    props: tuple[PropState, ...]
    planes: tuple[Plane, ...]
    box: tuple[Vector, Vector]
    surfaces: dict[str, bytes] = field(repr=False)

    @property
    def affine(self) -> bool:
        """Whether instant goals can show it."""
        return all(prop.goal is not None for prop in self.props)

    @classmethod
    def of_meta(cls, meta: WarpMeta) -> Picture:
        """From what a warp file says of itself, where its meshes are missing."""
        props: list[PropState] = []
        surfaces: dict[str, bytes] = {}
        for name in meta.prop_names:
            outline = meta.outlines[name]
            key = f"outline-{len(props)}"
            surfaces[key] = pack_surface(
                outline.prop.vertices, outline.virtual.vertices, outline.prop.faces
            )
            goal = meta.goals.get(name)
            props.append(
                PropState(
                    name=name,
                    pose=Pose(position=(0.0, 0.0, 0.0), rotation_deg=(0.0, 0.0, 0.0)),
                    pivot=_base(outline.prop.vertices),
                    goal=None if goal is None else _matrix(goal),
                    placement=None,
                    surface=_url(key),
                )
            )
        if meta.outer_box is None:
            raise SceneError("The warp file does not tell its outer box; save the warp again.")
        return cls(tuple(props), (), _box(meta.outer_box), surfaces)


def picture_of(scene: Scene, before: Picture | None = None) -> Picture:
    """The picture of a scene.

    Args:
        scene: in space.
        before: an earlier picture, whose surfaces are used again where they are the same.

    Raises:
        SceneError: the scene is a plane one.
    """
    if scene.dimension != 3:
        raise SceneError(
            f"The scene is {scene.dimension}-D; the page shows scenes in space only. Look at a "
            "plane one by 'touchwarp check SCENE WARP --html report.html'."
        )
    own = make_goals(scene)
    surfaces: dict[str, bytes] = {}
    props = []
    for prop in scene.props:
        goal = own[prop.name]
        affine = goal.matrix is not None
        # Where the goal is affine the page moves the virtual object itself: not part of the key.
        turned = "" if affine else f"-{abs(hash(goal.virtual_points.tobytes())):x}"
        key = f"{prop.digest[:16]}{turned}"
        known = None if before is None else before.surfaces.get(key)
        surfaces[key] = known or pack_surface(goal.prop_points, goal.virtual_points, goal.faces)
        props.append(
            PropState(
                name=prop.name,
                pose=_pose(prop),
                pivot=_pivot(prop),
                goal=None if goal.matrix is None else _matrix(goal.matrix),
                placement=_placement(prop),
                surface=_url(key),
            )
        )
    planes = tuple(
        Plane(name=f.name, point=_vector(f.plane[0]), normal=_vector(f.plane[1]))
        for f in scene.fixed
        if f.plane is not None
    )
    return Picture(tuple(props), planes, _box(outer_box(scene, own)), surfaces)


def state_of(
    document: SceneDocument,
    picture: Picture,
    *,
    revision: int,
    solvable: bool,
    warp: WarpFile | None,
    warp_current: bool,
    bases: WarpFile | None,
    certificate: Certificate | None,
    recording: bool,
) -> SceneState:
    """Everything that the page shows, as one message."""
    scene = document.scene if solvable else None
    return SceneState(
        name=document.path.name if document.path else "scene of a warp file",
        version=version("touchwarp"),
        revision=revision,
        live=True,
        solvable=solvable,
        unsaved=document.unsaved,
        props=picture.props,
        planes=picture.planes,
        outer_box=picture.box,
        outer_fixed=scene is None or scene.outer.box_scale is None,
        mismatch_weight=0.0 if scene is None else scene.objective.mismatch_weight,
        tolerance_mm=0.1 if scene is None else scene.objective.tolerance_mm,
        interaction="slide" if scene is None else scene.interaction.mode,
        marks=marks(),
        warp=warp,
        warp_current=warp_current,
        bases=bases,
        certificate=certificate,
        recording=recording,
    )


def marks() -> tuple[Mark, ...]:
    """What people notice, for the colour scales; each with its source."""

    def at(scale: str, value: float, threshold: Threshold, part: str = "") -> Mark:
        return Mark.model_validate(
            {
                "scale": scale,
                "value": value,
                "label": f"{part}{threshold.quantity}: {threshold.kind}",
                "source": f"{threshold.condition}; {threshold.source}",
            }
        )

    low, high = cast(tuple[float, float], REACH_GAIN.limit)
    offset = cast(float, FINGERTIP_OFFSET.limit)
    return (
        at("mismatch", offset, FINGERTIP_OFFSET),
        at("mismatch", cast(float, HAND_OFFSET.limit), HAND_OFFSET),
        at("gain", low, REACH_GAIN),
        at("gain", high, REACH_GAIN),
        at("error", offset, FINGERTIP_OFFSET, "along the surface: "),
        Mark(
            scale="error",
            value=None,
            label="off the surface: no number, but noticed far sooner than an offset",
            source="visible interpenetration; Burns et al., as Zhao & Follmer, CHI 2018, have it",
        ),
    )


def certificate_of(report: Report, identity: str) -> Certificate:
    """The report's lines for the page."""
    return Certificate(
        identity=identity,
        status=report.status,
        checks=tuple(
            CheckLine(
                name=c.name,
                title=c.title,
                subject=c.subject,
                group=c.group,
                status=c.status,
                value=c.value_text,
                limit=c.limit_text,
                where=None if c.where is None else _vector(c.where),
                nowhere=c.nowhere_text,
                detail=c.detail,
                source=c.source,
            )
            for c in report.checks
        ),
    )


def _placement(prop: Prop) -> Placement | None:
    goal = prop.goal
    if not isinstance(goal, TransformGoal) or goal.matrix is not None:
        return None
    return Placement(
        scale=_vector(np.broadcast_to(goal.scale, 3)),
        rotation_deg=_vector(goal.rotation_deg or (0.0, 0.0, 0.0)),
        translation=_vector(goal.translation or (0.0, 0.0, 0.0)),
    )


def _pose(prop: Prop) -> Pose:
    pose = prop.origin.get("pose", {})
    return Pose(
        position=_vector(pose.get("position", (0.0, 0.0, 0.0))),
        rotation_deg=_vector(pose.get("rotation_deg", (0.0, 0.0, 0.0))),
    )


def _pivot(prop: Prop) -> Vector:
    bounds = np.array([prop.surface.vertices.min(axis=0), prop.surface.vertices.max(axis=0)])
    if isinstance(prop.goal, TransformGoal):
        return _vector(prop.goal.pivot_point(bounds))
    return _base(prop.surface.vertices)


def _base(vertices: NDArray[np.float64]) -> Vector:
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    middle = (low + high) / 2
    return _vector((middle[0], middle[1], low[2]))


def _url(key: str) -> str:
    return f"./surfaces/{key}.bin"


def _vector(values: ArrayLike) -> Vector:
    x, y, z = (float(v) for v in np.asarray(values))
    return (x, y, z)


def _matrix(values: ArrayLike) -> Matrix:
    return cast(Matrix, tuple(tuple(row) for row in np.asarray(values, dtype=float).tolist()))


def _box(box: ArrayLike) -> tuple[Vector, Vector]:
    low, high = np.asarray(box)
    return (_vector(low), _vector(high))
