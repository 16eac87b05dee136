"""Outputs are refused before the work, and are whole or absent after it."""

from __future__ import annotations

import os
import signal
import threading
from pathlib import Path

import pytest

from touchwarp.errors import OutputError
from touchwarp.outputs import claim, claim_folder, replacing


def test_claiming_leaves_nothing_behind(tmp_path: Path) -> None:
    assert claim(tmp_path / "mug.warp") == tmp_path / "mug.warp"
    assert list(tmp_path.iterdir()) == []


def test_claiming_keeps_an_old_file_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "mug.warp").write_text("old")
    claim(tmp_path / "mug.warp")
    assert (tmp_path / "mug.warp").read_text() == "old"


def test_a_folder_is_no_output(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="is a folder; the name of a file is needed"):
        claim(tmp_path)


def test_an_input_is_no_output(tmp_path: Path) -> None:
    scene = tmp_path / "mug.toml"
    scene.write_text("")
    with pytest.raises(OutputError, match="is also an input, which writing would destroy"):
        claim(tmp_path / "." / "mug.toml", scene)


def test_a_missing_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="nowhere does not exist; make that folder"):
        claim(tmp_path / "nowhere" / "mug.warp")


def test_a_file_is_no_folder(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="file is a file, not a folder; make that folder"):
        claim(tmp_path / "file" / "mug.warp")
    with pytest.raises(OutputError, match=r"The folder .*file cannot be made: .*choose another"):
        claim_folder(tmp_path / "file")


def test_a_place_where_no_file_can_be_made_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Permissions do not stop root, so the refusal itself is played.
    def refuse(*arguments: object, **keywords: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)
    with pytest.raises(OutputError, match=r"mug\.warp cannot be written: Permission denied"):
        claim(tmp_path / "mug.warp")


def test_folders_are_made_with_their_parents(tmp_path: Path) -> None:
    claim_folder(tmp_path / "a" / "b")
    assert (tmp_path / "a" / "b").is_dir()


def test_a_file_appears_whole(tmp_path: Path) -> None:
    output = tmp_path / "out.csv"
    with replacing(output) as temporary:
        temporary.write_text("half")
        assert not output.exists()
        temporary.write_text("whole")
    assert output.read_text() == "whole"
    assert output.stat().st_mode & 0o777 == 0o666 & ~_umask()
    assert list(tmp_path.iterdir()) == [output]


def test_a_writer_that_narrows_the_mode_does_not_hide_the_file(tmp_path: Path) -> None:
    output = tmp_path / "mug.warp"
    with replacing(output) as temporary:
        temporary.chmod(0o600)
    assert output.stat().st_mode & 0o777 == 0o666 & ~_umask()


@pytest.mark.parametrize("error", [KeyboardInterrupt, SystemExit, ValueError])
def test_an_interrupted_file_leaves_the_old_one(tmp_path: Path, error: type[BaseException]) -> None:
    output = tmp_path / "out.csv"
    output.write_text("old")
    with pytest.raises(error), replacing(output) as temporary:
        temporary.write_text("half")
        raise error
    assert output.read_text() == "old"
    assert list(tmp_path.iterdir()) == [output]


def test_a_full_disk_is_an_output_error(tmp_path: Path) -> None:
    with (
        pytest.raises(OutputError, match="cannot be written: No space left on device; free space"),
        replacing(tmp_path / "out.csv"),
    ):
        raise OSError(28, "No space left on device")
    assert list(tmp_path.iterdir()) == []


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def test_ctrl_c_waits_for_the_file_to_be_whole(tmp_path: Path) -> None:
    written = False
    with pytest.raises(KeyboardInterrupt), replacing(tmp_path / "a") as temporary:
        signal.raise_signal(signal.SIGINT)
        temporary.write_text("whole")
        written = True
    assert written
    assert (tmp_path / "a").read_text() == "whole"
    assert os.listdir(tmp_path) == ["a"]


def test_a_second_ctrl_c_stops_the_writing(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("old")
    with pytest.raises(KeyboardInterrupt), replacing(tmp_path / "a") as temporary:
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        temporary.write_text("never")
    assert (tmp_path / "a").read_text() == "old"
    assert os.listdir(tmp_path) == ["a"]


def test_other_threads_write_without_touching_signals(tmp_path: Path) -> None:
    before = signal.getsignal(signal.SIGINT)
    writing = threading.Thread(target=claim, args=(tmp_path / "a",))
    writing.start()
    writing.join()
    assert signal.getsignal(signal.SIGINT) is before
