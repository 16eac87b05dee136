"""A Chromium for the tests, obtained by whatever way there is; it says which was used."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")

# The address bar's own two pages, which every new window would load and which take longer than
# ours; and what playwright turns off, since of two such lists the later alone counts.
WITHOUT = (
    "WebUIOmniboxPopup",
    "WebUIOmniboxAimPopup",
    "AimEnabled",
    "AvoidCorsURLLoaderRestartOnRedirect",
    "AvoidUnnecessaryBeforeUnloadCheckSync",
    "DestroyProfileOnBrowserClose",
    "HttpsFirstBalancedModeAutoEnable",
    "HttpsUpgrades",
    "LensOverlay",
    "MediaRouter",
    "NetworkTimeServiceQuerying",
    "OptimizationHints",
    "PaintHolding",
    "PreconnectToSearch",
    "ThirdPartyStoragePartitioning",
)

# Software rendering, no network but the page's own, no first-run windows.
FLAGS = (
    "--no-sandbox",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    f"--disable-features={','.join(WITHOUT)}",
)


class NoChromiumError(RuntimeError):
    """No way led to a browser; the message tells each that was tried."""


def obtain_chromium() -> tuple[Path | None, str]:
    """The browser's program (None: playwright's own) and where it came from.

    Tried in turn: TOUCHWARP_CHROMIUM, an installed one, the system's package manager when run as
    root, playwright's own download.

    Raises:
        NoChromiumError: all of these failed.
    """
    tried: list[str] = []
    named = os.environ.get("TOUCHWARP_CHROMIUM")
    if named:
        if Path(named).is_file():
            return Path(named), f"{named}, from TOUCHWARP_CHROMIUM"
        tried.append(f"TOUCHWARP_CHROMIUM is {named}, which is no file")
    installed = find_installed()
    if installed is not None:
        return installed, f"{installed}, installed"
    tried.append(f"none of {', '.join(NAMES)} is on the PATH")
    if hasattr(os, "geteuid") and os.geteuid() == 0 and shutil.which("apt-get"):
        for command in (
            ["apt-get", "update", "-qq"],
            ["apt-get", "install", "-y", "-qq", NAMES[0]],
        ):
            done = subprocess.run(
                command,
                capture_output=True,
                text=True,
                env=os.environ | {"DEBIAN_FRONTEND": "noninteractive"},
            )
        installed = find_installed()
        if installed is not None:
            return installed, f"{installed}, installed now by apt-get"
        tried.append(f"apt-get install chromium ended with {done.returncode}: {done.stderr[-300:]}")
    else:
        tried.append("apt-get is missing or this is not root")
    done = subprocess.run(
        [sys.executable, "-m", "playwright", "install", "chromium"], capture_output=True, text=True
    )
    if done.returncode == 0:
        return None, "playwright's own download"
    tried.append(f"playwright install ended with {done.returncode}: {done.stderr[-300:]}")
    raise NoChromiumError(
        "The browser tests need Chromium or Chrome, and none was to be had: "
        + "; ".join(tried)
        + ". Install one, or name its program in TOUCHWARP_CHROMIUM."
    )


def find_installed() -> Path | None:
    """The first Chromium or Chrome on the PATH."""
    found = next((path for path in map(shutil.which, NAMES) if path), None)
    return None if found is None else Path(found)


if __name__ == "__main__":
    print(f"browser tests run in {obtain_chromium()[1]}")
