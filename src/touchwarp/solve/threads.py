"""How many threads share a compiled loop: one for small ones, where a start costs too much."""

from __future__ import annotations

from numba import config, set_num_threads

LEAST_SHARED = 40_000
"""Items from which a loop is shared."""


def share(items: int) -> None:
    """Let the parallel loops that follow use all threads, or one if there is little to do."""
    every = int(getattr(config, "NUMBA_NUM_THREADS"))  # noqa: B009
    set_num_threads(every if items >= LEAST_SHARED else 1)
