"""Build the wheel and use it outside the checkout: what it holds, and that it works.

The wheel is installed into a new environment that borrows the development environment's
dependencies but neither its touchwarp nor the checkout, so a file that was forgotten in the wheel
is missed here and not by the first user.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import urllib.parse
import urllib.request
import zipfile
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parent.parent
PACKAGE = CHECKOUT / "src" / "touchwarp"

# In the plane, since that solves without the compiled kernels of space, which a new installation
# would first have to compile.
SCENE = CHECKOUT / "examples" / "coaster.toml"

PAGE = "touchwarp/live/page/index.html"
SHOWN = CHECKOUT / "examples" / "mug_as_cup.toml"


def main() -> None:
    with tempfile.TemporaryDirectory(prefix="touchwarp-wheel-") as name:
        folder = Path(name)
        wheel = build(folder)
        check_contents(wheel)
        use(install(wheel, folder / "environment"), folder)
    print(f"{wheel.name} builds, holds every file and works outside the checkout.")


def build(folder: Path) -> Path:
    # From a copy: a build in the checkout would leave a folder there, and put what an older build
    # has left in it into the wheel.
    source = folder / "source"
    ignored = shutil.ignore_patterns("__pycache__", "*.egg-info")
    shutil.copytree(CHECKOUT / "src", source / "src", ignore=ignored)
    shutil.rmtree(source / "src" / "touchwarp" / "live" / "page", ignore_errors=True)
    unbuilt = shutil.ignore_patterns("__pycache__", "node_modules", "dist")
    shutil.copytree(CHECKOUT / "web", source / "web", ignore=unbuilt)
    packages = CHECKOUT / "web" / "node_modules"
    if packages.exists():  # borrowed, as the environment's dependencies are; else npm fetches them
        (source / "web" / "node_modules").symlink_to(packages, target_is_directory=True)
    for name in ("pyproject.toml", "MANIFEST.in", "README.md", "LICENSE"):
        shutil.copy(CHECKOUT / name, source)
    run(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", folder, source)
    (wheel,) = folder.glob("touchwarp-*.whl")
    return wheel


def check_contents(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        held = set(archive.namelist())
    tracked = run("git", "ls-files", "--", PACKAGE, cwd=CHECKOUT).split()
    needed = [name for name in tracked if (CHECKOUT / name).exists()]
    missing = [name for name in needed if name.removeprefix("src/") not in held]
    if PAGE not in held:
        sys.exit(f"{wheel.name} lacks the page, {PAGE}: see web/wheel_backend.py.")
    foreign = [name for name in held if "node_modules" in name or name.startswith("web/")]
    if foreign:
        sys.exit(f"{wheel.name} holds what only builds the page: {', '.join(foreign)}.")
    if missing:
        sys.exit(f"{wheel.name} lacks {', '.join(missing)}: see package-data in pyproject.toml.")


def install(wheel: Path, environment: Path) -> Path:
    """The folder of the environment's commands."""
    run(sys.executable, "-m", "venv", "--without-pip", environment)
    python = environment / "bin" / "python"
    run(
        *(sys.executable, "-m", "pip", "--python", python, "--quiet"),
        *("--disable-pip-version-check", "install", "--no-deps", wheel),
    )
    packages = Path(
        run(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))").strip()
    )
    # A path in a .pth file is searched, but .pth files found there are not read: the development
    # environment's link to the checkout stays out of sight.
    borrowed = {sysconfig.get_path("purelib"), sysconfig.get_path("platlib")}
    (packages / "borrowed.pth").write_text("\n".join(sorted(borrowed)) + "\n")
    return environment / "bin"


def use(commands: Path, folder: Path) -> None:
    where = run(
        commands / "python", "-c", "import touchwarp; print(touchwarp.__file__)", cwd=folder
    )
    if str(CHECKOUT) in where:
        sys.exit(f"The wheel was not used but the checkout: {where.strip()}.")
    touchwarp = commands / "touchwarp"
    run(touchwarp, "--version", cwd=folder)
    run(touchwarp, "solve", SCENE, "-o", "coaster.warp", cwd=folder)
    run(touchwarp, "check", SCENE, "coaster.warp", "--html", "coaster.html", cwd=folder)
    if (folder / "coaster.html").stat().st_size == 0:
        sys.exit("The report is empty.")
    look(touchwarp)


def look(touchwarp: Path) -> None:
    """The installed page is served with all its parts, from the first second on."""
    command = [touchwarp, "view", SHOWN, "--no-browser", "--port", "0"]
    environment = os.environ | {"PYTHONUNBUFFERED": "1"}
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
    try:
        assert server.stdout is not None
        address = re.search(r"http://localhost:\d+/?", server.stdout.readline())
        if address is None:
            sys.exit("touchwarp view did not tell its address.")
        page = fetch(address[0])
        parts = re.findall(r'(?:src|href)="(\./[^"]+)"', page)
        if not any(part.endswith(".js") for part in parts):
            sys.exit(f"The page has no script: {page}")
        for part in (*parts, "boot.json"):
            fetch(urllib.parse.urljoin(f"{address[0].rstrip('/')}/", part))
    finally:
        server.terminate()
        server.communicate(timeout=60)


def fetch(address: str) -> str:
    with urllib.request.urlopen(address, timeout=60) as answer:
        text: str = answer.read().decode()
    if not text:
        sys.exit(f"{address} is empty.")
    return text


def run(*command: str | Path, cwd: Path | None = None) -> str:
    done = subprocess.run([str(part) for part in command], cwd=cwd, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(
            f"{' '.join(str(part) for part in command)}\nended with {done.returncode}:\n"
            f"{done.stdout}{done.stderr}"
        )
    return done.stdout


if __name__ == "__main__":
    main()
