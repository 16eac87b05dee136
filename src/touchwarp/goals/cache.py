"""Arrays that took long to make, kept on disk by the content of what they were made of."""

from __future__ import annotations

import functools
import hashlib
import io
import logging
import os
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import OutputError
from touchwarp.outputs import replacing

FOLDER_VARIABLE = "TOUCHWARP_CACHE"
"""Names another folder; empty: nothing is kept."""
CALCULATING = ("libigl", "numba", "numpy", "scipy")
"""The libraries on which the last bits of what is kept depend, …"""
ROOMS = ("scene", "goals")
"""… and the rooms."""
SUFFIX = ".arrays"

_DIGEST_BYTES = hashlib.sha256().digest_size
_log = logging.getLogger("touchwarp.goals")


@dataclass(frozen=True)
class Cache:
    """One kind of arrays, in a folder of its own.

    A file is the SHA-256 of an .npz archive, then that archive, so that no damage goes unseen.

    Attributes:
        name: of the folder, and of what is kept there.
        most_bytes: of all files; those unused for longest make room.
    """

    name: str
    most_bytes: int

    @property
    def folder(self) -> Path | None:
        """Where the files are; None where nothing is to be kept."""
        named = os.environ.get(FOLDER_VARIABLE)
        if named is not None:
            return Path(named) / self.name if named else None
        from platformdirs import user_cache_path

        return user_cache_path("touchwarp") / self.name

    def load(self, key: str) -> dict[str, NDArray[Any]] | None:
        """What is kept under a key; None where nothing is, or it is damaged."""
        folder = self.folder
        if folder is None:
            return None
        path = folder / (key + SUFFIX)
        try:
            content = path.read_bytes()
        except OSError:
            return None
        archive = content[_DIGEST_BYTES:]
        if hashlib.sha256(archive).digest() != content[:_DIGEST_BYTES]:
            return None
        with suppress(OSError):  # a folder that only others may write to serves as well
            os.utime(path)
        with np.load(io.BytesIO(archive), allow_pickle=False) as arrays:
            return dict(arrays)

    def keep(self, key: str, **arrays: NDArray[Any]) -> None:
        """Keep arrays under a key. Where that fails, nothing is kept."""
        folder = self.folder
        if folder is None:
            return
        archive = io.BytesIO()
        np.savez(archive, allow_pickle=False, **arrays)
        content = archive.getbuffer()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with replacing(folder / (key + SUFFIX)) as temporary, temporary.open("wb") as file:
                file.write(hashlib.sha256(content).digest())
                file.write(content)
            self._make_room(folder)
        except (OSError, OutputError) as error:
            _log.info("%s were not kept: %s", self.name, error)

    def _make_room(self, folder: Path) -> None:
        """Remove what goes beyond `most_bytes`, and so what a killed process left half-written."""
        files = [(path, path.stat()) for path in folder.glob("*" + SUFFIX)]
        total = 0
        for path, stat in sorted(files, key=lambda file: -file[1].st_mtime):
            total += stat.st_size
            if total > self.most_bytes:
                path.unlink(missing_ok=True)


def content_key(*parts: str | NDArray[Any]) -> str:
    """The key of what is made of these numbers and words by the code as it is now."""
    digest = hashlib.sha256(_code().encode())
    for part in parts:
        content = part.encode() if isinstance(part, str) else part.tobytes()
        digest.update(f"{len(content)}:".encode())  # no two lists of parts run together alike
        digest.update(content)
    return digest.hexdigest()


@functools.cache
def _code() -> str:
    """What tells apart all that may change a goal by so much as a bit, but for the machine."""
    digest = hashlib.sha256()
    for room in ROOMS:
        for source in sorted((Path(__file__).parent.parent / room).rglob("*.py")):
            digest.update(source.read_bytes())
    versions = [f"{library} {version(library)}" for library in CALCULATING]
    return " ".join([digest.hexdigest(), *versions])
