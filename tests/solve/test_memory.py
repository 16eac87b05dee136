"""Freed memory goes back to the system where the C library would keep it."""

import ctypes
import platform
from pathlib import Path

import numpy as np
import pytest

from touchwarp.solve import memory

PIECES, BYTES = 2000, 64_000
glibc = pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="only glibc is asked")


def resident_bytes():
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


@glibc
def test_what_lies_between_arrays_in_use_is_given_back():
    pieces = [np.ones(BYTES, np.uint8) for _ in range(PIECES)]
    full = resident_bytes()
    kept = pieces[::20]
    del pieces
    freed = (PIECES - len(kept)) * BYTES
    assert full - resident_bytes() < 0.2 * freed, "nothing was left to give back"
    memory.give_back()
    assert full - resident_bytes() > 0.8 * freed
    assert all(piece.all() for piece in kept)


@pytest.mark.parametrize("failure", [AttributeError, OSError, TypeError])
def test_other_libraries_are_left_alone(monkeypatch, failure):
    class Library:
        def __init__(self, name):
            if failure is not AttributeError:
                raise failure

    monkeypatch.setattr(ctypes, "CDLL", Library)
    memory._malloc_trim.cache_clear()
    assert memory._malloc_trim() is None
    memory.give_back()
    monkeypatch.undo()
    memory._malloc_trim.cache_clear()
