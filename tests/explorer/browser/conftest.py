"""One browser and one server for all tests of the page, which each test loads again and watches.

A test fails if its page logs anything to the console, throws, or sends a request that fails or leaves the server:

    def test_page_shows_its_title(opened):
        page = opened()
        assert "eulerdisk" in page.title()

`opened(fragment="", url=None, **options)` opens the page and waits until its picture is complete. `explorer` is the
server of the presets (`explorer.url`), and `served_with("file.nc")` one with other arguments. The options are those of
a context: `viewport={"width": 360, "height": 740}`, `color_scheme="dark"`, `has_touch=True`. By default
`reduced_motion` is "reduce", so that motions stand until they are played.
"""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

import pytest
from explorer_browser import BROWSERS, COMPLETE, Served, Watch, find_browser, launched, served

from tests.explorer.browser.map_page import PATIENCE

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext, Page


#: Tests that share a tab, because opening one takes a second; a tab's history is limited to fifty entries.
SHARED = 8


class Tabs:
    """Tabs of the browser by their context's options, each used by one test at a time."""

    def __init__(self, browser: Browser) -> None:
        self.browser = browser
        self.free: dict[str, list[tuple[Page, int]]] = {}

    def take(self, options: dict[str, Any]) -> tuple[Page, int]:
        """Return a tab in its original state and the number of tests that have used it."""
        free = self.free.setdefault(self._key(options), [])
        if not free:
            page = self.browser.new_context(**options).new_page()
            page.set_default_timeout(PATIENCE)
            return page, 0
        page, used = free.pop()
        page.set_viewport_size(options["viewport"])
        return page, used

    def give_back(self, options: dict[str, Any], page: Page, used: int) -> None:
        """Undo a test's changes to a tab."""
        context: BrowserContext = page.context
        if used + 1 == SHARED:
            context.close()
            return
        for other in context.pages:
            if other is not page:
                other.close()
        context.clear_permissions()
        page.mouse.move(0, 0)
        page.goto("about:blank")
        page.unroute_all(behavior="ignoreErrors")
        self.free[self._key(options)].append((page, used + 1))

    @staticmethod
    def _key(options: dict[str, Any]) -> str:
        return str(sorted(options.items()))


@pytest.fixture(scope="package")
def tabs(browser: Browser) -> Tabs:
    """Return the tabs of the browser."""
    return Tabs(browser)


@pytest.fixture(scope="package")
def browser() -> Iterator[Browser]:
    """Run a headless browser for all tests of the package."""
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
def opened(
    tabs: Tabs, request: pytest.FixtureRequest, served_with: Callable[..., Served]
) -> Iterator[Callable[..., Page]]:
    """Return a function that opens the page in its own tab and waits until its picture is complete.

    Pages load the modules of motions after their first picture, so servers must outlive their pages.
    """
    del served_with
    watches = []
    with ExitStack() as stack:

        def open_page(fragment: str = "", url: str | None = None, **options: Any) -> Page:
            address = url or request.getfixturevalue("explorer").url
            options.setdefault("viewport", {"width": 1280, "height": 800})
            # a frame of a disk takes 0.1 s without a graphics card, so motions stand until they are played
            options.setdefault("reduced_motion", "reduce")
            page, used = tabs.take(options)
            stack.callback(tabs.give_back, options, page, used)
            watches.append(Watch(page, (address,)))
            page.goto(address + (f"#{fragment}" if fragment else ""))
            page.wait_for_selector(COMPLETE)
            return page

        yield open_page
    problems = [problem for watch in watches for problem in watch.problems]
    assert problems == [], "\n".join(problems)
