"""The command's face: help, version, exit codes, what it says when something goes wrong."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import click
import pytest

import touchwarp
from touchwarp.cli import main as entry
from touchwarp.cli.main import main
from touchwarp.errors import SceneError

COMMANDS = ["solve", "check", "sample", "table", "info", "demo"]


@contextmanager
def command_that_raises(error: BaseException) -> Iterator[None]:
    @click.command("break")
    def command() -> None:
        raise error

    entry.touchwarp.add_command(command)
    try:
        yield
    finally:
        del entry.touchwarp.commands["break"]


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"touchwarp {touchwarp.__version__}\n"


def test_help_names_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    told = capsys.readouterr().out
    assert [name for name in COMMANDS if f"\n  {name} " not in told] == []
    assert "Examples:" in told


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_a_command_has_examples(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, "-h"]) == 0
    assert f"touchwarp {command}" in capsys.readouterr().out.partition("Examples:")[2]


@pytest.mark.parametrize("arguments", [["sole"], ["solve"], ["solve", "--tolerence", "1"]])
def test_a_wrong_call_is_bad_input(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    assert "Error: " in capsys.readouterr().err


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [
        (SceneError("No props; one is needed."), 2, "Error: No props; one is needed.\n"),
        (MemoryError(), 2, "Error: The machine ran out of memory; ask for a larger"),
        (KeyboardInterrupt(), 130, "Interrupted; nothing half-written was left behind"),
        (RuntimeError("who knows"), 70, "That is a defect of touchwarp: please report it"),
    ],
)
def test_exit_codes(
    error: BaseException, code: int, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with command_that_raises(error):
        assert main(["break"]) == code
    told = capsys.readouterr().err
    assert message in told
    assert ("Traceback" in told) == (code == 70)


def test_a_closed_reader_is_no_failed_check() -> None:
    script = (
        "import sys, click\n"
        "from touchwarp.cli import main as entry\n"
        "@click.command('flood')\n"
        "def flood():\n"
        "    for _ in range(100000): print('0,0,0')\n"
        "entry.touchwarp.add_command(flood)\n"
        "sys.exit(entry.main(['flood']))\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.readline()
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait() == 141


def test_python_m_touchwarp_is_the_command() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "touchwarp", "--version"], check=True, capture_output=True, text=True
    )
    assert done.stdout == f"touchwarp {touchwarp.__version__}\n"
