"""A recording as the page of any web host saves it: its rows as CSV, and what is told of it.

recording.csv    the columns of recording.parquet, in its order; float64 to the last bit
about.json       who (pseudonym), when, which columns, notes
"""

from __future__ import annotations

import json
from pathlib import Path

import pyarrow.parquet as pq
from pyarrow import csv

from touchwarp.errors import StudyError
from touchwarp.live.recordings import Recording
from touchwarp.outputs import claim_folder, replacing


def write_csv(recording: Recording, folder: Path) -> Path:
    """Write one recording as `recording.csv` and `about.json`.

    Args:
        recording: ended.
        folder: is made where it is missing.

    Returns:
        The CSV file.

    Raises:
        StudyError: the recording has not ended.
        OutputError: the folder cannot be written to.
    """
    if not recording.ended:
        raise StudyError(
            f"The recording {recording.identifier} of {recording.participant} has not ended; "
            "end it on its page first."
        )
    claim_folder(folder)
    target = folder / "recording.csv"
    with replacing(target) as temporary:
        csv.write_csv(pq.read_table(recording.whole), temporary)
    with replacing(folder / "about.json") as temporary:
        temporary.write_text(json.dumps(recording.about, indent=1), encoding="utf-8")
    return target
