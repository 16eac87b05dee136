"""Recordings of people's hands: begun with consent, kept by pseudonym, deleted by one command.

    FOLDER/PARTICIPANT/RECORDING/about.json           who (pseudonym), when, which columns, notes
    FOLDER/PARTICIPANT/RECORDING/000017.parquet       chunk 17, while the recording goes on
    FOLDER/PARTICIPANT/RECORDING/recording.parquet    all of it, when it has ended
    FOLDER/.deleted/PARTICIPANT.json                  that a participant's were deleted, and when

A chunk is on disk before it is acknowledged, and writing one again changes nothing, so a page that
lost its connection repeats what was not acknowledged and nothing is lost or doubled.
"""

from __future__ import annotations

import json
import re
import shutil
import uuid
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from touchwarp.errors import StudyError
from touchwarp.live.messages import PARTICIPANT, BeginRecording, ChunkHeader, EndRecording
from touchwarp.live.tombstones import Tombstones
from touchwarp.outputs import claim_folder, replacing

_ABOUT, _WHOLE = "about.json", "recording.parquet"
_ROWS_A_GROUP = 4096


@dataclass(frozen=True)
class Recording:
    """One recording on disk."""

    participant: str
    identifier: str
    folder: Path

    @property
    def about(self) -> dict[str, Any]:
        """What was told at its beginning, and notes."""
        return dict(json.loads((self.folder / _ABOUT).read_text(encoding="utf-8")))

    @property
    def whole(self) -> Path:
        """The file of a recording that has ended."""
        return self.folder / _WHOLE

    @property
    def ended(self) -> bool:
        """Whether it is whole."""
        return self.whole.exists()

    def chunks(self) -> dict[int, Path]:
        """Chunks not yet joined, by number."""
        return {int(p.stem): p for p in sorted(self.folder.glob("[0-9]*.parquet"))}

    def rows(self) -> tuple[list[str], NDArray[np.float64]]:
        """Names of the numeric columns and all rows so far, (n, columns) float64."""
        names = list(self.about["columns"])
        try:
            files = [self.whole] if self.ended else list(self.chunks().values())
            tables = [pq.read_table(path, columns=names) for path in files]
        except FileNotFoundError:  # it ended meanwhile: chunks go once the whole file stands
            tables = [pq.read_table(self.whole, columns=names)]
        if not tables:
            return names, np.empty((0, len(names)))
        table = pa.concat_tables(tables)
        return names, np.stack([table[name].to_numpy() for name in names], axis=1)


class DeletedRecordingError(StudyError):
    """A page brings more of a recording that has been deleted."""


class RecordingStore:
    """The recordings below one folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._tombstones = Tombstones(folder)

    def begin(self, begin: BeginRecording, version: str) -> None:
        """Make room for a recording; a repeated call changes nothing.

        Raises:
            StudyError: a recording of that name was begun in another way.
            DeletedRecordingError: it was deleted, or begun before its participant's were.
            OutputError: the folder cannot be written to.
        """
        if len(set(begin.columns)) != len(begin.columns) or not begin.columns:
            raise StudyError("The columns of a recording need names, each another one.")
        if {"warp", "chunk"} & set(begin.columns):
            raise StudyError("'warp' and 'chunk' are columns of the server's own; rename yours.")
        about = {
            "participant": begin.participant,
            "recording": begin.recording,
            "consent": begin.consent,
            "started": begin.started,
            "device": begin.device,
            "touchwarp_version": version,
            "columns": list(begin.columns),
        }
        if self._tombstones.hold_begun(begin.participant, begin.recording, begin.started):
            raise DeletedRecordingError(_deleted(begin.recording))
        known = self._find(begin.recording)
        if known is not None:
            if {k: known.about.get(k) for k in about} != about:
                raise StudyError(
                    f"The recording {begin.recording} was begun before with other values; "
                    "begin one with a new name."
                )
            return
        folder = claim_folder(self.folder / begin.participant / begin.recording)
        with replacing(folder / _ABOUT) as temporary:
            temporary.write_text(json.dumps(about | {"notes": []}, indent=1), encoding="utf-8")

    def append(self, header: ChunkHeader, rows: NDArray[np.float64]) -> None:
        """Put one chunk on disk, unless it is there already.

        Args:
            header: which chunk of which recording.
            rows: (header.rows, columns) float64.

        Raises:
            StudyError: the recording was not begun, or the rows do not fit its columns.
            DeletedRecordingError: it was deleted.
            OutputError: the disk is full, or alike.
        """
        recording = self._known(header.recording)
        path = recording.folder / f"{header.sequence:06d}.parquet"
        if recording.ended or path.exists():
            return
        columns = recording.about["columns"]
        if header.rows == 0:  # notes alone
            rows = np.empty((0, len(columns)))
        if rows.shape != (header.rows, len(columns)):
            raise StudyError(
                f"A chunk of {rows.size} numbers came where {header.rows} rows of {len(columns)} "
                "columns were announced."
            )
        arrays = [pa.array(np.ascontiguousarray(rows[:, i])) for i in range(len(columns))]
        warp = pa.array([header.warp] * header.rows, pa.string()).dictionary_encode()
        chunk = pa.array(np.full(header.rows, header.sequence, np.int32))
        table = pa.table([*arrays, warp, chunk], names=[*columns, "warp", "chunk"])
        table = table.replace_schema_metadata({"notes": json.dumps(list(header.notes))})
        with replacing(path) as temporary:
            pq.write_table(table, temporary, compression="zstd")

    def end(self, end: EndRecording) -> Path:
        """Join the chunks to one file; a repeated call changes nothing.

        Raises:
            StudyError: the recording was not begun, or chunks are still missing.
            DeletedRecordingError: it was deleted.
        """
        recording = self._known(end.recording)
        if recording.ended:
            return recording.whole
        chunks = recording.chunks()
        missing = sorted(set(range(end.chunks)) - set(chunks))
        if missing:
            raise StudyError(
                f"The recording {end.recording} lacks {len(missing)} of {end.chunks} chunks, "
                f"the first is {missing[0]}; send them again."
            )
        about = recording.about
        about["notes"] = [
            {"chunk": number, "text": text}
            for number, path in chunks.items()
            for text in json.loads((pq.read_schema(path).metadata or {}).get(b"notes", b"[]"))
        ]
        with replacing(recording.folder / _ABOUT) as temporary:
            temporary.write_text(json.dumps(about, indent=1), encoding="utf-8")
        if chunks:
            _join(list(chunks.values()), recording.whole, about)
        for path in chunks.values():
            path.unlink()
        return recording.whole

    def all(self) -> Iterator[Recording]:
        """Every recording, by participant and name."""
        for about in sorted(self.folder.glob(f"[!.]*/*/{_ABOUT}")):
            yield Recording(about.parent.parent.name, about.parent.name, about.parent)

    def of(self, participant: str) -> list[Recording]:
        """Every recording of one participant.

        Raises:
            StudyError: there is no such participant.
        """
        known = sorted({r.participant for r in self.all()})
        if not re.fullmatch(PARTICIPANT, participant) or participant not in known:
            raise StudyError(
                f"No participant '{participant}' has recordings in {self.folder}; "
                + (f"there are {', '.join(known)}." if known else "there are none at all.")
            )
        return [r for r in self.all() if r.participant == participant]

    def delete(self, participant: str) -> int:
        """Delete everything of one participant; how many recordings that were.

        What a page still holds of them is not taken any more, and the page told so.

        Raises:
            StudyError: there is no such participant.
        """
        names = [r.identifier for r in self.of(participant)]
        self._tombstones.set(participant, names)  # first: a chunk may come at any moment
        gone = self.folder / f".{participant}.{uuid.uuid4().hex}"
        (self.folder / participant).rename(gone)  # at once, whatever is being written in it
        shutil.rmtree(gone)
        return len(names)

    def _find(self, identifier: str) -> Recording | None:
        return next((r for r in self.all() if r.identifier == identifier), None)

    def _known(self, identifier: str) -> Recording:
        recording = self._find(identifier)
        if self._tombstones.hold(identifier):
            raise DeletedRecordingError(_deleted(identifier))
        if recording is None:
            raise StudyError(f"No recording {identifier} was begun; begin it first.")
        return recording


def _deleted(identifier: str) -> str:
    return (
        f"The recording {identifier} was deleted with all of its participant's; "
        "what is left of it on the device is deleted, too."
    )


def _join(chunks: list[Path], whole: Path, about: dict[str, Any]) -> None:
    """One Parquet file of many, some thousand rows at a time."""
    metadata = {"touchwarp": json.dumps(about)}
    schema = pq.read_schema(chunks[0]).with_metadata(metadata)
    with (
        replacing(whole) as temporary,
        pq.ParquetWriter(temporary, schema, compression="zstd") as writer,
    ):
        waiting: list[pa.Table] = []
        for path in chunks:
            waiting.append(pq.read_table(path).replace_schema_metadata(metadata))
            if sum(len(table) for table in waiting) >= _ROWS_A_GROUP:
                writer.write_table(pa.concat_tables(waiting))
                waiting.clear()
        if waiting:
            writer.write_table(pa.concat_tables(waiting))
