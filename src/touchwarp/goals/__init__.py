"""The retargeting goals: for every point of a prop's surface, where it must appear."""

from touchwarp.goals.goal import Goal
from touchwarp.goals.make import MAKERS, goals
from touchwarp.goals.validate import outer_box, validate
from touchwarp.scene.transform_goal import TransformGoal

__all__ = ["MAKERS", "Goal", "TransformGoal", "goals", "outer_box", "validate"]
