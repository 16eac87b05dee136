"""What a person may notice in contact: offset, direction, pinch width, curvature, edge angle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.check.case import Case, Finding, PropCase
from touchwarp.check.curvature import edge_angles, patch_curvatures
from touchwarp.check.pinch import find_pinches
from touchwarp.check.report import Check, place
from touchwarp.check.thresholds import (
    EDGE_ANGLE,
    FINGERTIP_OFFSET,
    FORCE_DIRECTION,
    HAND_OFFSET,
    PINCH_CURVATURE,
    PINCH_WIDTH,
    judge,
    unjudged,
)
from touchwarp.goals.surface_samples import face_normals

Float = NDArray[np.float64]


def check_perception(case: Case) -> Finding:
    """What the goal asks of a person, prop by prop, against the thresholds for the mode."""
    checks = [_free_offset(case)]
    shown = {}
    for prop in case.props:
        mode = case.scene.interaction.mode
        checks.append(_contact_offset(prop, mode))
        turn = normal_turn(prop)
        checks.append(_direction(prop, mode, turn))
        if case.dimension == 3:
            pinch, wider = _pinch(case, prop, mode)
            curvature, sharper = _curvature(case, prop, mode)
            checks += [pinch, curvature]
            shown[prop.name] = {"pinch": wider, "curvature": sharper}
        checks += _edges(prop, mode)
    return Finding(checks, shown)


def normal_turn(prop: PropCase) -> Float:
    """(m,) degrees: the angle between each face's normal and that of its image."""
    goal = prop.goal
    before = prop.body.outward * face_normals(goal.prop_points, goal.faces)
    after = prop.virtual.outward * face_normals(goal.virtual_points, goal.faces)
    cosine = np.einsum("ij,ij->i", before, after)
    turn: Float = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
    return turn


def _contact_offset(prop: PropCase, mode: str) -> Check:
    size = np.linalg.norm(prop.samples.targets - prop.samples.points, axis=1)
    return judge(
        FINGERTIP_OFFSET,
        mode,
        "offset.contact",
        "Greatest offset in contact",
        1e3 * prop.boundary_maximum,
        subject=prop.name,
        where=place(prop.samples.points, size.argmax()),
        detail=f"|g − x| on the surface; the mean is {1e3 * float(size.mean()):.3g} mm.",
    )


def _free_offset(case: Case) -> Check:
    size = np.linalg.norm(case.probes.u, axis=1)
    return judge(
        HAND_OFFSET,
        case.scene.interaction.mode,
        "offset.free",
        "Greatest offset before contact",
        1e3 * float(size.max()),
        where=place(case.probes.points, size.argmax()),
        detail="|u| in Ω.",
    )


def _direction(prop: PropCase, mode: str, turn: Float) -> Check:
    at_samples = turn[prop.samples.face]
    value = float(np.quantile(at_samples, 0.95))
    return judge(
        FORCE_DIRECTION,
        mode,
        "normal.turn",
        "Turn of the surface normal, 95th percentile",
        value,
        subject=prop.name,
        where=place(prop.samples.points, np.abs(at_samples - value).argmin()),
        detail="Angle between the felt and the seen surface, the direction of the contact force; "
        f"the median is {float(np.median(at_samples)):.2g}°.",
    )


def _pinch(case: Case, prop: PropCase, mode: str) -> tuple[Check, Float]:
    """The check, and by how much of itself each pinch changes."""
    name, title = "pinch.width", "Change of pinch width, 95th percentile"
    points, width, change = find_pinches(prop, case.random("pinch " + prop.name))
    if len(width) < 20:
        nothing = "Too few pairs of opposite points."
        return unjudged(PINCH_WIDTH, name, title, nothing, subject=prop.name), np.zeros(0)
    size = np.abs(change)
    value = float(np.quantile(size, 0.95))
    check = judge(
        PINCH_WIDTH,
        mode,
        name,
        title,
        100.0 * value,
        subject=prop.name,
        where=place(points, np.abs(size - value).argmin()),
        detail=f"{len(width):,} pairs of opposite points up to 100 mm apart; the median change is "
        f"{100 * float(np.median(change)):+.1f} %.",
    )
    return check, change


def _curvature(case: Case, prop: PropCase, mode: str) -> tuple[Check, Float]:
    """The check, and by how much of itself each patch's curvature changes."""
    name, title = "curvature.change", "Change of curvature, 95th percentile"
    points, felt, seen, flat = patch_curvatures(prop, case.random("curvature " + prop.name))
    if len(points) < 20:
        nothing = "Nearly all of the surface is flat."
        return unjudged(PINCH_CURVATURE, name, title, nothing, subject=prop.name), np.zeros(0)
    change = (seen - felt) / np.abs(felt)
    size = np.abs(change)
    value = float(np.quantile(size, 0.95))
    check = judge(
        PINCH_CURVATURE,
        mode,
        name,
        title,
        100.0 * value,
        subject=prop.name,
        where=place(points, np.abs(size - value).argmin()),
        detail="Mean curvature over patches of a fingertip's size, seen against felt; the median "
        f"change is {100 * float(np.median(change)):+.0f} %; {100 * flat:.0f} % of the surface is "
        "flat and left out.",
    )
    return check, change


def _edges(prop: PropCase, mode: str) -> list[Check]:
    felt, seen, where = edge_angles(prop)
    if len(felt) == 0:
        return []
    change = np.abs(seen - felt) / felt
    worst = int(change.argmax())
    return [
        judge(
            EDGE_ANGLE,
            mode,
            "edges.angle",
            "Greatest change of a sharp edge's angle",
            100.0 * float(change[worst]),
            subject=prop.name,
            where=place(where, worst),
            detail=f"From {np.degrees(felt[worst]):.0f}° felt to {np.degrees(seen[worst]):.0f}° "
            "seen.",
        )
    ]
