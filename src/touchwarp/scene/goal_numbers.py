"""Numbers of a goal, checked where it is built in code; the scene file's are checked as read."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import GoalError


def finite(key: str, value: Any) -> NDArray[np.float64]:
    """The value as an array of finite numbers; raises GoalError."""
    try:
        numbers = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise GoalError(f"goal.{key} is {value!r}; numbers are needed.") from None
    if not np.isfinite(numbers).all():
        raise GoalError(f"goal.{key} is {value!r}; finite numbers are needed.")
    return numbers


def point(key: str, value: Any) -> tuple[float, ...]:
    """Three finite numbers; raises GoalError."""
    numbers = finite(key, value)
    if numbers.shape != (3,):
        raise GoalError(f"goal.{key} is {value!r}; three numbers are needed.")
    return tuple(numbers.tolist())


def direction(key: str, value: Any) -> tuple[float, ...]:
    """Three finite numbers, not all 0, as a unit vector; raises GoalError."""
    numbers = np.array(point(key, value))
    length = float(np.linalg.norm(numbers))
    if length < 1e-12:
        raise GoalError(f"goal.{key} is {value!r}; a direction of some length is needed.")
    return tuple((numbers / length).tolist())


def number(key: str, value: Any, least: float, above: bool = False) -> float:
    """A finite number ≥ `least`, or > `least` if `above`; raises GoalError."""
    number_ = finite(key, value)
    sign = ">" if above else "≥"
    if number_.ndim or number_ < least or (above and number_ == least):
        raise GoalError(f"goal.{key} is {value!r}; a number {sign} {least:g} is needed.")
    return float(number_)


def count(key: str, value: Any, least: int) -> int:
    """A whole number ≥ `least`; raises GoalError."""
    whole = not isinstance(value, bool) and isinstance(value, (int, float, np.integer))
    if not whole or not math.isfinite(value) or value != int(value) or value < least:
        raise GoalError(f"goal.{key} is {value!r}; a whole number ≥ {least} is needed.")
    return int(value)
