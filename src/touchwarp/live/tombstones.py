"""What remains of a participant whose recordings were deleted: that they were, and when.

    FOLDER/.deleted/PARTICIPANT.json    the pseudonym, the time, the names of the recordings

A page that was away may come back with chunks that the server never had. Without these notes it
would begin the recording anew, and what was deleted would be there again.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path
from typing import TypedDict

from touchwarp.outputs import claim_folder, replacing

_FOLDER = ".deleted"


class _Note(TypedDict):
    participant: str
    deleted: str
    recordings: list[str]


class Tombstones:
    """The deletions of one folder of recordings."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder / _FOLDER

    def set(self, participant: str, recordings: Iterable[str]) -> None:
        """Note that these recordings of a participant, and all begun before now, are deleted.

        Raises:
            OutputError: the folder cannot be written to.
        """
        path = claim_folder(self.folder) / f"{participant}.json"
        before = _read(path)
        note: _Note = {
            "participant": participant,
            "deleted": datetime.now(UTC).isoformat(timespec="milliseconds"),
            "recordings": sorted({*(before["recordings"] if before else ()), *recordings}),
        }
        with replacing(path) as temporary:
            temporary.write_text(json.dumps(note, indent=1), encoding="utf-8")

    def hold(self, recording: str) -> bool:
        """Whether the recording of this name was deleted."""
        notes = map(_read, self.folder.glob("[!.]*.json"))
        return any(note is not None and recording in note["recordings"] for note in notes)

    def hold_begun(self, participant: str, recording: str, started: str) -> bool:
        """Whether a recording was deleted before the server had heard of it: it was begun earlier.

        Args:
            started: as the page's clock had it, ISO 8601; one that is no time is taken for new.
        """
        if self.hold(recording):
            return True
        note = _read(self.folder / f"{participant}.json")
        try:
            return note is not None and _time(started) < _time(note["deleted"])
        except ValueError:
            return False


def _read(path: Path) -> _Note | None:
    try:
        note: _Note = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
    return note


def _time(text: str) -> datetime:
    time = datetime.fromisoformat(text)
    return time if time.tzinfo else time.replace(tzinfo=UTC)
