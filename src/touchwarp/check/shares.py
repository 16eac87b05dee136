"""Compiled loops shared out to threads, without compiling each of them a second time for that."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from touchwarp.solve.threads import pool, threads

_SMALL = 2048


def share_out(count: int, work: Callable[[slice], None]) -> None:
    """Call `work` with slices that together cover 0 … count, in several threads.

    Args:
        count: how many items there are.
        work: handles the items of its slice, most of the time without the interpreter's lock.
    """
    if count < _SMALL or threads() == 1:
        work(slice(0, count))
        return
    bounds = np.linspace(0, count, 4 * threads() + 1).astype(int)
    tasks = [pool().submit(work, slice(a, b)) for a, b in pairwise(bounds)]
    for task in tasks:
        task.result()
