"""Compiled loops on all threads.

Kernels are compiled once, for one thread, and let go of the interpreter's lock; a loop is shared
out by calling its kernel on parts of its range at once. Compiling each loop a second time, for
threads of the compiler's own, would cost more than that ever saves.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

from numba import config

LEAST_SHARED = 40_000
"""Items from which a loop is shared: the start of a thread costs as much as some thousand."""

PARTS = 4
"""Parts a thread, where some take longer than others; half as many where none does."""


@cache
def threads() -> int:
    """How many threads share a loop: `NUMBA_NUM_THREADS`, or the processors of this process."""
    return int(getattr(config, "NUMBA_NUM_THREADS"))  # noqa: B009


@cache
def pool() -> ThreadPoolExecutor:
    """Threads for compiled loops that let go of the interpreter's lock."""
    return ThreadPoolExecutor(threads(), thread_name_prefix="touchwarp")


if hasattr(os, "register_at_fork"):
    # a forked process has none of its parent's threads: it must start its own
    os.register_at_fork(after_in_child=pool.cache_clear)


def share(
    kernel: Callable[..., Any], count: int, *arguments: Any, work: int = 1, even: bool = False
) -> list[Any]:
    """Call kernel(first, last, *arguments) on parts that together cover 0 … count.

    Each thread takes the next part that is left, this one as well: nobody waits for a thread that
    other programs keep from starting.

    Args:
        kernel: a compiled loop; parts of it must not write what others read.
        count: how many items the loop has.
        arguments: passed on.
        work: how much one item is, in units of which `LEAST_SHARED` are worth a second thread.
        even: all items take the same time, so that fewer parts will do.

    Returns:
        What each part returned, in order.
    """
    if threads() == 1 or count * work < LEAST_SHARED:
        return [kernel(0, count, *arguments)]
    parts = min((PARTS // 2 if even else PARTS) * threads(), count)
    results: list[Any] = [None] * parts
    left = deque(range(parts))

    def take_parts() -> None:
        while True:
            try:
                k = left.popleft()
            except IndexError:
                return
            results[k] = kernel(count * k // parts, count * (k + 1) // parts, *arguments)

    others = [pool().submit(take_parts) for _ in range(threads() - 1)]
    take_parts()
    for other in others:
        if not other.cancel():
            other.result()
    return results
