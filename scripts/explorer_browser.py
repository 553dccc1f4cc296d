"""A real browser with the explorer's page: a headless Chromium, the server, and a watch for errors.

The tests in `tests/explorer/browser`, the random use and the recordings are based on this module.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import Browser, ConsoleMessage, Page, Request, Response

#: Names of the browser: first the headless one, which needs half the processor time of a whole browser, then Debian's.
BROWSERS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")

#: A container has neither user namespaces for the sandbox nor a graphics card for WebGL.
OPTIONS = ("--no-sandbox", "--enable-unsafe-swiftshader")

#: Selectors of the map, and of the map while its picture belongs to the view at full resolution.
MAP = "[data-lane]"
COMPLETE = f"{MAP}[data-lane=fine][aria-busy=false]"

_ADDRESS = re.compile(r"http://127\.0\.0\.1:\d+/[\w-]+/")

#: Messages of the graphics driver about its own speed, which a page cannot prevent.
_HARMLESS = re.compile(r"GL Driver Message|swiftshader", re.IGNORECASE)


def find_browser() -> str | None:
    """Return the path of an installed Chromium."""
    return next(filter(None, map(shutil.which, BROWSERS)), None)


@contextmanager
def launched(executable: str) -> Iterator[Browser]:
    """Run a headless browser that Playwright controls."""
    # imported here, so that tests can import this module and skip if Playwright is missing
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable, args=list(OPTIONS))
        try:
            yield browser
        finally:
            browser.close()


@dataclass(frozen=True)
class Served:
    """A server in its own process, as a user starts it."""

    url: str
    process: subprocess.Popen[str]

    @property
    def memory(self) -> float:
        """The server's present memory [MB], its own and shared."""
        return self._megabytes("VmRSS")

    @property
    def peak(self) -> float:
        """The largest memory [MB] that it has used."""
        return self._megabytes("VmHWM")

    def _megabytes(self, name: str) -> float:
        status = Path(f"/proc/{self.process.pid}/status").read_text(encoding="ascii")
        (kilobytes,) = re.findall(rf"{name}:\s+(\d+) kB", status)
        return int(kilobytes) / 1000


@contextmanager
def served(*words: str) -> Iterator[Served]:
    """Run ``eulerdisk explore`` with these words until the block ends; it may print nothing but its address.

    Raises
    ------
    RuntimeError
        If it prints no address, or an error while it runs.
    """
    command = (sys.executable, "-m", "sweep", "explore", *words, "--no-browser")
    with tempfile.TemporaryFile("w+", encoding="utf-8") as errors:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True, env=os.environ)
        assert process.stdout is not None
        try:
            found = _ADDRESS.search(process.stdout.readline())
            if found is None:
                process.wait(timeout=30)
                raise RuntimeError(f"The explorer printed no address: {_all(errors)}")
            yield Served(found[0], process)
        finally:
            process.terminate()
            process.wait(timeout=30)
            process.stdout.close()
        if "Traceback" in _all(errors):
            raise RuntimeError(f"The explorer printed an error:\n{_all(errors)}")


def _all(file: IO[str]) -> str:
    file.seek(0)
    return file.read()


@dataclass
class Watch:
    """A record of everything that must not happen in a page.

    These are messages in its console, uncaught exceptions, failed requests, and requests to addresses that do not start
    with one of `own`.
    """

    page: Page
    own: Sequence[str]
    problems: list[str] = field(default_factory=list)
    #: Unanswered requests, and the times at which they were sent (`time.monotonic`).
    under_way: dict[Request, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Start listening."""
        self.page.on("console", self._message)
        self.page.on("pageerror", lambda error: self.problems.append(f"exception: {error.stack or error}"))
        self.page.on("crash", lambda _: self.problems.append("the page has crashed"))
        self.page.on("request", self._request)
        self.page.on("requestfailed", self._note_failure)
        self.page.on("requestfinished", self._forget)
        self.page.on("response", self._response)

    def waits_for(self) -> list[str]:
        """Return the unanswered requests, oldest first: seconds, address and question."""
        now = time.monotonic()
        return [
            f"{now - since:.1f} s: {request.url.rsplit('/', 1)[-1]} {request.post_data or ''}".rstrip()
            for request, since in self.under_way.items()
        ]

    def _message(self, message: ConsoleMessage) -> None:
        if not _HARMLESS.search(message.text):
            self.problems.append(
                f"console, {message.type}: {message.text} ({message.location.get('url', '')})"
            )

    def _request(self, request: Request) -> None:
        self.under_way[request] = time.monotonic()
        if not request.url.startswith((*self.own, "data:", "blob:")):
            self.problems.append(f"a request to another address: {request.url}")

    def _forget(self, request: Request) -> None:
        self.under_way.pop(request, None)

    def _note_failure(self, request: Request) -> None:
        self._forget(request)
        # the page itself aborts requests whose answers have become useless
        if request.failure != "net::ERR_ABORTED":
            self.problems.append(f"a request failed: {request.url} {request.failure}")

    def _response(self, response: Response) -> None:
        if response.status >= 400:
            asked = response.request.post_data or ""
            self.problems.append(f"status {response.status}: {response.url} {asked}")
