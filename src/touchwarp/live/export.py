"""A static page: everything in one folder that any web host can serve."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

from touchwarp.errors import LiveError, OutputError
from touchwarp.live.messages import FromServer, Progress
from touchwarp.live.opening import open_workbench
from touchwarp.live.serving import built_page


def export_page(path: Path, folder: Path, progress: Callable[[str, float], None]) -> int:
    """Write the page with a scene, its warp, bases and certificate; recordings stay on the device.

    Args:
        path: a scene file, a warp or bases, as for `open_workbench`; what is missing is solved.
        folder: a new or empty one, or an earlier export, which is replaced.
        progress: told what is being done.

    Returns:
        Bytes written.

    Raises:
        LiveError: the folder is none, or holds something else.
        SceneError, GoalError, SolveError, WarpFileError: the scene cannot be shown.
        OutputError: the folder cannot be written; what was there stays.
    """
    page = built_page()
    if folder.exists() and not folder.is_dir():
        raise LiveError(f"{folder} is a file; give a new or empty folder.")
    if folder.exists() and not (folder / "boot.json").exists() and any(folder.iterdir()):
        raise LiveError(
            f"{folder} holds other files than an exported page; give a new or empty folder."
        )

    def tell(message: FromServer) -> None:
        if isinstance(message, Progress):
            progress(message.step, message.done)

    made: Path | None = None
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        made = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
        shutil.copytree(page, made, dirs_exist_ok=True)
        for name in ("tables", "surfaces"):
            (made / name).mkdir()
        workbench = open_workbench(path, made / "tables", tell, recording=False)
        workbench.finish()
        state = workbench.state.model_copy(update={"live": False, "solvable": False})
        for prop in state.props:
            key = Path(prop.surface).stem
            packed = workbench.surface(key)
            assert packed is not None
            (made / "surfaces" / f"{key}.bin").write_bytes(packed)
        (made / "boot.json").write_text(state.model_dump_json(), encoding="utf-8")
        size = sum(file.stat().st_size for file in made.rglob("*") if file.is_file())
        made.chmod(0o755)
        if folder.exists():
            shutil.rmtree(folder)
        made.rename(folder)
    except OSError as error:
        raise OutputError(
            f"{folder} cannot be written: {error.strerror or error}; "
            "free space there or choose another place."
        ) from error
    finally:
        if made is not None:
            shutil.rmtree(made, ignore_errors=True)
    return size
