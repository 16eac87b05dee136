"""`touchwarp recordings`: what was recorded, and the deletion of one participant."""

from __future__ import annotations

from pathlib import Path

import click

FOLDER = click.option(
    "--folder",
    type=click.Path(path_type=Path),
    default=Path("recordings"),
    show_default=True,
    metavar="DIR",
    help="Where the recordings are.",
)


@click.group("recordings")
def recordings_command() -> None:
    """List what 'touchwarp view' has recorded, write it as CSV, or delete what is one person's."""


@recordings_command.command("list")
@FOLDER
def list_command(folder: Path) -> None:
    """One line a recording: participant, recording, beginning, file."""
    from touchwarp.live.recordings import RecordingStore

    recordings = list(RecordingStore(folder).all())
    if not recordings:
        click.echo(f"No recordings in {folder}; --folder names another place.", err=True)
    for recording in recordings:
        where = recording.whole if recording.ended else f"{recording.folder} (not ended)"
        about = recording.about
        click.echo(f"{recording.participant}  {recording.identifier}  {about['started']}  {where}")


@recordings_command.command(
    "export", epilog="\b\nExample:\n  touchwarp recordings export P7 -o tables"
)
@click.argument("participant")
@FOLDER
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    required=True,
    metavar="DIR",
    help="Where the tables go: DIR/RECORDING/recording.csv and about.json.",
)
def export_command(participant: str, folder: Path, output: Path) -> None:
    """Write every recording of PARTICIPANT that has ended as CSV."""
    from touchwarp.live.csv_files import write_csv
    from touchwarp.live.recordings import RecordingStore

    for recording in RecordingStore(folder).of(participant):
        if recording.ended:
            click.echo(str(write_csv(recording, output / recording.identifier)))
        else:
            click.echo(f"{recording.folder} has not ended and is left out.", err=True)


@recordings_command.command("delete", epilog="\b\nExample:\n  touchwarp recordings delete P7")
@click.argument("participant")
@FOLDER
def delete_command(participant: str, folder: Path) -> None:
    """Delete every recording of PARTICIPANT, at once and for good."""
    from touchwarp.live.recordings import RecordingStore

    count = RecordingStore(folder).delete(participant)
    click.echo(f"Deleted {count} recording{'' if count == 1 else 's'} of {participant}.")
