"""Goals kept on disk by the content of both surfaces and the goal's settings."""

from __future__ import annotations

import json
from dataclasses import asdict, fields

import numpy as np

from touchwarp.goals.cache import Cache, content_key
from touchwarp.goals.goal import Goal
from touchwarp.scene.map_goals import AreaPreservingGoal, MatchGoal
from touchwarp.scene.scene import Prop

GOALS = Cache("goals", most_bytes=500_000_000)
"""A goal of 100,000 faces takes 4.8 MB."""
NO_SETTINGS = ("virtual", "origin")
"""Of a spec's fields: the surface counts by its arrays, and where it came from does not."""


def load_goal(prop: Prop, spec: AreaPreservingGoal | MatchGoal) -> Goal | None:
    """The goal kept of these very surfaces and settings; None where there is none."""
    arrays = GOALS.load(_key(prop, spec))
    if arrays is None:
        return None
    return Goal(
        arrays["prop_points"],
        arrays["virtual_points"],
        arrays["faces"],
        spec.kind,
        json.loads(arrays["report"].tobytes()),
        virtual_surface=spec.virtual,
        landmarks=arrays.get("landmarks"),
    )


def keep_goal(prop: Prop, spec: AreaPreservingGoal | MatchGoal, goal: Goal) -> None:
    """Keep a goal for its surfaces and settings."""
    landmarks = {} if goal.landmarks is None else {"landmarks": goal.landmarks}
    GOALS.keep(
        _key(prop, spec),
        prop_points=goal.prop_points,
        virtual_points=goal.virtual_points,
        faces=goal.faces.astype(np.int32),
        report=np.frombuffer(json.dumps(goal.report).encode(), np.uint8),
        **landmarks,
    )


def _key(prop: Prop, spec: AreaPreservingGoal | MatchGoal) -> str:
    surfaces = prop.surface, spec.virtual
    settings = {
        field.name: getattr(spec, field.name)
        for field in fields(spec)
        if field.name not in NO_SETTINGS
    }
    return content_key(
        spec.kind,
        json.dumps(settings, default=asdict),
        *(array for surface in surfaces for array in (surface.vertices, surface.faces)),
    )
