"""One browser and one server for all tests of the page; each test has a page of its own, which is watched.

A test fails by itself if its page says anything in the console, throws, or asks for what fails or lies elsewhere:

    def test_page_shows_its_title(opened):
        page = opened()
        assert "eulerdisk" in page.title()

`opened(fragment="", url=None, **options)` opens the page and waits until its picture is complete; `explorer` is the
server of the presets (`explorer.url`), `served_with("file.nc")` one with other words. Options are those of a context:
`viewport={"width": 360, "height": 740}`, `color_scheme="dark"`, `has_touch=True`; `reduced_motion` is "reduce"
unless another is given, so that motions stand until they are played.
"""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import TYPE_CHECKING

import pytest
from explorer_browser import BROWSERS, COMPLETE, Served, Watch, find_browser, launched, served

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page


#: Milliseconds that anything in a page may take; processors of tests are busy.
PATIENCE = 20_000


@pytest.fixture(scope="package")
def browser() -> Iterator[Browser]:
    """Run a browser without a window for all tests of the package."""
    executable = find_browser()
    missing = []
    if executable is None:
        missing.append(f"none of {', '.join(BROWSERS)} (scripts/test --readers installs one)")
    if importlib.util.find_spec("playwright") is None:
        missing.append("no driver (pip install playwright)")
    if missing:
        message = f"no browser: {' and '.join(missing)}"
        pytest.fail(message) if os.environ.get("CI") == "true" else pytest.skip(message)
    with launched(executable) as running:
        yield running


@pytest.fixture(scope="package")
def explorer() -> Iterator[Served]:
    """Run the explorer of the presets for all tests of the package."""
    with served() as running:
        yield running


@pytest.fixture
def served_with() -> Iterator[Callable[..., Served]]:
    """Return a function that runs an explorer with other words, until the test ends."""
    with ExitStack() as stack:
        yield lambda *words: stack.enter_context(served(*map(str, words)))


@pytest.fixture
def opened(
    browser: Browser, request: pytest.FixtureRequest, served_with: Callable[..., Served]
) -> Iterator[Callable[..., Page]]:
    """Return a function that opens the page in a context of its own, and waits until its picture is complete.

    Pages load the modules of motions after their first picture: every server ends after the pages that it served.
    """
    del served_with
    watches = []
    with ExitStack() as stack:

        def open_page(fragment: str = "", url: str | None = None, **options: object) -> Page:
            address = url or request.getfixturevalue("explorer").url
            options.setdefault("viewport", {"width": 1280, "height": 800})
            # a frame of a disk takes 0.1 s without a graphics card: motions stand until they are played
            options.setdefault("reduced_motion", "reduce")
            context = browser.new_context(**options)
            stack.callback(context.close)
            page = context.new_page()
            page.set_default_timeout(PATIENCE)
            watches.append(Watch(page, (address,)))
            page.goto(address + (f"#{fragment}" if fragment else ""))
            page.wait_for_selector(COMPLETE)
            return page

        yield open_page
    problems = [problem for watch in watches for problem in watch.problems]
    assert problems == [], "\n".join(problems)
