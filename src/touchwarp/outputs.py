"""Output files: known to be writable before the long work, whole or absent after it."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from touchwarp.errors import OutputError


def claim(output: Path, *inputs: Path) -> Path:
    """Make sure, before any work is done, that `output` can be written; leave nothing behind.

    Raises:
        OutputError: it is a folder, is one of the inputs, or its folder is missing or closed.
    """
    if output.is_dir():
        raise OutputError(f"The output {output} is a folder; the name of a file is needed.")
    for path in inputs:
        if output.exists() and path.exists() and output.samefile(path):
            raise OutputError(
                f"The output {output} is also an input, which writing would destroy; "
                "choose another name."
            )
    folder = output.parent
    if not folder.is_dir():
        what = "is a file, not a folder" if folder.exists() else "does not exist"
        raise OutputError(
            f"{output} cannot be written: {folder} {what}; "
            "make that folder or choose another place."
        )
    with replacing(output, keep=False):
        pass
    return output


def claim_folder(folder: Path) -> Path:
    """Make `folder`, with its parents, where it is missing; make sure that files can go there.

    Raises:
        OutputError: it cannot be made or written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(
            f"The folder {folder} cannot be made: {error.strerror}; choose another place."
        ) from error
    claim(folder / "probe")
    return folder


@contextmanager
def replacing(output: Path, keep: bool = True) -> Iterator[Path]:
    """A new empty file that takes `output`'s place when the block ends well, and else vanishes.

    The block shall write and do no long work: Ctrl-C waits for its end.

    Args:
        output: where the file shall be.
        keep: False to let it vanish in any case.

    Raises:
        OutputError: the file cannot be written, for instance because the disk is full.
    """
    temporary = output.with_name(f".{output.stem}.{os.getpid()}{output.suffix}")
    try:
        with _interrupts_held():
            with temporary.open("xb") as file:
                mode = os.fstat(file.fileno()).st_mode
            try:
                yield temporary
                if keep:
                    # a library that wrote through a private file of its own has narrowed the mode
                    temporary.chmod(mode)
                    temporary.replace(output)
            finally:
                temporary.unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(
            f"{output} cannot be written: {error.strerror or error}; "
            "free space there or choose another place."
        ) from error


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Let a first Ctrl-C wait for the block's end: its clean-up must not be cut short.

    A second one stops the block at once. Outside the main thread, which alone gets signals,
    nothing is held.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    pending = False

    def remember(number: int, frame: FrameType | None) -> None:
        nonlocal pending
        pending = True
        signal.signal(signal.SIGINT, before)

    before = signal.getsignal(signal.SIGINT)
    if before is None:  # set outside Python: not ours to replace
        yield
        return
    signal.signal(signal.SIGINT, remember)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
        if pending:
            signal.raise_signal(signal.SIGINT)
