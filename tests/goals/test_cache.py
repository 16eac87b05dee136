"""The cache on disk: content for content, whole or not at all, and never more than its share."""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np
import pytest

from touchwarp.goals import cache
from touchwarp.goals.cache import Cache, content_key

NUMBERS = np.arange(1000, dtype=np.float64)
KEPT = Cache("numbers", most_bytes=30_000)


@pytest.fixture(autouse=True)
def folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.setenv("TOUCHWARP_CACHE", str(tmp_path))
    return tmp_path / "numbers"


def test_what_is_kept_comes_back_to_the_bit() -> None:
    KEPT.keep("one", numbers=NUMBERS, whole=np.arange(3))
    arrays = KEPT.load("one")
    assert arrays is not None
    assert set(arrays) == {"numbers", "whole"}
    assert np.array_equal(arrays["numbers"], NUMBERS)
    assert arrays["whole"].dtype == np.int64
    assert KEPT.load("two") is None


@pytest.mark.parametrize("place", [0, 40, 200, 5000, -1])
def test_one_changed_byte_is_seen(folder: Path, place: int) -> None:
    KEPT.keep("one", numbers=NUMBERS)
    (path,) = folder.iterdir()
    content = bytearray(path.read_bytes())
    content[place] ^= 1
    path.write_bytes(content)
    assert KEPT.load("one") is None
    KEPT.keep("one", numbers=NUMBERS)
    assert KEPT.load("one") is not None


@pytest.mark.parametrize("length", [0, 20, 32, 5000])
def test_a_cut_file_is_seen(folder: Path, length: int) -> None:
    KEPT.keep("one", numbers=NUMBERS)
    (path,) = folder.iterdir()
    path.write_bytes(path.read_bytes()[:length])
    assert KEPT.load("one") is None


def test_those_unused_for_longest_make_room(folder: Path) -> None:
    half_written = folder / ".gone.1.arrays"
    for age, key in enumerate(("first", "second", "third")):
        KEPT.keep(key, numbers=NUMBERS)
        os.utime(folder / f"{key}.arrays", (1000 + age, 1000 + age))
    half_written.write_bytes(bytes(100))
    os.utime(half_written, (0, 0))
    assert KEPT.load("first") is not None  # and so the second is the oldest
    KEPT.keep("fourth", numbers=NUMBERS)
    assert {path.stem for path in folder.iterdir()} == {"first", "third", "fourth"}


def test_nothing_is_kept_where_the_cache_is_off_or_closed(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder.write_text("a file where the folder should be")
    KEPT.keep("one", numbers=NUMBERS)
    assert KEPT.load("one") is None
    monkeypatch.setenv("TOUCHWARP_CACHE", "")
    KEPT.keep("one", numbers=NUMBERS)
    assert KEPT.folder is None
    assert KEPT.load("one") is None


def test_a_key_counts_all_rooms_that_calculate_a_goal() -> None:
    package = Path(cache.__file__).parent.parent
    sources = [path for room in cache.ROOMS for path in (package / room).rglob("*.py")]
    used = {
        room
        for path in sources
        for room in re.findall(r"^\s*from touchwarp\.(\w+)", path.read_text("utf-8"), re.MULTILINE)
    }
    assert used - {"errors", "outputs"} == set(cache.ROOMS)


def test_a_key_tells_contents_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    assert content_key("a", NUMBERS) == content_key("a", NUMBERS.copy())
    apart = {
        content_key("a", NUMBERS),
        content_key("b", NUMBERS),
        content_key("a", NUMBERS + 1e-13),
        content_key("a", NUMBERS[:-1]),
        content_key("a", NUMBERS[:500], NUMBERS[500:]),
        content_key("a", NUMBERS[:501], NUMBERS[501:]),
    }
    assert len(apart) == 6
    monkeypatch.setattr(cache, "_code", lambda: "another build")
    assert content_key("a", NUMBERS) not in apart
