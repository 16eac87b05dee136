"""Build the wheel and use it outside the checkout: what it holds, and that it works.

The wheel is installed into a new environment that borrows the development environment's
dependencies but neither its touchwarp nor the checkout, so a file that was forgotten in the wheel
is missed here and not by the first user.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parent.parent
PACKAGE = CHECKOUT / "src" / "touchwarp"

# In the plane, since that solves without the compiled kernels of space, which a new installation
# would first have to compile.
SCENE = CHECKOUT / "examples" / "coaster.toml"


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
    for name in ("pyproject.toml", "README.md", "LICENSE"):
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
