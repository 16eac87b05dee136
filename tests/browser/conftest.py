"""A real browser for the tests of the page; see chromium.py for where it comes from."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

from tests.browser.chromium import FLAGS, obtain_chromium

SHOTS = Path(__file__).resolve().parents[2] / "build" / "screenshots"


@pytest.fixture(scope="session")
def chromium(pytestconfig: pytest.Config) -> Iterator[Browser]:
    """The browser, started once."""
    program, source = obtain_chromium()
    reporter = pytestconfig.pluginmanager.get_plugin("terminalreporter")
    if reporter is not None:
        reporter.write_line(f"\nbrowser tests run in {source}")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=list(FLAGS))
        yield browser
        browser.close()


@pytest.fixture
def page(chromium: Browser) -> Iterator[Page]:
    """A fresh tab, 1440 × 900; errors that its scripts throw or log fail the test."""
    context = chromium.new_context(
        viewport={"width": 1440, "height": 900}, ignore_https_errors=True
    )
    tab = context.new_page()
    tab.set_default_timeout(20_000)
    errors: list[str] = []
    tab.on("pageerror", lambda error: errors.append(str(error)))
    tab.on("console", lambda line: errors.append(line.text) if line.type == "error" else None)
    tab.expected_errors = []  # type: ignore[attr-defined]
    yield tab
    expected = tab.expected_errors  # type: ignore[attr-defined]
    context.close()
    assert [e for e in errors if not any(word in e for word in expected)] == []


@pytest.fixture(scope="session")
def screenshots() -> Path:
    """A folder, outside version control, where tests leave pictures to look at."""
    SHOTS.mkdir(parents=True, exist_ok=True)
    return SHOTS
