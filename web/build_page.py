"""Build the page into the package: python web/build_page.py

It goes to src/touchwarp/live/page/, from where `touchwarp view` serves it and the wheel takes it.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from npm import WEB, NoNodeError, npm

PAGE = WEB.parent / "src" / "touchwarp" / "live" / "page"
INSTALLED = WEB / "node_modules" / ".installed"


def build_page() -> Path:
    """Install what the page needs, where that is not done yet, and build it.

    Raises:
        NoNodeError: there is no Node.js.
        RuntimeError: npm failed.
    """
    if not _installed():
        _npm("ci", "--silent", "--no-progress")
        INSTALLED.touch()
    _npm("run", "--silent", "build", "--workspace", "page")
    if not (PAGE / "index.html").exists():
        raise RuntimeError(f"The page was built, but {PAGE} has no index.html.")
    return PAGE


def _installed() -> bool:
    if not INSTALLED.exists():
        return False
    since = INSTALLED.stat().st_mtime
    asked = [WEB / "package.json", WEB / "package-lock.json", *WEB.glob("*/package.json")]
    return all(path.stat().st_mtime <= since for path in asked)


def _npm(*arguments: str) -> None:
    if npm(*arguments) != 0:
        raise RuntimeError(
            f"'npm {' '.join(arguments)}' failed in {WEB}: see above. Its packages come from the "
            "npm registry, so a network is needed the first time."
        )


if __name__ == "__main__":
    try:
        print(build_page())
    except (NoNodeError, RuntimeError) as error:
        sys.exit(str(error))
