"""setuptools, with the page built before a wheel: what pip calls (PEP 517, PEP 660).

Node.js is taken from the PATH; only where it is missing does pip fetch it, from PyPI. A source
distribution brings the built page along, so that installing it needs no Node.js.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from setuptools import build_meta
from setuptools.build_meta import (  # noqa: F401  (called by pip)
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)

sys.path.insert(0, str(Path(__file__).resolve().parent))

import build_page
import npm

Config = dict[str, Any] | None


def _from_sdist() -> bool:
    """Whether this is an unpacked source distribution, which holds the page built."""
    return (npm.WEB.parent / "PKG-INFO").exists() and (build_page.PAGE / "index.html").exists()


def _requirements(usual: list[str]) -> list[str]:
    if _from_sdist() or npm.node_on_path() is not None:
        return usual
    return [*usual, npm.PACKAGE]


def get_requires_for_build_wheel(config_settings: Config = None) -> list[str]:
    """What the build environment needs."""
    return _requirements(build_meta.get_requires_for_build_wheel(config_settings))


def get_requires_for_build_editable(config_settings: Config = None) -> list[str]:
    """What the build environment needs."""
    return _requirements(build_meta.get_requires_for_build_editable(config_settings))


def get_requires_for_build_sdist(config_settings: Config = None) -> list[str]:
    """What the build environment needs."""
    return _requirements(build_meta.get_requires_for_build_sdist(config_settings))


def build_wheel(
    wheel_directory: str, config_settings: Config = None, metadata_directory: str | None = None
) -> str:
    """A wheel with the page in it."""
    if not _from_sdist():
        build_page.build_page()
    return build_meta.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_editable(
    wheel_directory: str, config_settings: Config = None, metadata_directory: str | None = None
) -> str:
    """A link to the checkout, with the page built in it."""
    build_page.build_page()
    return build_meta.build_editable(wheel_directory, config_settings, metadata_directory)


def build_sdist(sdist_directory: str, config_settings: Config = None) -> str:
    """The sources and the built page (see MANIFEST.in)."""
    build_page.build_page()
    return build_meta.build_sdist(sdist_directory, config_settings)
