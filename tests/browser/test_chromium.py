"""The order in which a browser for these tests is sought, with each way there is faked."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.browser.chromium import NoChromiumError, obtain_chromium


class Machine:
    """What is on the PATH, who runs this, and which commands work; it notes those that were run."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.installed: dict[str, str] = {}
        self.root = False
        self.packages: dict[str, str] = {}
        self.downloads = False
        self.run: list[list[str]] = []
        monkeypatch.delenv("TOUCHWARP_CHROMIUM", raising=False)
        monkeypatch.setattr(shutil, "which", self.installed.get)
        monkeypatch.setattr(os, "geteuid", lambda: 0 if self.root else 1000, raising=False)
        monkeypatch.setattr(subprocess, "run", self._run)

    def _run(self, command: list[str], **_: object) -> subprocess.CompletedProcess[str]:
        self.run.append(command)
        works = self.downloads if command[0] == sys.executable else True
        if command[:2] == ["apt-get", "install"]:
            found = self.packages.get(command[-1])
            works = found is not None
            if found is not None:
                self.installed[command[-1]] = found
        return subprocess.CompletedProcess(command, 0 if works else 100, "", "it does not work")


@pytest.fixture
def machine(monkeypatch: pytest.MonkeyPatch) -> Machine:
    return Machine(monkeypatch)


def test_the_one_that_is_named_comes_first(
    machine: Machine, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    machine.installed["chromium"] = "/usr/bin/chromium"
    named = tmp_path / "my-chrome"
    named.touch()
    monkeypatch.setenv("TOUCHWARP_CHROMIUM", str(named))
    assert obtain_chromium() == (named, f"{named}, from TOUCHWARP_CHROMIUM")
    named.unlink()
    assert obtain_chromium() == (Path("/usr/bin/chromium"), "/usr/bin/chromium, installed")
    assert machine.run == []


def test_one_that_is_installed_is_taken_as_it_is(machine: Machine) -> None:
    machine.root, machine.downloads = True, True
    machine.installed |= {"apt-get": "/usr/bin/apt-get", "google-chrome": "/opt/chrome"}
    assert obtain_chromium() == (Path("/opt/chrome"), "/opt/chrome, installed")
    machine.installed["chromium"] = "/usr/bin/chromium"
    assert obtain_chromium()[0] == Path("/usr/bin/chromium")
    assert machine.run == []


def test_the_package_manager_is_asked_next_by_root_alone(machine: Machine) -> None:
    machine.installed["apt-get"] = "/usr/bin/apt-get"
    machine.packages["chromium"] = "/usr/bin/chromium"
    machine.downloads = True
    assert obtain_chromium() == (None, "playwright's own download")
    machine.root = True
    machine.run.clear()
    found, source = obtain_chromium()
    assert (found, source) == (Path("/usr/bin/chromium"), f"{found}, installed now by apt-get")
    assert [command[:2] for command in machine.run] == [
        ["apt-get", "update"],
        ["apt-get", "install"],
    ]


def test_playwright_s_download_comes_last(machine: Machine) -> None:
    machine.root, machine.downloads = True, True
    machine.installed["apt-get"] = "/usr/bin/apt-get"  # which has no such package
    assert obtain_chromium() == (None, "playwright's own download")
    assert [command[0] for command in machine.run] == ["apt-get", "apt-get", sys.executable]


def test_where_nothing_works_each_way_is_told(
    machine: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    machine.root = True
    machine.installed["apt-get"] = "/usr/bin/apt-get"
    monkeypatch.setenv("TOUCHWARP_CHROMIUM", "/nowhere/chrome")
    with pytest.raises(NoChromiumError) as error:
        obtain_chromium()
    told = str(error.value)
    steps = (
        "TOUCHWARP_CHROMIUM is /nowhere/chrome, which is no file",
        "none of chromium, chromium-browser",
        "apt-get install chromium ended with 100: it does not work",
        "playwright install ended with 100: it does not work",
        "Install one, or name its program in TOUCHWARP_CHROMIUM.",
    )
    places = [told.find(step) for step in steps]
    assert min(places) >= 0
    assert places == sorted(places)
    machine.root = False
    with pytest.raises(NoChromiumError, match="apt-get is missing or this is not root"):
        obtain_chromium()
