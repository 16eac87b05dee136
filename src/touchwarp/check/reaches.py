"""Whole reaches: straight paths of the real hand from a ring of starts to the props' surfaces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from touchwarp.check.case import Case, Finding
from touchwarp.check.report import Check, measured, place
from touchwarp.check.thresholds import REACH_DIRECTION, REACH_GAIN, judge, unjudged

Float = NDArray[np.float64]

RING_RADIUS = 0.4
"""m: from a prop's centre to the starts, the length of a reach across a desk."""

ELEVATIONS_DEG = (0.0, 25.0, 50.0)
TRIED = 3000
KEPT = 600
STEP = 1e-3
"""m along the real path."""

STOP_SHORT = 1e-3
"""m before contact, where the speed along a reach is last looked at: f bends at the surface."""


def check_reaches(case: Case) -> Finding:
    """Gain and direction of whole reaches, speed ratio and jumps of ∂f along them.

    Reaches that would pass through a prop are left out. Of each the gain is the displayed distance
    over the real one, start to end, and the direction the angle between the two.
    """
    starts, ends = _reaches(case)
    mode = case.scene.interaction.mode
    if len(starts) == 0:
        nothing = "No surface point can be reached on a straight path from the ring of starts."
        return Finding(
            [
                unjudged(REACH_GAIN, "reach.gain_low", "Gain of whole reaches", nothing),
                unjudged(REACH_DIRECTION, "reach.direction", "Direction of reaches", nothing),
            ],
            {},
        )
    ratio, turn = _whole_reaches(case, starts, ends)
    speed, middles, jump, jump_at = _along(case, starts, ends)
    checks = [
        *_whole_checks(mode, starts, ends, ratio, turn),
        *_speed_checks(speed, middles),
        measured(
            "reach.jump",
            "Largest jump of ∂f along a reach",
            float(jump.max()),
            group="judged",
            where=place(jump_at, jump.argmax()),
            detail=f"Change of the displayed velocity over one step of {1e3 * STEP:g} mm, as a "
            f"share of the real velocity; over all reaches the median of the largest is "
            f"{float(np.median(jump)):.2g}. No threshold is known.",
        ),
    ]
    return Finding(
        checks,
        {"ratio": ratio, "turn": turn, "speed": speed, "starts": starts, "ends": ends},
    )


def _whole_reaches(case: Case, starts: Float, ends: Float) -> tuple[Float, Float]:
    """Of each reach (n,): displayed over real length, and deg between the two directions."""
    real = ends - starts
    shown = case.warp(ends) - case.warp(starts)
    length = np.linalg.norm(real, axis=1)
    ratio = np.asarray(np.linalg.norm(shown, axis=1) / length)
    cosine = np.einsum("ij,ij->i", real, shown) / (length**2 * np.maximum(ratio, 1e-12))
    return ratio, np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))


def _whole_checks(mode: str, starts: Float, ends: Float, ratio: Float, turn: Float) -> list[Check]:
    low, high = np.quantile(ratio, 0.05), np.quantile(ratio, 0.95)
    steep = float(np.quantile(turn, 0.95))
    assert isinstance(REACH_GAIN.limit, tuple)
    length = np.linalg.norm(ends - starts, axis=1)
    what = f"{len(starts):,} reaches of about {100 * float(np.median(length)):.0f} cm"
    return [
        judge(
            REACH_GAIN,
            mode,
            "reach.gain_low",
            "Gain of whole reaches, 5th percentile",
            float(low),
            limit=(REACH_GAIN.limit[0], None),
            where=place(ends, np.abs(ratio - low).argmin()),
            detail=f"{what}; the median is {float(np.median(ratio)):.3f}.",
        ),
        judge(
            REACH_GAIN,
            mode,
            "reach.gain_high",
            "Gain of whole reaches, 95th percentile",
            float(high),
            limit=(None, REACH_GAIN.limit[1]),
            where=place(ends, np.abs(ratio - high).argmin()),
            detail=f"{what}; {100 * float((ratio > 1.07).mean()):.0f} % are above 1.07.",
        ),
        judge(
            REACH_DIRECTION,
            mode,
            "reach.direction",
            "Direction of whole reaches, 95th percentile",
            steep,
            where=place(ends, np.abs(turn - steep).argmin()),
            detail=f"Angle between real and displayed reach; the median is "
            f"{float(np.median(turn)):.2g}°.",
        ),
    ]


def _speed_checks(speed: Float, middles: Float) -> list[Check]:
    slowest, fastest = speed.min(axis=1), speed.max(axis=1)
    slow, fast = float(np.quantile(slowest, 0.01)), float(np.quantile(fastest, 0.99))
    slow_reach, fast_reach = np.abs(slowest - slow).argmin(), np.abs(fastest - fast).argmin()
    return [
        measured(
            "reach.slowest",
            "Least speed ratio along a reach, 1st percentile",
            slow,
            "×",
            group="judged",
            where=place(middles[slow_reach], speed[slow_reach].argmin()),
            detail="Displayed over real speed, step by step. A slowed hand is noticed more than a "
            "quickened one; no number is known for a part of a reach.",
        ),
        measured(
            "reach.fastest",
            "Greatest speed ratio along a reach, 99th percentile",
            fast,
            "×",
            group="judged",
            where=place(middles[fast_reach], speed[fast_reach].argmax()),
            detail="Displayed over real speed, step by step; no number is known for a part of a "
            "reach.",
        ),
    ]


def _reaches(case: Case) -> tuple[Float, Float]:
    """Starts and ends (n, d) m of reaches that meet nothing before their end."""
    rng = case.random("reaches")
    d = case.dimension
    angle = rng.uniform(0.0, 2.0 * np.pi, TRIED)
    if d == 3:
        rise = np.radians(rng.choice(ELEVATIONS_DEG, TRIED))
        out = np.stack(
            [np.cos(rise) * np.cos(angle), np.cos(rise) * np.sin(angle), np.sin(rise)], axis=1
        )
    else:
        out = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    which = rng.integers(len(case.props), size=TRIED)
    starts, ends = np.empty_like(out), np.empty_like(out)
    facing = np.zeros(TRIED, bool)
    for number, prop in enumerate(case.props):
        rows = np.flatnonzero(which == number)
        low, high = prop.body.vertices.min(axis=0), prop.body.vertices.max(axis=0)
        radius = max(RING_RADIUS, 0.75 * float(np.linalg.norm(high - low)))
        starts[rows] = 0.5 * (low + high) + radius * out[rows]
        taken = rng.integers(len(prop.samples.points), size=len(rows))
        ends[rows] = prop.samples.points[taken]
        normals = prop.body.outward * prop.samples.normals[taken]
        facing[rows] = np.einsum("ij,ij->i", starts[rows] - ends[rows], normals) > 0
    for point, normal in case.region.planes:
        facing &= (starts - point) @ normal > 0
        facing &= (ends - point) @ normal > 0
    starts, ends = starts[facing], ends[facing]
    if len(starts) == 0:
        return starts, ends
    free = np.ones(len(starts), bool)
    if d == 3:
        length = np.linalg.norm(ends - starts, axis=1)
        for body in (*case.region.props, *case.region.holds):
            hit = body.first_hit(starts, (ends - starts) / length[:, None])
            free &= ~(hit < length - 1e-5)
    else:
        steps = np.linspace(0.0, 1.0 - 1e-6, 400)[:, None, None]
        path = (starts + steps * (ends - starts)).reshape(-1, d)
        for body in (*case.region.props, *case.region.holds):
            free &= ~body.inside(path).reshape(len(steps), -1).any(axis=0)
    return starts[free][:KEPT], ends[free][:KEPT]


def _along(case: Case, starts: Float, ends: Float) -> tuple[Float, Float, Float, Float]:
    """Speed ratio (n, steps) of each reach, the steps' middles (n, steps, d), and the largest
    velocity jump (n,) with its place (n, d)."""
    length = np.linalg.norm(ends - starts, axis=1)
    count = int(np.ceil(length.max() / STEP))
    t = np.linspace(0.0, 1.0, count + 1)
    stops = starts + (1.0 - STOP_SHORT / length)[:, None] * (ends - starts)
    path = starts[:, None, :] + t[None, :, None] * (stops - starts)[:, None, :]
    shown = case.warp(path)
    real_step = (length - STOP_SHORT) / count
    speed = np.linalg.norm(np.diff(shown, axis=1), axis=2) / real_step[:, None]
    direction = (ends - starts) / length[:, None]
    velocity = np.einsum("nkij,nj->nki", case.warp.jacobian(path), direction)
    jump = np.linalg.norm(np.diff(velocity, axis=1), axis=2)
    at = jump.argmax(axis=1)
    rows = np.arange(len(starts))
    middles = 0.5 * (path[:, 1:] + path[:, :-1])
    return speed, middles, jump[rows, at], path[rows, at]
