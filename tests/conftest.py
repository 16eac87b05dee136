"""What all tests share: where the mesh and reference files that are not in the checkout stand."""

from __future__ import annotations

import os
import signal
import tempfile
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).resolve().parent.parent
SHARED = Path(os.environ.get("TOUCHWARP_SHARED", CHECKOUT.parent / "shared"))


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder with data/ (meshes) and reference/ (fields); use with `needs_shared_data`."""
    return SHARED


def pytest_configure(config: pytest.Config) -> None:
    """One cache for all processes of a run, of which the user's knows nothing.

    Ctrl-C is heard even where the tests run in the background, whose shell has turned it off.
    """
    if not hasattr(config, "workerinput"):
        cache = tempfile.TemporaryDirectory(prefix="touchwarp-cache-")
        config.add_cleanup(cache.cleanup)
        os.environ["TOUCHWARP_CACHE"] = cache.name
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    if (SHARED / "data").is_dir():
        return
    missing = pytest.mark.skip(reason=f"{SHARED} has no data; set TOUCHWARP_SHARED to where it is")
    for item in items:
        if "needs_shared_data" in item.keywords:
            item.add_marker(missing)
