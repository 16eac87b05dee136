"""What a grid takes of memory, how one that would take too much is refused, what is given back."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache

import numpy as np

from touchwarp.errors import SolveError

BYTES_PER_NODE = 150
"""Peak memory a node, measured by `benchmarks/memory.py`, table and fit included."""

NODES_PER_BRICK = 640
"""Nodes a refined brick adds, rims included."""


def check_memory(
    nodes: int, bricks: int, limit: float, tolerance: float, missed: Callable[[], float]
) -> None:
    """Refuse more bricks where memory would not suffice for them.

    Args:
        nodes: there are already.
        bricks: to be added.
        limit: bytes.
        tolerance: m.
        missed: m, what the grid misses as it is.

    Raises:
        SolveError: it would not, with the tolerance that fits.
    """
    needed = (nodes + bricks * NODES_PER_BRICK) * BYTES_PER_NODE
    if needed <= limit:
        return
    met = max(missed(), tolerance * 1.5)
    raise SolveError(
        f"A tolerance of {tolerance * 1e3:g} mm needs more than {needed / 1e9:.2g} GB, "
        f"over the limit of {limit / 1e9:.2g} GB. What fits is about "
        f"{_rounded_up(met * 1e3 * needed / limit):g} mm: ask for that tolerance, "
        "or allow more memory."
    )


def give_back() -> None:
    """Let the system have freed memory that the C library would keep for later.

    glibc keeps what lies between arrays that are still in use: after a fit, a tenth of what a solve
    takes. Other libraries are left alone.
    """
    trim = _malloc_trim()
    if trim is not None:
        trim(ctypes.c_size_t(0))


@cache
def _malloc_trim() -> Callable[[ctypes.c_size_t], int] | None:
    try:
        return ctypes.CDLL(None).malloc_trim
    except (AttributeError, OSError, TypeError):
        return None


def _rounded_up(value: float) -> float:
    scale = 10.0 ** np.floor(np.log10(value))
    return float(np.ceil(value / scale * 10.0) / 10.0 * scale)
